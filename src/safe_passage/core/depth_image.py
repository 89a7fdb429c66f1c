"""The two encodings of depth images (REP 118)."""

from __future__ import annotations

import numpy as np

from safe_passage.core.errors import InputError


def metres(image: np.ndarray) -> np.ndarray:
    """Depth (H, W) float32 [m], NaN where there is none.

    Args:
        image: uint16 [mm], 0 = none (16UC1), or float32 [m], not finite = none (32FC1).

    Raises:
        InputError: it is neither.
    """
    if image.ndim == 2 and image.dtype == np.uint16:
        return np.where(image > 0, image * np.float32(1e-3), np.float32(np.nan))
    if image.ndim == 2 and image.dtype == np.float32:
        good = np.isfinite(image) & (image > 0.0)
        return image if good.all() else np.where(good, image, np.float32(np.nan))
    raise InputError(f"depth image {image.dtype} {image.shape}: must be 16UC1 or 32FC1")


def without(image: np.ndarray, removed: np.ndarray) -> np.ndarray:
    """A copy in the same encoding in which the pixels `removed` (H, W) bool have no depth."""
    cleared = image.copy()
    cleared[removed] = 0 if image.dtype == np.uint16 else np.nan
    return cleared
