"""What a sensor sees of the floor, for pictures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from safe_passage.monitoring.parameters import SourceParameters
from safe_passage.ros.sensor_conversions import Beams

SPACING = 0.05  # [rad] between the directions of an arc
SAMPLES = 2000  # points of a cloud that are looked at
ALL_AROUND = 6.0  # [rad] a cloud that spans more has no gap


@dataclass(frozen=True)
class FieldOfView:
    """A sector, frame base."""

    source: str
    origin: np.ndarray  # (2,) [m] of the sensor
    bearings: np.ndarray  # (N,) [rad] along the arc, from one side to the other
    reach: tuple[float, float]  # [m] nearest, farthest


def of_scan(beams: Beams, T_base_laser: np.ndarray, source: SourceParameters) -> FieldOfView:
    """Of a scanner, however it is mounted."""
    angles = beams.angles()
    step = max(1, int(SPACING / max(abs(beams.angle_increment), 1e-6)))
    angles = np.append(angles[::step], angles[-1])
    directions = np.stack([np.cos(angles), np.sin(angles)])
    x, y = T_base_laser[:2, :2] @ directions
    return _field(np.arctan2(y, x), T_base_laser, source)


def of_cloud(
    points: np.ndarray, T_base_sensor: np.ndarray, source: SourceParameters
) -> FieldOfView | None:
    """As far as the `points` (N, 3) [m], sensor's frame, reach to both sides; None: no points."""
    some = points[:: max(1, len(points) // SAMPLES)]
    some = some[np.isfinite(some).all(axis=1)]
    if not len(some):
        return None
    x, y = T_base_sensor[:2, :3] @ some.T
    bearings = np.arctan2(y, x)
    middle = np.angle(np.exp(1j * bearings).sum())
    offset = np.angle(np.exp(1j * (bearings - middle)))
    left, right = offset.max(), offset.min()
    if left - right > ALL_AROUND:
        left, right = np.pi, -np.pi
    arc = np.linspace(right, left, 2 + int((left - right) / SPACING))
    return _field(middle + arc, T_base_sensor, source)


def _field(bearings: np.ndarray, T: np.ndarray, source: SourceParameters) -> FieldOfView:
    return FieldOfView(source.name, T[:2, 3], bearings, (source.range_min, source.range_max))
