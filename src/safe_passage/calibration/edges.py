"""Pixels away from depth edges: at an edge sensors fray, smooth, and mix near with far."""

from __future__ import annotations

import cv2
import numpy as np


def away_from_edges(depth: np.ndarray, pixels: int, jump: float) -> np.ndarray:
    """(H, W) bool, the pixels whose neighbours all have a depth near the others'.

    Args:
        depth: (H, W) float32 [m]; not finite = none, which counts as an edge.
        pixels: from an edge.
        jump: [m] between neighbours that is one.
    """
    known = np.isfinite(depth)
    if pixels == 0:
        return known
    cross = np.ones((3, 3), np.uint8)
    nearest = cv2.erode(np.where(known, depth, 0.0).astype(np.float32), cross)
    farthest = cv2.dilate(np.where(known, depth, np.inf).astype(np.float32), cross)
    smooth = (farthest - nearest < jump).astype(np.uint8)
    wide = np.ones((2 * pixels - 1, 2 * pixels - 1), np.uint8)
    return cv2.erode(smooth, wide, borderType=cv2.BORDER_CONSTANT, borderValue=1).astype(bool)
