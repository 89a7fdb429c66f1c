"""Which pixels are the robot's."""

from __future__ import annotations

import cv2
import numpy as np

from safe_passage.self_filter.parameters import SelfFilterParameters

AROUND = [(dv, du) for dv in range(-2, 3) for du in range(-2, 3) if (dv, du) != (0, 0)]


def inside_robot(
    depth: np.ndarray, front: np.ndarray, back: np.ndarray, p: SelfFilterParameters
) -> np.ndarray:
    """Pixels (H, W) whose point lies between the padded robot's nearest and farthest surface.

    What is nearer is something before the robot. What is farther is kept as well: where the
    robot truly is, nothing behind it is measured, so that it was seen past the robot.

    Args:
        depth: (H, W) float32 [m], NaN = none.
        front, back: (H, W) float32 [m], +inf and -inf where the robot is not.
    """
    if p.edge:
        kernel = np.ones((2 * p.edge + 1, 2 * p.edge + 1), np.uint8)
        front, back = cv2.erode(front, kernel), cv2.dilate(back, kernel)
    noise = np.float32(p.depth_noise) * depth * depth
    return (depth >= front - noise) & (depth <= back + noise)


def slivers(
    depth: np.ndarray, removed: np.ndarray, front: np.ndarray, p: SelfFilterParameters
) -> np.ndarray:
    """Pixels (H, W) beside what is removed that no neighbour shares the depth of.

    They mix robot and background, as do those that a sensor's own smoothing leaves in the air.
    What is nearer than the robot stays, however thin: it may be a finger.

    Args:
        front: (H, W) float32 [m], of the padded robot.
    """
    if not p.sliver_support or not p.sliver_band or not removed.any():
        return np.zeros_like(removed)
    size = 2 * p.sliver_band + 1
    kernel = np.ones((size, size), np.uint8)
    band = cv2.dilate(removed.astype(np.uint8), kernel).astype(bool)
    v, u = np.nonzero(band & ~removed & np.isfinite(depth))
    kept = np.pad(np.where(removed, np.float32(np.nan), depth), 2, constant_values=np.nan)
    z = depth[v, u]
    alike = np.float32(p.sliver_depth) + np.float32(p.depth_noise) * z * z
    support = np.zeros(len(z), np.int32)
    for dv, du in AROUND:
        support += np.abs(kept[v + 2 + dv, u + 2 + du] - z) <= alike
    nearest = cv2.erode(front, kernel)[v, u]
    alone = (support < p.sliver_support) & (z > nearest - p.depth_noise * z * z)
    found = np.zeros_like(removed)
    found[v[alone], u[alone]] = True
    return found
