"""Poses and polygons in the plane. Metres, radians."""

from __future__ import annotations

import math
from typing import Tuple

import numpy as np

Pose = Tuple[float, float, float]  # x [m], y [m], yaw [rad]


def rotation(yaw: float) -> np.ndarray:
    """(2, 2)"""
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, -s], [s, c]])


def compose(a: Pose, b: Pose) -> Pose:
    """Pose b, given in frame a, in a's parent; its yaw in [-pi, pi]."""
    c, s = math.cos(a[2]), math.sin(a[2])
    yaw = math.remainder(a[2] + b[2], 2.0 * math.pi)
    return a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], yaw


def inverse(a: Pose) -> Pose:
    """The parent's pose in frame a."""
    c, s = math.cos(a[2]), math.sin(a[2])
    return -c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]


def matrix(pose: Pose) -> np.ndarray:
    """(4, 4) of a pose on the floor."""
    T = np.eye(4)
    T[:2, :2], T[:2, 3] = rotation(pose[2]), pose[:2]
    return T


def placed(points: np.ndarray, poses: Pose | np.ndarray) -> np.ndarray:
    """`points` (N, 2) of a body at `poses` (..., 3), in the poses' frame: (..., N, 2)."""
    at = np.asarray(poses, float)
    c, s = np.cos(at[..., 2:]), np.sin(at[..., 2:])
    x = at[..., :1] + c * points[:, 0] - s * points[:, 1]
    y = at[..., 1:2] + s * points[:, 0] + c * points[:, 1]
    return np.stack([x, y], axis=-1)


def outline(polygon: np.ndarray, spacing: float) -> np.ndarray:
    """Corners and points (N, 2) along the edges of `polygon` (M, 2), `spacing` apart at most."""
    points = []
    for start, end in zip(polygon, np.roll(polygon, -1, axis=0)):
        count = max(1, math.ceil(np.hypot(*(end - start)) / spacing))
        points.append(start + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * (end - start))
    return np.concatenate(points)
