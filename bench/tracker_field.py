"""A field of small objects around the robot, and what two scanners and two cameras give of it.

Nothing hides anything, so that each object gets its share of the points and every one is a track.
One object in ten moves to and fro in its own place. The robot drives in a circle.
"""

from __future__ import annotations

import math
from typing import Iterator, Sequence

import numpy as np
from safe_passage.core.geometry import Pose, compose, inverse, placed, rotation
from safe_passage.monitoring.aggregation import Measurement
from safe_passage.monitoring.parameters import CLOUD, SourceParameters, TrackerParameters
from safe_passage.monitoring.preprocessing import cloud_points, scan_points
from safe_passage.monitoring.views import ScanView

BEAMS = 1081
PIXELS = 20000
RATE = 40.0  # [Hz] of all sensors and cycles
RADIUS = 12.0  # [m] half the side of the grid
CLEAR = 1.3  # [m] around the robot's circle
CIRCLE, SPEED = 0.4, 0.2  # [m] radius, [m/s]
NEAR, WIDE = 5.0, 0.55  # [m], [rad] to each side that a camera sees
NOISE = 0.01  # [m]
MOVERS = 10  # one in so many
OBJECT = 0.07  # [m] radius
SOURCES = (
    SourceParameters("laser_front", range_max=25.0),
    SourceParameters("laser_rear", range_max=25.0),
    SourceParameters("camera_front", CLOUD, range_max=8.0, aggregate=1),
    SourceParameters("camera_rear", CLOUD, range_max=8.0, aggregate=1),
)


def parameters() -> TrackerParameters:
    """The defaults, with two scanners and two cameras."""
    outline = ((0.6, 0.36), (-0.6, 0.36), (-0.6, -0.36), (0.6, -0.36))
    return TrackerParameters(sources=SOURCES, footprint=outline, radius=RADIUS)


class Field:
    """Objects on a jittered grid.

    Args:
        count: of objects.
        seed: of places and noise.
    """

    def __init__(self, count: int, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        reach = RADIUS - CIRCLE - 0.3  # within the grid wherever the robot is and turns
        spacing = 2.0 * reach / math.sqrt(count)
        while True:
            axis = np.arange(-reach, reach, spacing)
            x, y = (one.ravel() for one in np.meshgrid(axis, axis))
            distance = np.hypot(x, y)
            free = np.flatnonzero((distance > CIRCLE + CLEAR) & (distance < reach))
            if len(free) >= count:
                break
            spacing *= 0.99
        chosen = self._rng.permutation(free)[:count]
        self._gap = max(0.5 * spacing - OBJECT - 0.12, 0.02)  # free on each side, a cell apart
        places = np.stack([x[chosen], y[chosen]], axis=1)
        self._places = places + self._rng.uniform(-0.3, 0.3, places.shape) * self._gap
        self._moves = np.arange(count) % MOVERS == 0
        self._phase = self._rng.uniform(0.0, 2.0 * math.pi, count)

    def objects(self, time: float) -> np.ndarray:
        """Middles (N, 2) [m] at `time` [s], frame of the odometry."""
        swing = 0.6 * self._gap * np.sin(0.8 / max(self._gap, 0.1) * time + self._phase)
        return self._places + (self._moves * swing)[:, None]

    def cycles(self, number: int, rate: float = RATE) -> Iterator[tuple[float, Pose, list]]:
        """Time, pose of base and raw measurements of each cycle."""
        for cycle in range(number):
            time = (cycle + 1) / rate
            turned = SPEED / CIRCLE * time
            pose = compose((0.0, 0.0, turned), (CIRCLE, 0.0, 0.5 * math.pi))
            middles = placed(self.objects(time), np.array(inverse(pose)))
            yield time, pose, self._measure(middles, cycle)

    def _measure(self, middles: np.ndarray, cycle: int) -> list[np.ndarray]:
        """Points (B, 2) of each scanner and (K, 3) of each camera, frame base."""
        scans = [self._scan(middles, sensor, cycle) for sensor in ((0.6, 0.36), (-0.6, -0.36))]
        return [*scans, *(self._cloud(middles, yaw) for yaw in (0.0, math.pi))]

    def _scan(self, middles: np.ndarray, sensor: Sequence[float], cycle: int) -> np.ndarray:
        """Each beam on an object, the next one each time; on the side that faces the scanner."""
        which = (cycle * BEAMS + np.arange(BEAMS)) % len(middles)
        return self._surface(middles[which], np.array(sensor))

    def _cloud(self, middles: np.ndarray, yaw: float) -> np.ndarray:
        ahead = middles @ rotation(yaw)
        seen = (np.abs(np.arctan2(ahead[:, 1], ahead[:, 0])) < WIDE) & (np.hypot(*ahead.T) < NEAR)
        if not seen.any():
            return np.empty((0, 3), np.float32)
        which = np.flatnonzero(seen)[np.arange(PIXELS) % seen.sum()]
        surface = self._surface(middles[which], np.zeros(2))
        z = self._rng.uniform(0.2, 1.2, (PIXELS, 1))
        return np.concatenate([surface, z], axis=1).astype(np.float32)

    def _surface(self, middles: np.ndarray, sensor: np.ndarray) -> np.ndarray:
        towards = np.arctan2(*(sensor - middles).T[::-1])
        angle = towards + self._rng.uniform(-1.2, 1.2, len(middles))
        points = middles + OBJECT * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return points + self._rng.normal(0.0, NOISE, points.shape)


def prepare(stamp: float, pose: Pose, raw: Sequence[np.ndarray]) -> list[Measurement]:
    """Measurements of a cycle, by the preprocessing that real ones go through.

    Beams that meet objects at random are no scan of any surface: the filter for outliers would
    take them away. So a scan is filtered like a real one, but the points are those without.
    """
    prepared = []
    for source, points in zip(SOURCES, raw):
        if source.type == CLOUD:
            points = cloud_points(points, np.eye(4), source)
        else:
            ranges = np.hypot(points[:, 0], points[:, 1])
            scan_points(ranges, -0.75 * math.pi, 1.5 * math.pi / (BEAMS - 1), np.eye(4), source)
            points = np.column_stack([points, np.zeros(len(points))])
        view = None if source.type == CLOUD else ScanView.of(points, (0.0, 0.0))
        prepared.append(Measurement(source.name, stamp, pose, points, view))
    return prepared
