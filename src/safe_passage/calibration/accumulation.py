"""Depth images of a camera and an arm that both stand still -> one with less noise."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from safe_passage.core.errors import InputError


def temporal_median(images: Sequence[np.ndarray], least_share: float) -> np.ndarray:
    """Median of each pixel over time (paper 000, 2.2): (H, W) float32 [m].

    Args:
        images: (H, W) [m] each, NaN = none.
        least_share: of the images in which a pixel must have a depth to have one in the end.

    Raises:
        InputError: there are no images, or they are not of one size.
    """
    if not len(images):
        raise InputError("no depth image to accumulate")
    if len({image.shape for image in images}) > 1:
        raise InputError(f"depth images of {sorted({image.shape for image in images})}")
    ordered = np.sort(np.stack(images).astype(np.float32), axis=0)  # NaN comes last
    known = np.isfinite(ordered).sum(axis=0)
    low, high = np.maximum(known - 1, 0) // 2, known // 2
    high = np.minimum(high, len(images) - 1)
    low = np.where(known % 2 == 0, np.maximum(known // 2 - 1, 0), high)
    pick = np.take_along_axis(ordered, np.stack([low, high]), axis=0).mean(axis=0)
    enough = known >= max(1.0, least_share * len(images))
    return np.where(enough, pick, np.float32(np.nan)).astype(np.float32)
