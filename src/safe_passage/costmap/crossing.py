"""Which cells beams truly pass through, where Bresenham's lines between cell centres miss them."""

from __future__ import annotations

import numpy as np


def crossed(centres: np.ndarray, ends: np.ndarray, size: float, max_range: float) -> np.ndarray:
    """Whether a beam passes right through a square cell and ends behind it.

    centres: (M, 2) middles of the cells and ends: (N, 2) ends of the beams, float64 metres from
    the sensor in the grid's axes; size: m, side of a cell; max_range: m, farther cells are not
    judged. Of all beams the nearest in bearing on either side is asked. Returns (M,) bool.
    """
    result = np.zeros(len(centres), dtype=bool)
    length = np.hypot(ends[:, 0], ends[:, 1])
    if not len(centres) or not length.any():
        return result
    bearing = np.arctan2(ends[:, 1], ends[:, 0])
    order = np.argsort(bearing)
    following = np.searchsorted(bearing[order], np.arctan2(centres[:, 1], centres[:, 0]))
    for neighbour in (following - 1, following % len(order)):
        beam = order[neighbour]
        direction = ends[beam] / np.maximum(length[beam], 1e-9)[:, None]
        slope = np.maximum(np.abs(direction), 1e-9)
        middle = centres * np.where(direction < 0, -1.0, 1.0)
        enters = ((middle - size / 2) / slope).max(axis=1)
        leaves = ((middle + size / 2) / slope).min(axis=1)
        result |= (leaves > 0) & (enters < leaves) & (leaves < length[beam])
    return result & (np.hypot(centres[:, 0], centres[:, 1]) < max_range)
