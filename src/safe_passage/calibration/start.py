"""Where to begin: what changes between the arm's poses is the arm.

A registration that begins too far off ends in the room behind. Between several poses only the arm
moves, so that pixels tell the two apart, in the sensor's images as in the model's.
"""

from __future__ import annotations

from typing import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

CHANGE = 0.06  # [m] nearer than in another pose: the arm has come before the room
LEAST = 20  # pixels by which a pose counts
TILT = 0.14  # [rad] by which the guess is turned, too, each way


def moving(depths: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Each image (H, W) [m] with what is farther away in another one; all of one image.

    Args:
        depths: NaN = none, +inf = nothing for certain.
    """
    if len(depths) < 2:
        return list(depths)
    farthest = np.fmax.reduce(np.stack(depths))
    return [np.where(one < farthest - CHANGE, one, np.float32(np.nan)) for one in depths]


def laid_on(sensor: Sequence[np.ndarray], model: Sequence[np.ndarray]) -> np.ndarray | None:
    """T_model_sensor (4, 4) that lays the poses' middles on each other; None: too few.

    Args:
        sensor, model: points (N, 3) [m] of each pose, in their own frames.
    """
    pairs = [(a, b) for a, b in zip(sensor, model) if min(len(a), len(b)) >= LEAST]
    if len(pairs) < 3:
        return None
    one = np.array([np.median(a, axis=0) for a, _ in pairs])
    two = np.array([np.median(b, axis=0) for _, b in pairs])
    turn, _ = Rotation.align_vectors(two - two.mean(axis=0), one - one.mean(axis=0))
    T = np.eye(4)
    T[:3, :3] = turn.as_matrix()
    T[:3, 3] = two.mean(axis=0) - T[:3, :3] @ one.mean(axis=0)
    return T


def around(T: np.ndarray) -> list[np.ndarray]:
    """The guess, and the same camera turned left, right, up and down."""
    found = [T]
    for vector in ((0, TILT, 0), (0, -TILT, 0), (TILT, 0, 0), (-TILT, 0, 0)):
        turned = T.copy()
        turned[:3, :3] = T[:3, :3] @ Rotation.from_rotvec(vector).as_matrix()
        found.append(turned)
    return found


def agreement(sensor: Sequence[np.ndarray], model: Sequence[np.ndarray], tolerance: float) -> float:
    """Share of the model's pixels at which the sensor measures the same depth.

    Args:
        sensor: (H, W) [m] of each pose, NaN = none.
        model: (H, W) [m] of each pose, +inf = none.
    """
    same = shown = 0
    for seen, drawn in zip(sensor, model):
        there = np.isfinite(drawn)
        with np.errstate(invalid="ignore"):
            same += int((np.abs(seen[there] - drawn[there]) < tolerance).sum())
        shown += int(there.sum())
    return same / max(1, shown)
