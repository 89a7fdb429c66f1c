"""The last measurements of every sensor, put together where the robot is now (paper 000, 3.2)."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Sequence

import numpy as np

from safe_passage.core.geometry import Pose, compose, inverse, rotation
from safe_passage.monitoring.parameters import SourceParameters
from safe_passage.monitoring.views import View


@dataclass(frozen=True)
class Measurement:
    """Obstacle points of one sensor at one time."""

    source: str  # name of the sensor
    stamp: float  # [s]
    pose: Pose  # of base in the odometry's frame at the stamp
    points: np.ndarray  # (N, 3) x, y, z [m], frame base at the stamp; a 4th column: 1 if shadowed
    view: View | None = None  # what its beams passed was free; None: nobody knows


@dataclass(frozen=True)
class Points:
    """All sensors' points, frame base now."""

    xyz: np.ndarray  # (N, 3) float32 [m]
    shadowed: np.ndarray  # (N,) bool: the object may go on behind a nearer one
    sensor: np.ndarray  # (N,) index of the source
    age: np.ndarray  # (N,) [s] since the point was measured
    fresh: np.ndarray  # (N,) bool: of the sensor's last measurement


class Aggregator:
    """Keeps each source's last measurements; a silent source's are dropped after its timeout."""

    def __init__(self, sources: Sequence[SourceParameters], aggregate: bool = True) -> None:
        self._sources = {source.name: (i, source) for i, source in enumerate(sources)}
        self._kept: dict[str, deque[Measurement]] = {
            source.name: deque(maxlen=source.aggregate if aggregate else 1) for source in sources
        }

    def add(self, measurement: Measurement) -> None:
        """Keep it; one that is not newer than its source's last is ignored."""
        kept = self._kept[measurement.source]
        if not kept or measurement.stamp > kept[-1].stamp:
            kept.append(measurement)

    def points(self, stamp: float, pose: Pose) -> Points:
        """Everything measured, seen from the robot at `pose` (odometry's frame) at `stamp` [s]."""
        moved, sensors, ages, fresh = [], [], [], []
        for name, kept in self._kept.items():
            index, source = self._sources[name]
            while kept and stamp - kept[0].stamp > source.timeout:
                kept.popleft()
            for measurement in kept:
                moved.append(_seen_from(pose, measurement))
                sensors.append(np.full(len(moved[-1]), index, np.int32))
                ages.append(np.full(len(moved[-1]), stamp - measurement.stamp, np.float32))
                fresh.append(np.full(len(moved[-1]), measurement is kept[-1]))
        if not moved:
            empty = np.empty(0)
            nobody = empty.astype(np.int32)
            none = empty.astype(bool)
            return Points(np.empty((0, 3), np.float32), none, nobody, empty, none)
        points = np.concatenate(moved)
        return Points(
            points[:, :3],
            points[:, 3] > 0.5,
            np.concatenate(sensors),
            np.concatenate(ages),
            np.concatenate(fresh),
        )

    def alive(self) -> tuple[str, ...]:
        """Sources whose measurements count at the last `points`."""
        return tuple(name for name, kept in self._kept.items() if kept)

    def reset(self) -> None:
        """Forget everything."""
        for kept in self._kept.values():
            kept.clear()


def _seen_from(pose: Pose, measurement: Measurement) -> np.ndarray:
    """The measurement's points (N, 4) float32 in the frame of base at `pose`."""
    x, y, yaw = compose(inverse(pose), measurement.pose)
    points = np.zeros((len(measurement.points), 4), np.float32)
    points[:, : measurement.points.shape[1]] = measurement.points
    turn, shift = rotation(yaw).T.astype(np.float32), np.array([x, y], np.float32)
    points[:, :2] = points[:, :2] @ turn + shift
    return points
