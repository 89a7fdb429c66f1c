"""Where each sensor of a robot sees, over the floor around it and at several heights.

Paper 000, section 2.1, chooses its sensors' places so: scanners that see all around, cameras for
what stands higher or hangs over.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Mapping, Sequence, Union

import numpy as np

from safe_passage.robot_model.robot import RobotModel
from safe_passage.simulation.raycast import box
from safe_passage.simulation.robots import CameraModel, LidarModel, Robot

BANDS: Mapping[str, tuple[float, float]] = {  # [m] over the floor
    "feet": (0.05, 0.30),
    "knees": (0.30, 0.80),
    "hips": (0.80, 1.20),
    "head": (1.20, 1.90),
}
SAMPLES = 4  # heights in a band; what is seen at one of them is seen
HOUSING = 0.05  # [m] a body so near around a sensor is its own
RESOLUTION = 0.1  # [m] of the map
LEAST_SECTOR = math.radians(2.0)  # smaller blind sectors are not told
Sensor = Union[LidarModel, CameraModel]


@dataclass(frozen=True)
class Body:
    """A box of the robot that hides what is behind it."""

    T_base_body: np.ndarray  # (4, 4)
    low: np.ndarray  # (3,) [m]
    high: np.ndarray  # (3,) [m]

    def hides(self, origin: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Which points (N, 3) [m] in base it hides from `origin` (3,)."""
        R, t = self.T_base_body[:3, :3], self.T_base_body[:3, 3]
        start = (origin - t) @ R
        if ((start > self.low - HOUSING) & (start < self.high + HOUSING)).all():
            return np.zeros(len(points), bool)
        ways = (points - t) @ R - start
        length = np.maximum(np.linalg.norm(ways, axis=1), 1e-9)
        reach = box(start, ways / length[:, None], self.low, self.high)
        return reach < length


@dataclass(frozen=True)
class Coverage:
    """Of a robot; B bands, S sensors, a map of rows x columns around base, row = y, from below."""

    sensors: tuple[str, ...]
    seen: np.ndarray  # (B, S, rows, columns) bool
    hidden: np.ndarray  # (S,) share of what a sensor reaches that the robot's own bodies hide
    inside: np.ndarray  # (rows, columns) bool: the robot's own place
    resolution: float  # [m] a cell

    @property
    def count(self) -> np.ndarray:
        """(B, rows, columns) how many sensors see it."""
        return self.seen.sum(axis=1)

    @property
    def middles(self) -> np.ndarray:
        """(rows, columns, 2) [m] in base."""
        side = self.inside.shape[0]
        at = (np.arange(side) + 0.5 - 0.5 * side) * self.resolution
        return np.stack(np.meshgrid(at, at), axis=-1)

    def share(self, band: int, radius: float, least: int = 1) -> float:
        """Of the cells within `radius` [m], but the robot's own, those that so many sensors see."""
        near = (np.linalg.norm(self.middles, axis=2) <= radius) & ~self.inside
        return float((self.count[band] >= least)[near].mean())

    def blind_sectors(self, band: int, distance: float) -> list[tuple[float, float]]:
        """From where to where [rad], counter-clockwise, nobody sees what is so far [m] from base.

        (-pi, pi): nobody sees anything.
        """
        bearings = np.arange(720) * math.radians(0.5) - math.pi
        places = distance * np.stack([np.cos(bearings), np.sin(bearings)], axis=1)
        index = np.floor(places / self.resolution + 0.5 * self.inside.shape[0]).astype(int)
        column, row = np.clip(index, 0, self.inside.shape[0] - 1).T
        blind = (self.count[band][row, column] == 0) & ~self.inside[row, column]
        return _runs(blind, bearings)


def cover(robot: Robot, bodies: Sequence[Body], radius: float = 5.0) -> Coverage:
    """Look from every sensor at every place.

    Args:
        bodies: of the robot, see `bodies_of`.
        radius: [m] half the side of the map.
    """
    side = 2 * math.ceil(radius / RESOLUTION)
    at = (np.arange(side) + 0.5 - 0.5 * side) * RESOLUTION
    x, y = (axis.ravel() for axis in np.meshgrid(at, at))
    sensors: list[Sensor] = [*robot.lidars, *robot.cameras]
    seen = np.zeros((len(BANDS), len(sensors), side * side), bool)
    reached, hidden = np.zeros((2, len(sensors)))
    for s, sensor in enumerate(sensors):
        T = sensor.pose_in_base()
        for b, (low, high) in enumerate(BANDS.values()):
            for z in _heights(sensor, low, high):
                points = np.column_stack([x, y, np.full(x.shape, z)])
                within = np.flatnonzero(_reaches(sensor, T, points))
                behind = np.zeros(len(within), bool)
                for body in bodies:
                    behind |= body.hides(T[:3, 3], points[within])
                seen[b, s, within[~behind]] = True
                reached[s] += len(within)
                hidden[s] += behind.sum()
    names = tuple(sensor.name for sensor in sensors)
    inside = _inside(np.array(robot.footprint), np.column_stack([x, y]))
    return Coverage(
        names,
        seen.reshape(len(BANDS), len(sensors), side, side),
        hidden / np.maximum(reached, 1),
        inside.reshape(side, side),
        RESOLUTION,
    )


def bodies_of(
    robot: Robot, model: RobotModel | None = None, positions: Mapping[str, float] | None = None
) -> list[Body]:
    """What of the robot hides its surroundings.

    Args:
        model: of its arm, where it has one; each link's box counts.
        positions: of the arm's joints [rad]; those of the robot's file by default.
    """
    found = []
    for part in robot.parts:
        size = np.array(part.size)
        T = np.eye(4)
        T[:3, 3] = part.x, part.y, part.z + 0.5 * size[2]
        found.append(Body(T, -0.5 * size, 0.5 * size))
    if model is None or robot.arm is None:
        return found
    told = dict(zip(robot.arm.joints or model.movable, robot.arm.positions))
    told = {**dict.fromkeys(model.movable, 0.0), **told, **(positions or {})}
    return found + links_of(model, told, robot.arm.pose_in_base())


def links_of(
    model: RobotModel, positions: Mapping[str, float], T_base_root: np.ndarray
) -> list[Body]:
    """A box around each link of a URDF."""
    return [
        Body(T_base_root @ T, surface.vertices.min(axis=0), surface.vertices.max(axis=0))
        for name, T in model.poses(positions).items()
        for surface in [model.links[name]]
        if len(surface.vertices)
    ]


def _heights(sensor: Sensor, low: float, high: float) -> list[float]:
    """[m] at which a band is looked at: a scanner sees its own height only."""
    if isinstance(sensor, LidarModel):
        return [sensor.z] if low <= sensor.z < high else []
    return (low + (np.arange(SAMPLES) + 0.5) * (high - low) / SAMPLES).tolist()


def _reaches(sensor: Sensor, T: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Which points (N, 3) in base lie in its field of view."""
    own = (points - T[:3, 3]) @ T[:3, :3]
    if isinstance(sensor, LidarModel):
        distance = np.hypot(own[:, 0], own[:, 1])
        turned = np.abs(np.arctan2(own[:, 1], own[:, 0])) <= 0.5 * sensor.field_of_view + 1e-9
        return turned & (distance >= sensor.range_min) & (distance <= sensor.range_max)
    x, y, z = own.T
    fx, fy, cx, cy = sensor.intrinsics
    near = (z >= sensor.range_min) & (z <= sensor.range_max)
    depth = np.where(near, z, 1.0)
    u, v = fx * x / depth + cx, fy * y / depth + cy
    return near & (u >= 0) & (u <= sensor.width - 1) & (v >= 0) & (v <= sensor.height - 1)


def _inside(polygon: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Which points (N, 2) lie in the polygon (M, 2): a beam to one side crosses it an odd time."""
    found = np.zeros(len(points), bool)
    x, y = points.T
    for (ax, ay), (bx, by) in zip(polygon, np.roll(polygon, -1, axis=0)):
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = ax + (y - ay) * (bx - ax) / (by - ay)
        found ^= ((ay > y) != (by > y)) & (x < crossing)
    return found


def _runs(blind: np.ndarray, bearings: np.ndarray) -> list[tuple[float, float]]:
    if blind.all():
        return [(-math.pi, math.pi)]
    start = int(np.flatnonzero(~blind)[0])  # so that no run goes over the end
    turned, at = np.roll(blind, -start), np.roll(bearings, -start)
    step = float(bearings[1] - bearings[0])
    edges = np.flatnonzero(np.diff(np.concatenate([[0], turned.astype(int), [0]])))
    runs = [(float(at[a]), float(at[b - 1]) + step) for a, b in zip(edges[::2], edges[1::2])]
    return sorted(run for run in runs if (run[1] - run[0]) % (2 * math.pi) >= LEAST_SECTOR)
