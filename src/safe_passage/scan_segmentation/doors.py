"""Doors in walls (the paper's future work): beams go through, walls end, the floor goes on."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
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
PAST = 0.05  # [m] beyond the wall's face: the beam passed its edge, if only to the frame's side
STEP = 0.05  # [m] in which open places are counted
OPEN_SHARE = 0.7  # of the width through which beams went
DEEP = 0.7  # [m] of a frame
BESIDE = 0.04  # [m] of a frame's points from the opening's edge
WALL = 0.05  # [m] of a wall's points from its plane
APART = 0.04  # [m] between the bounds of a width, from which on both are told
UPRIGHT = 0.1  # sine of a wall to the vertical


@dataclass(frozen=True)
class Door:
    """An opening in a wall. Frame: level."""

    middle: tuple[float, float, float]  # [m] on the ground, in the wall's face
    yaw: float  # [rad] of the way through, away from the scanner
    width: float  # [m] halfway between what beams passed and what they met
    height: float  # [m] likewise, inf: nothing above was seen
    thickness: float  # [m] of the frame, NaN: not seen
    least_width: float  # [m] through which beams passed: it is not narrower
    least_height: float  # [m] likewise
    passable_by: tuple[str, ...] = ()  # names of configurations

    @property
    def said_width(self) -> str:
        """For people: one figure, or both bounds where they are apart."""
        most = 2.0 * self.width - self.least_width
        if most - self.least_width < APART:
            return f"{self.width:.2f} m"
        return f"{self.least_width:.2f} to {most:.2f} m"


def fits_through(door: Door, robot: RobotConfiguration) -> bool:
    """Whether a robot that stands straight surely passes."""
    return door.least_width >= 2.0 * robot.box[1] and door.least_height >= robot.clearance


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
            names = tuple(name for name, robot in robots.items() if fits_through(door, robot))
            if not any(_same(door, other) for other in found):
                found.append(replace(door, passable_by=names))
    return found


def _in_wall(
    points: np.ndarray,
    height: np.ndarray,
    on_wall: np.ndarray,
    normal: np.ndarray,
    offset: float,
    survey: Survey,
) -> list[Door]:
    """Openings between points of the wall through which beams went near the floor.

    An edge lies between the last beam that met the wall and the first that passed it: as far apart
    as two lines of the scan where these run along the edge.
    """
    across = np.array([-normal[1], normal[0], 0.0]) / math.hypot(normal[0], normal[1])
    off = points @ normal + offset
    standing = on_wall & (height > BODY[0]) & (height < BODY[1])
    u_wall = np.sort(points[standing] @ across)
    beams = _past(points, off, offset, across, survey)
    u = points @ across
    gaps = np.flatnonzero((np.diff(u_wall) > WIDTHS[0]) & (np.diff(u_wall) < WIDTHS[1]))
    found = []
    for i in gaps:
        left, right = float(u_wall[i]), float(u_wall[i + 1])
        inside = (beams.u > left) & (beams.u < right)
        low = inside & (beams.v < BODY[1])
        through = low & beams.far
        bins = np.unique(np.floor((beams.u[through] - left) / STEP))
        if len(bins) < OPEN_SHARE * (right - left) / STEP or beams.v[through].min() > SILL:
            continue
        edge_points = np.abs(off) < WALL
        over = edge_points & (u > left + 0.1) & (u < right - 0.1) & (height > 0.5)
        if (over & (height < LEAST_HEIGHT)).sum() > 5:  # something closes it
            continue
        top = float(np.percentile(height[over], 1.0)) if over.sum() >= 5 else math.inf
        depth = _thickness(u, off, height, left, right, top)
        first, last = float(beams.u[low].min()), float(beams.u[low].max())
        highest = float(beams.v[inside & (beams.v < top)].max())
        base = across * 0.25 * (left + first + last + right) - normal * offset
        z = float(survey.ground.z(base[None, :2])[0])
        yaw = math.atan2(-normal[1], -normal[0])
        width, least = 0.5 * (right - left + last - first), last - first
        middle = (float(base[0]), float(base[1]), z)
        found.append(Door(middle, yaw, width, 0.5 * (top + highest), depth, least, highest))
    return found


@dataclass(frozen=True)
class _Beams:
    """Those that passed a wall's face, where they did."""

    u: np.ndarray  # (N,) [m] along the wall
    v: np.ndarray  # (N,) [m] over the ground
    far: np.ndarray  # (N,) bool: they went on far behind it


def _past(
    points: np.ndarray, off: np.ndarray, offset: float, across: np.ndarray, survey: Survey
) -> _Beams:
    beyond = off < -PAST
    at = points[beyond] * (offset / (offset - off[beyond]))[:, None]
    v = at[:, 2] - survey.ground.z(at[:, :2])
    over = v > -PAST
    return _Beams(at[over] @ across, v[over], off[beyond][over] < -BEHIND)


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
