"""A 2D scan cut out of a point cloud at the height of a lidar."""

from __future__ import annotations

import numpy as np


def virtual_scan(
    points: np.ndarray,
    angles: np.ndarray,
    z_low: float,
    z_high: float,
    max_range: float,
) -> np.ndarray:
    """Nearest point a beam in a band of heights.

    Args:
        points: (N, 3) [m], laser at the origin, x forward, z over the ground; NaN = no return.
        angles: (M,) [rad] of the beams, ascending and evenly spaced.
        z_low, z_high: [m] the band over the ground.
        max_range: [m]

    Returns:
        Ranges (M,) [m]. inf: the camera looks there and sees nothing in the band; NaN: it does not
        look there, so nothing is known.
    """
    seen = points[np.isfinite(points).all(axis=1)]
    step = angles[1] - angles[0]
    ranges = np.full(len(angles), np.nan)

    def beams(some: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        index = np.rint((np.arctan2(some[:, 1], some[:, 0]) - angles[0]) / step).astype(int)
        inside = (index >= 0) & (index < len(angles))
        return index[inside], inside

    ranges[beams(seen)[0]] = np.inf
    band = seen[(seen[:, 2] >= z_low) & (seen[:, 2] <= z_high)]
    index, inside = beams(band)
    distance = np.hypot(band[inside, 0], band[inside, 1])
    near = distance <= max_range
    np.minimum.at(ranges, index[near], distance[near])
    return ranges
