"""A grid that knows where it lies."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np


@dataclass(frozen=True)
class GridMap:
    """Occupied cells, axis-aligned in their frame."""

    occupied: np.ndarray  # (rows, columns) bool, row = y
    origin: tuple[float, float]  # [m] lower-left corner
    resolution: float  # [m] a cell

    def cells(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows, columns and whether inside, of `points` (..., 2) [m]; outside: cell (0, 0)."""
        rows, columns = self.occupied.shape
        column = np.floor((points[..., 0] - self.origin[0]) / self.resolution)
        row = np.floor((points[..., 1] - self.origin[1]) / self.resolution)
        inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
        return np.where(inside, row, 0).astype(int), np.where(inside, column, 0).astype(int), inside

    def at(self, points: np.ndarray, outside: bool) -> np.ndarray:
        """Whether `points` (..., 2) [m] are occupied; `outside`: what is beyond the border."""
        rows, columns, inside = self.cells(points)
        return np.where(inside, self.occupied[rows, columns], outside)

    def centres(self) -> np.ndarray:
        """Middles (N, 2) [m] of the occupied cells."""
        at = np.argwhere(self.occupied)[:, ::-1]
        return np.array(self.origin) + (at + 0.5) * self.resolution

    def distances(self) -> np.ndarray:
        """[m] from each cell's middle to the nearest occupied one's; large where none is."""
        free = (~self.occupied).astype(np.uint8)
        return cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * self.resolution

    def with_cells_of(self, points: np.ndarray) -> GridMap:
        """An otherwise empty grid of the same place with the cells of `points` (N, 2) [m]."""
        occupied = np.zeros_like(self.occupied)
        rows, columns, inside = self.cells(points)
        occupied[rows[inside], columns[inside]] = True
        return GridMap(occupied, self.origin, self.resolution)

    def coarser(self, resolution: float) -> GridMap:
        """The same area in cells of `resolution` [m], occupied if any part is."""
        size = np.array(self.occupied.shape) * self.resolution
        rows, columns = np.ceil(size / resolution - 1e-9).astype(int)
        empty = GridMap(np.zeros((rows, columns), bool), self.origin, resolution)
        nearly_half = (0.5 - 1e-6) * self.resolution
        corners = nearly_half * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
        return empty.with_cells_of((self.centres()[:, None] + corners).reshape(-1, 2))
