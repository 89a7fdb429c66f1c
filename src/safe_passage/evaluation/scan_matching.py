"""Where a scanner went, from its scans alone: for recordings without odometry, or with a late one.

Point-to-line ICP (Censi, "An ICP variant using a point-to-line metric", ICRA 2008) of each scan
against some earlier ones. What moves is outvoted: pairs that fit worse than most count nothing.
"""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np
from scipy.spatial import cKDTree

from safe_passage.core.geometry import Pose, compose, inverse, placed
from safe_passage.leg_detection.scan import Scan

SPACING = 0.04  # [m] between the points that are compared
REACH = (0.5, 0.3, 0.2, *(0.12,) * 9)  # [m] between a point and its line, from try to try
FITS = 0.85  # share of pairs that count: the others may have moved
NEIGHBOURS = 6  # points that make a line
KEYS = 8  # earlier scans that are kept
APART = 0.25  # [m], or so many radians, between two of them


def match_scans(
    scans: Sequence[Scan],
    mounting: Pose = (0.0, 0.0, 0.0),
    guess: Sequence[Pose] | None = None,
) -> np.ndarray:
    """The robot's way (K, 4): stamp [s], pose of base where the first one is the origin.

    Args:
        scans: in order of time.
        mounting: of the scanner in base.
        guess: of base at each scan, in any frame: how it may have moved from one to the next.
            Without, it is taken to go on as before.
    """
    poses: list[Pose] = []
    keys: list[tuple[Pose, np.ndarray]] = []
    reaches = REACH[2:] if guess else REACH
    for i, scan in enumerate(scans):
        points = placed(_thinned(scan), mounting)
        pose = _expected(poses)
        if guess and poses:
            pose = compose(poses[-1], compose(inverse(guess[i - 1]), guess[i]))
        if keys:
            pose = _matched(
                points, pose, np.concatenate([placed(p, at) for at, p in keys]), reaches
            )
        moved = compose(inverse(keys[-1][0]), pose) if keys else (math.inf, 0.0, 0.0)
        if max(math.hypot(*moved[:2]), abs(moved[2])) > APART:
            keys = [*keys[1 - KEYS :], (pose, points)]
        poses.append(pose)
    way = np.column_stack([[scan.stamp for scan in scans], np.array(poses)])
    way[:, 3] = np.unwrap(way[:, 3])
    return way


def _expected(poses: Sequence[Pose]) -> Pose:
    """As before, and on as from the one before that."""
    if len(poses) < 2:
        return poses[-1] if poses else (0.0, 0.0, 0.0)
    return compose(poses[-1], compose(inverse(poses[-2]), poses[-1]))


def _thinned(scan: Scan) -> np.ndarray:
    """(N, 2) [m] points, frame of the scanner, none two in one square."""
    beams, angles = scan.returns(), scan.angles()
    points = np.stack([np.cos(angles), np.sin(angles)], axis=1)[beams] * scan.ranges[beams, None]
    _, first = np.unique(np.floor(points / SPACING).astype(int), axis=0, return_index=True)
    return points[np.sort(first)]


def _matched(points: np.ndarray, pose: Pose, known: np.ndarray, reaches: Sequence[float]) -> Pose:
    """The pose at which `points` (N, 2), frame base, lie best on `known` (M, 2)."""
    tree = cKDTree(known)
    for reach in reaches:
        at = placed(points, pose)
        away, index = tree.query(at, k=NEIGHBOURS, distance_upper_bound=reach)
        near = np.isfinite(away).all(axis=1)
        if near.sum() < NEIGHBOURS:
            return pose
        at, lines = at[near], known[index[near]]
        middle = lines.mean(axis=1)
        spread = lines - middle[:, None]
        _, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", spread, spread))
        normal = axes[:, :, 0]
        off = ((at - middle) * normal).sum(axis=1)
        fits = np.abs(off) <= np.quantile(np.abs(off), FITS)
        arm = at - pose[:2]
        turn = normal[:, 1] * arm[:, 0] - normal[:, 0] * arm[:, 1]
        A = np.column_stack([normal, turn])[fits]
        dx, dy, dyaw = np.linalg.lstsq(A, -off[fits], rcond=None)[0]
        pose = (pose[0] + float(dx), pose[1] + float(dy), pose[2] + float(dyaw))
    return pose
