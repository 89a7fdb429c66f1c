"""Doors in walls (the paper's future work): beams go through, walls end, the floor goes on."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Mapping

import numpy as np

from safe_passage.scan_segmentation.basic_map import Survey
from safe_passage.scan_segmentation.parameters import RobotConfiguration
from safe_passage.scan_segmentation.scan import Level
from safe_passage.scan_segmentation.validation import ValidPlane

WIDTHS = (0.45, 2.2)  # [m]
BODY = (0.15, 1.7)  # [m] over the ground at which a door is open, and the wall beside it is not
SILL = 0.40  # [m] beams must go through lower than this: a window's do not
LEAST_HEIGHT = 1.5  # [m]
BEHIND = 0.5  # [m] beyond the wall: the beam went through; a closed door's does not
STEP = 0.05  # [m] in which open places are counted
OPEN_SHARE = 0.7  # of the width through which beams went
DEEP = 0.7  # [m] of a frame
BESIDE = 0.04  # [m] of a frame's points from the opening's edge
WALL = 0.05  # [m] of a wall's points from its plane
UPRIGHT = 0.1  # sine of a wall to the vertical


@dataclass(frozen=True)
class Door:
    """An opening in a wall. Frame: level."""

    middle: tuple[float, float, float]  # [m] on the ground, in the wall's face
    yaw: float  # [rad] of the way through, away from the scanner
    width: float  # [m]
    height: float  # [m], inf: nothing above was seen
    thickness: float  # [m] of the frame, NaN: not seen
    passable_by: tuple[str, ...] = ()  # names of configurations


def fits_through(door_width: float, door_height: float, robot: RobotConfiguration) -> bool:
    """Whether a robot passes that stands straight."""
    return door_width >= 2.0 * robot.box[1] and door_height >= robot.clearance


def find_doors(
    survey: Survey,
    level: Level,
    planes: list[ValidPlane],
    labels: np.ndarray,
    robots: Mapping[str, RobotConfiguration],
) -> list[Door]:
    """Of all upright planes."""
    known = np.isfinite(survey.points).all(axis=2)
    points, own = survey.points[known], labels[known]
    height = survey.height[known]
    found: list[Door] = []
    for k, valid in enumerate(planes):
        normal = level.R_level_scan @ valid.plane.normal
        if abs(normal[2]) > UPRIGHT:
            continue
        offset = float(valid.plane.distance(level.origin))
        for door in _in_wall(points, height, own == k, normal, offset, survey):
            names = tuple(n for n, r in robots.items() if fits_through(door.width, door.height, r))
            if not any(_same(door, other) for other in found):
                found.append(Door(**{**door.__dict__, "passable_by": names}))
    return found


def _in_wall(
    points: np.ndarray,
    height: np.ndarray,
    on_wall: np.ndarray,
    normal: np.ndarray,
    offset: float,
    survey: Survey,
) -> list[Door]:
    """Openings between points of the wall through which beams went near the floor."""
    across = np.array([-normal[1], normal[0], 0.0]) / math.hypot(normal[0], normal[1])
    off = points @ normal + offset
    standing = on_wall & (height > BODY[0]) & (height < BODY[1])
    u_wall = np.sort(points[standing] @ across)
    beyond = off < -BEHIND
    through = points[beyond] * (offset / (offset - off[beyond]))[:, None]
    u_through = through @ across
    v_through = through[:, 2] - survey.ground.z(through[:, :2])
    low = (v_through > -0.05) & (v_through < BODY[1])
    gaps = np.flatnonzero((np.diff(u_wall) > WIDTHS[0]) & (np.diff(u_wall) < WIDTHS[1]))
    found = []
    for i in gaps:
        left, right = float(u_wall[i]), float(u_wall[i + 1])
        inside = low & (u_through > left) & (u_through < right)
        bins = np.unique(np.floor((u_through[inside] - left) / STEP))
        if len(bins) < OPEN_SHARE * (right - left) / STEP or v_through[inside].min() > SILL:
            continue
        edge_points = np.abs(off) < WALL
        u = points @ across
        over = edge_points & (u > left + 0.1) & (u < right - 0.1) & (height > 0.5)
        if (over & (height < LEAST_HEIGHT)).sum() > 5:  # something closes it
            continue
        top = float(np.percentile(height[over], 1.0)) if over.sum() >= 5 else math.inf
        depth = _thickness(u, off, height, left, right, top)
        base = across * 0.5 * (left + right) - normal * offset
        z = float(survey.ground.z(base[None, :2])[0])
        yaw = math.atan2(-normal[1], -normal[0])
        found.append(Door((float(base[0]), float(base[1]), z), yaw, right - left, top, depth))
    return found


def _thickness(
    u: np.ndarray, off: np.ndarray, height: np.ndarray, left: float, right: float, top: float
) -> float:
    """[m] that the opening's sides reach behind the wall's face; NaN: no side was seen."""
    beside = (np.abs(u - left) < BESIDE) | (np.abs(u - right) < BESIDE)
    side = beside & (height > BODY[0]) & (height < min(top, 2.0) - 0.05)
    depths = np.sort(-off[side & (off > -DEEP) & (off < -0.01)])
    if len(depths) < 10:
        return math.nan
    ends = np.flatnonzero(np.diff(depths) > 0.08)  # beyond a gap is another thing
    last = ends[0] if len(ends) else len(depths) - 1
    return float(depths[max(0, int(0.99 * last))]) if last >= 5 else math.nan


def _same(a: Door, b: Door) -> bool:
    """The other face of the same wall, or of the same door."""
    return math.hypot(a.middle[0] - b.middle[0], a.middle[1] - b.middle[1]) < 0.5
