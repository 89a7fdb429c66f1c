"""Connected components of the obstacle cells (paper 000, 4.1)."""

from __future__ import annotations

import cv2
import numpy as np

from safe_passage.monitoring.features import LEAST_NEW, MOSTLY
from safe_passage.monitoring.fusion_grid import FusionGrid

STRIDE = 0.24  # [m] between two legs, at most


def cluster(
    grid: FusionGrid, min_points: int, body: float, walker: float, walkers: np.ndarray
) -> np.ndarray:
    """Cluster (K,) of each obstacle cell by 8-adjacency, numbered from 0; -1: too few points.

    What has come to something larger than a body is a cluster of its own, and what has come side by
    side and is no larger than a walker is one, the legs, unless it is known to be two.

    Args:
        body: [m] size of a cluster that may be one person's legs.
        walker: [m] so long is one in stride, in scans that are put together.
        walkers: (W, 2) [m] where those are expected who are known to walk, frame base.
    """
    if not len(grid.cell):
        return np.empty(0, np.int64)
    label = _components(grid, np.ones(len(grid.cell), bool))[grid.cell]
    label = _without_newcomers(grid, label, body)
    label = _with_both_legs(grid, label, walker, walkers)
    points = np.bincount(label, weights=grid.counts.sum(axis=1))
    enough = (points >= min_points) & ~_gone(grid, label)
    number = np.where(enough, np.cumsum(enough) - 1, -1)
    return number[label]


def sizes(grid: FusionGrid, clusters: np.ndarray, count: int) -> np.ndarray:
    """(count,) [m] diagonal of the box around each cluster's cells; `clusters` (K,), -1: none."""
    order = np.argsort(clusters, kind="stable")
    order = order[np.searchsorted(clusters[order], 0) :]
    if not count:
        return np.empty(0)
    start = np.searchsorted(clusters[order], np.arange(count))
    at = grid.position[order]
    span = np.maximum.reduceat(at, start) - np.minimum.reduceat(at, start)
    return np.hypot(span[:, 0], span[:, 1])


def _components(grid: FusionGrid, which: np.ndarray, gap: int = 0) -> np.ndarray:
    """Component (side * side,) of the grid's cells around `which` (K,) obstacle cells; -1: none.

    Cells with up to `gap` (even) free ones between them belong together.
    """
    image = np.zeros(grid.side**2, np.uint8)
    image[grid.cell[which]] = 1
    image = image.reshape(grid.side, grid.side)
    if gap:
        image = cv2.dilate(image, np.ones((gap + 1, gap + 1), np.uint8))
    return cv2.connectedComponents(image, connectivity=8)[1].ravel().astype(np.int64) - 1


def _without_newcomers(grid: FusionGrid, label: np.ndarray, body: float) -> np.ndarray:
    """The components `label` (K,), with what is new in large ones numbered on behind them."""
    count = int(label.max()) + 1
    old = np.bincount(label, ~grid.new, minlength=count) >= LEAST_NEW
    candidates = grid.new & (old & (sizes(grid, label, count) > body))[label]
    if not candidates.any():
        return label
    newcomer = np.where(candidates, _components(grid, candidates)[grid.cell], -1)
    many = np.bincount(newcomer[candidates]) >= LEAST_NEW
    own = candidates & many[newcomer]
    return np.where(own, count + np.cumsum(many)[newcomer] - 1, label)


def _with_both_legs(
    grid: FusionGrid, label: np.ndarray, largest: float, walkers: np.ndarray
) -> np.ndarray:
    """The clusters `label` (K,), with those put together that have come side by side."""
    came = (np.bincount(label, grid.new) / np.maximum(np.bincount(label), 1) >= MOSTLY)[label]
    if not came.any():
        return label
    components = _components(grid, came, 2 * round(0.5 * STRIDE / grid.resolution))
    group = np.where(came, components[grid.cell], -1)
    count = int(components.max()) + 1
    at = grid.cells_of(walkers)
    here = components[at[at >= 0]]
    one = np.bincount(here[here >= 0], minlength=count) < 2
    joined = came & (one & (sizes(grid, group, count) <= largest))[group]
    return np.unique(np.where(joined, int(label.max()) + 1 + group, label), return_inverse=True)[1]


def _gone(grid: FusionGrid, label: np.ndarray) -> np.ndarray:
    """Which clusters have just come and left again: the sensors' last measurements lack them."""
    number = np.bincount(label)
    came = np.bincount(label, grid.new) >= MOSTLY * number
    return came & (np.bincount(label, np.isfinite(grid.fresh[:, 2])) == 0)
