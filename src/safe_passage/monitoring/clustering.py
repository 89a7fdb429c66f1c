"""Connected components of the obstacle cells (paper 000, 4.1)."""

from __future__ import annotations

import cv2
import numpy as np

from safe_passage.monitoring.fusion_grid import FusionGrid


def cluster(grid: FusionGrid, min_points: int) -> np.ndarray:
    """Cluster (K,) of each obstacle cell by 8-adjacency, numbered from 0; -1: too few points."""
    if not len(grid.cell):
        return np.empty(0, np.int64)
    image = np.zeros(grid.side**2, np.uint8)
    image[grid.cell] = 1
    _, labels = cv2.connectedComponents(image.reshape(grid.side, grid.side), connectivity=8)
    label = labels.ravel()[grid.cell] - 1
    points = np.bincount(label, weights=grid.counts.sum(axis=1))
    enough = points >= min_points
    number = np.where(enough, np.cumsum(enough) - 1, -1)
    return number[label]
