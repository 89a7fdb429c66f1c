"""Sensor readings to points, with the float32 rounding of laser_geometry and tf2_sensor_msgs.

Rounding matters: a wall that lies on a cell border falls to one side or the other by it.
"""

from __future__ import annotations

from typing import Sequence

import numpy as np

NO_RETURN_MARGIN = np.float32(
    1e-4
)  # m below range_max, where costmap_2d puts a beam without return


def project_scan(
    ranges: np.ndarray,
    angle_min: float,
    angle_increment: float,
    range_min: float,
    range_max: float,
    inf_is_valid: bool = False,
) -> np.ndarray:
    """Points of a laser scan in the laser's frame.

    ranges: (N,) metres; angles in rad. Beams with NaN, below range_min or not below range_max give
    no point; +inf gives one just before range_max when `inf_is_valid`.
    Returns (M, 3) float32 metres, z = 0.
    """
    ranges = np.array(ranges, dtype=np.float32)
    range_max32 = np.float32(range_max)
    if inf_is_valid:
        ranges[np.isposinf(ranges)] = range_max32 - NO_RETURN_MARGIN
    with np.errstate(invalid="ignore"):
        keep = (ranges < range_max32) & (ranges >= np.float32(range_min))
    beams = np.flatnonzero(keep)
    angles = float(np.float32(angle_min)) + beams * float(np.float32(angle_increment))
    kept = ranges[beams].astype(np.float64)
    points = np.zeros((beams.size, 3), dtype=np.float32)
    points[:, 0] = kept * np.cos(angles)
    points[:, 1] = kept * np.sin(angles)
    return points


def transform_points(
    points: np.ndarray, translation: Sequence[float], quaternion_xyzw: Sequence[float]
) -> np.ndarray:
    """Points moved into another frame, computed in float32.

    points: (N, 3) metres, NaN stays NaN; translation in metres; unit quaternion x, y, z, w.
    Returns (N, 3) float32.
    """
    x, y, z = np.asarray(points, dtype=np.float32).T
    rotation = _rotation_matrix(quaternion_xyzw)
    shift = np.asarray(translation, dtype=np.float32)
    moved = np.empty((x.size, 3), dtype=np.float32)
    with np.errstate(invalid="ignore", over="ignore"):
        for axis in range(3):
            row = rotation[axis]
            moved[:, axis] = (row[0] * x + row[1] * y + row[2] * z) + shift[axis]
    return moved


def _rotation_matrix(quaternion_xyzw: Sequence[float]) -> np.ndarray:
    """(3, 3) float32 rotation, with every intermediate in float32."""
    x, y, z, w = np.asarray(quaternion_xyzw, dtype=np.float32)
    two, one = np.float32(2), np.float32(1)
    tx, ty, tz = two * x, two * y, two * z
    return np.array(
        [
            [one - (ty * y + tz * z), ty * x - tz * w, tz * x + ty * w],
            [ty * x + tz * w, one - (tx * x + tz * z), tz * y - tx * w],
            [tz * x - ty * w, tz * y + tx * w, one - (tx * x + ty * y)],
        ],
        dtype=np.float32,
    )


def yaw_quaternion(yaw: float) -> tuple[float, float, float, float]:
    """Quaternion (x, y, z, w) of a turn about z by `yaw` rad."""
    return 0.0, 0.0, float(np.sin(yaw / 2)), float(np.cos(yaw / 2))


def quaternion_yaw(quaternion_xyzw: Sequence[float]) -> float:
    """Heading in rad of a frame's x axis seen from above; quaternion as x, y, z, w.

    >>> round(quaternion_yaw(yaw_quaternion(-2.5)), 6)
    -2.5
    """
    x, y, z, w = quaternion_xyzw
    return float(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
