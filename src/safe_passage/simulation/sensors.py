"""What sensors make of exact ranges and depths: noise, quantisation, shadows, lost returns."""

from __future__ import annotations

import numpy as np

from safe_passage.simulation.robots import CameraModel, LidarModel


def measured_ranges(exact: np.ndarray, lidar: LidarModel, rng: np.random.Generator) -> np.ndarray:
    """Ranges (N,) float32 [m] of a scan; inf: no return (REP 117), also nearer than range_min."""
    ranges = exact + rng.normal(0.0, lidar.noise, exact.shape)
    lost = rng.random(exact.shape) < lidar.dropout
    outside = ~((ranges >= lidar.range_min) & (ranges <= lidar.range_max))
    ranges[lost | outside] = np.inf
    return ranges.astype(np.float32)


def measured_depth(exact: np.ndarray, camera: CameraModel, rng: np.random.Generator) -> np.ndarray:
    """Depth (H, W) float32 [m] of a structured-light camera; NaN: no return.

    Disparity, baseline * focal / depth, is what such a camera measures: its noise and steps are
    even, so that the depth's grow with the square of the depth (Khoshelham and Elberink, Sensors
    2012). Edges fray by a pixel (Nguyen et al., 3DIMPVT 2012), and what the projector, beside the
    camera, cannot light has no depth.
    """
    height, width = exact.shape
    disparity = _frayed(camera.focal * camera.baseline / exact.astype(np.float32), rng)
    lit = ~_shadowed(disparity)
    if camera.disparity_noise > 0.0:
        noise = rng.standard_normal(disparity.shape, np.float32)
        disparity = disparity + np.float32(camera.disparity_noise) * noise
    if camera.disparity_step > 0.0:
        disparity = np.rint(disparity / camera.disparity_step) * camera.disparity_step
    with np.errstate(divide="ignore"):
        depth = np.float32(camera.focal * camera.baseline) / disparity
    valid = lit & (depth >= camera.range_min) & (depth <= camera.range_max)
    return np.where(valid, depth, np.nan).astype(np.float32)


def measured_colour(exact: np.ndarray, camera: CameraModel, rng: np.random.Generator) -> np.ndarray:
    """Picture (H, W, 3) uint8 with the noise of a small sensor."""
    if camera.colour_noise == 0.0:
        return exact
    noise = rng.standard_normal(exact.shape[:2], np.float32)[..., None]
    return np.clip(exact + np.float32(camera.colour_noise) * noise, 0, 255).astype(np.uint8)


def _frayed(disparity: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Each pixel takes its own or, one time in four each way, a neighbour's value."""
    height, width = disparity.shape
    draws = rng.integers(0, 16, disparity.shape, dtype=np.int32)
    step = np.array([-1, 0, 0, 1], np.int32)
    rows = np.clip(np.arange(height, dtype=np.int32)[:, None] + step[draws >> 2], 0, height - 1)
    columns = np.clip(np.arange(width, dtype=np.int32) + step[draws & 3], 0, width - 1)
    return disparity.ravel()[rows * width + columns]


def _shadowed(disparity: np.ndarray) -> np.ndarray:
    """What the projector, to the camera's left, cannot see.

    A pixel u lies in the shadow of u' < u when d(u') - d(u) > u - u': its ray to the projector
    crosses the nearer surface. So u is lit where d + u is the largest so far along its row.
    """
    height, width = disparity.shape
    reach = disparity + np.arange(width, dtype=np.float32)
    return np.maximum.accumulate(reach, axis=1) > reach + 1.0  # a pixel of tolerance
