"""The robot's shape, and where it will be: along its path, or along the arc of its command.

Frame: base, as it is now. A motion is measured in u [s], the time that it takes at the full
command; a robot that is slowed down to the scale s comes to u = s t.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence, Tuple

import numpy as np

from safe_passage._separation import RobotShape
from safe_passage.separation.parameters import SeparationParameters

Velocity = Tuple[float, float, float]  # forward [m/s], left [m/s], turn [rad/s]

STRIDE = 0.15  # [m] between two poses of a motion, at a distance of ARM [m] from base's origin
ARM = 0.7
STILL = 1e-3  # [m/s], [rad/s] slower is standing


@dataclass(frozen=True)
class Part:
    """A capsule beside the platform, such as a link of an arm, as seen from above."""

    start: tuple[float, float]  # [m] base
    end: tuple[float, float]  # [m] base; the start's for a disc
    radius: float  # [m]


@dataclass(frozen=True)
class RobotState:
    """What the robot does and is about to do."""

    twist: Velocity = (0.0, 0.0, 0.0)  # measured, base
    path: np.ndarray | None = None  # (K, 2 or, with yaw, 3) [m, rad] planned, base
    parts: Sequence[Part] = ()


@dataclass(frozen=True)
class Shape:
    """The platform, a polygon or a disc, and parts beside it."""

    corners: np.ndarray  # (C, 2) [m] of the platform; C = 1: a disc's middle
    padding: float  # [m] around it
    parts: Sequence[Part]
    reach: float  # [m] from base's origin to the farthest point
    kernel: RobotShape  # knows the distances

    def distance(self, points: np.ndarray) -> np.ndarray:
        """(P,) [m] to `points` (P, 2) in the robot's frame; inside negative, as deep as it is."""
        return self.kernel.distance(points)


def make_shape(p: SeparationParameters, parts: Sequence[Part] = ()) -> Shape:
    """Platform and parts."""
    corners = np.array(p.footprint or [(0.0, 0.0)], float)
    padding = p.footprint_padding + p.robot_radius
    reach = float(np.hypot(corners[:, 0], corners[:, 1]).max()) + padding
    for part in parts:
        reach = max(reach, max(math.hypot(*part.start), math.hypot(*part.end)) + part.radius)
    limbs = np.array([(*part.start, *part.end, part.radius) for part in parts]).reshape(-1, 5)
    return Shape(corners, padding, parts, reach, RobotShape(corners, padding, limbs))


@dataclass(frozen=True)
class Motion:
    """Poses of base by u."""

    u: np.ndarray  # (K,) [s] evenly spaced from 0
    poses: np.ndarray  # (K, 3) [m, rad]
    on_path: bool  # follows the planned path
    speed: float  # [m/s] of the full command
    turn: float  # [rad/s] of the full command, not negative

    def at(self, u: np.ndarray) -> np.ndarray:
        """(..., 3) poses."""
        return np.stack([np.interp(u, self.u, column) for column in self.poses.T], axis=-1)

    @property
    def stands(self) -> bool:
        """Nothing is commanded."""
        return self.speed < STILL and self.turn < STILL


def plan_motion(
    command: Velocity, path: np.ndarray | None, reach: float, p: SeparationParameters
) -> Motion:
    """How the robot goes on under `command`, up to u = `reach` [s].

    Along the path, if the command follows it; else on the arc of the command.
    """
    speed, turn = math.hypot(command[0], command[1]), abs(command[2])
    u = np.linspace(0.0, reach, 2 + math.ceil(reach * (speed + turn * ARM) / STRIDE))
    way = _way_ahead(path, p) if path is not None and speed >= STILL else None
    if way is None or not _follows(command, way, p):
        return Motion(u, _arc(command, u), False, speed, turn)
    facing = -math.atan2(command[1], command[0])
    return Motion(u, _along(way, speed * u, facing), True, speed, turn)


def _arc(command: Velocity, u: np.ndarray) -> np.ndarray:
    """(K, 3) poses after u [s] of a constant twist."""
    vx, vy, w = command
    yaw = w * u
    # sin(yaw) / w and (1 - cos(yaw)) / w, which stay finite for w = 0
    ahead = u * np.sinc(yaw / math.pi)
    aside = 0.5 * yaw * u * np.sinc(0.5 * yaw / math.pi) ** 2
    return np.stack([vx * ahead - vy * aside, vy * ahead + vx * aside, yaw], axis=1)


def _way_ahead(path: np.ndarray, p: SeparationParameters) -> np.ndarray | None:
    """The rest of the path (L, 2 or 3), from the robot on; None if the robot has left it."""
    points = path[np.isfinite(path).all(axis=1)]
    if len(points) < 2:
        return None
    start, along = points[:-1, :2], np.diff(points[:, :2], axis=0)
    length = np.maximum((along**2).sum(axis=1), 1e-12)
    share = np.clip(-(start * along).sum(axis=1) / length, 0.0, 1.0)
    nearest = start + share[:, None] * along
    away = np.hypot(nearest[:, 0], nearest[:, 1])
    i = int(away.argmin())
    if away[i] > p.path_tolerance:
        return None
    rest = points[i + 1 :]
    # back onto the path at a slant, not at a right angle
    rest = rest[np.hypot(rest[:, 0], rest[:, 1]) > 2.0 * away[i]]
    here = np.zeros((1, points.shape[1]))
    way = np.concatenate([here, rest])
    steps = np.hypot(*np.diff(way[:, :2], axis=0).T)
    way = way[np.concatenate([[True], steps > 1e-6])]
    return way if len(way) > 1 else None


def _follows(command: Velocity, way: np.ndarray, p: SeparationParameters) -> bool:
    """Whether the command points along the way's beginning, forwards or backwards.

    A robot that drives off beside its path is judged by what it does, not by what it planned.
    """
    ahead = way[min(len(way) - 1, 1 + int(np.argmax(np.hypot(*way[1:, :2].T) > 0.2)))]
    off = math.atan2(ahead[1], ahead[0]) - math.atan2(command[1], command[0])
    return abs(math.remainder(off, 2.0 * math.pi)) <= p.path_angle


def _along(way: np.ndarray, covered: np.ndarray, facing: float) -> np.ndarray:
    """(K, 3) poses after `covered` (K,) [m] of the way; the robot stays at its end.

    facing: [rad] its heading in the way's direction, unless the way has headings of its own.
    """
    steps = np.diff(way[:, :2], axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    at = np.concatenate([[0.0], np.cumsum(lengths)])
    x, y = (np.interp(covered, at, way[:, i]) for i in (0, 1))
    if way.shape[1] == 3:
        yaw = np.interp(covered, at, np.unwrap(way[:, 2]))
        return np.stack([x, y, yaw], axis=1)
    heading = np.arctan2(steps[:, 1], steps[:, 0]) + facing
    middle = 0.5 * (at[:-1] + at[1:])
    first = math.remainder(heading[0], 2.0 * math.pi)
    turned = np.unwrap(np.concatenate([[0.0, first], heading[1:]]))
    yaw = np.interp(covered, np.concatenate([[0.0], middle]), turned)
    return np.stack([x, y, yaw], axis=1)
