"""A window of cells that rolls over the global frame."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Tuple

import numpy as np

EVERYWHERE = math.inf
CellBox = Tuple[int, int, int, int]  # first column, end column, first row, end row


@dataclass(frozen=True)
class Box:
    """Axis-aligned rectangle in the global frame, in metres; empty until something is joined."""

    min_x: float = EVERYWHERE
    min_y: float = EVERYWHERE
    max_x: float = -EVERYWHERE
    max_y: float = -EVERYWHERE

    @classmethod
    def everywhere(cls) -> Box:
        return cls(-EVERYWHERE, -EVERYWHERE, EVERYWHERE, EVERYWHERE)

    def joined(self, other: Box) -> Box:
        return Box(
            min(self.min_x, other.min_x),
            min(self.min_y, other.min_y),
            max(self.max_x, other.max_x),
            max(self.max_y, other.max_y),
        )

    def touching(self, x: np.ndarray, y: np.ndarray) -> Box:
        """Grown to hold the finite points (x, y)."""
        if np.size(x) == 0:
            return self
        return self.joined(
            Box(float(np.min(x)), float(np.min(y)), float(np.max(x)), float(np.max(y)))
        )

    def padded(self, margin: float) -> Box:
        return Box(
            self.min_x - margin, self.min_y - margin, self.max_x + margin, self.max_y + margin
        )


class RollingGrid:
    """Costs of a rectangular window, aligned to the cells it started with.

    `cells` is (rows, columns) uint8, row = y, column = x; (origin_x, origin_y) is the lower-left
    corner in the global frame in metres.
    """

    def __init__(
        self, shape: tuple[int, int], resolution: float, origin: tuple[float, float], default: int
    ) -> None:
        self.cells = np.full(shape, default, dtype=np.uint8)
        self.resolution = float(resolution)
        self.origin_x, self.origin_y = map(float, origin)
        self.default = default

    def roll_around(self, x: float, y: float) -> None:
        """Move the window by whole cells so that (x, y) lies near its middle.

        The overlap keeps its costs, new cells get the default. As in costmap_2d the half size is
        that of the cell centres and the shift is rounded towards zero, so the window lags behind
        the robot by up to a cell.
        """
        rows, columns = self.cells.shape
        half_x = (columns - 1 + 0.5) * self.resolution / 2
        half_y = (rows - 1 + 0.5) * self.resolution / 2
        shift_x = int((x - half_x - self.origin_x) / self.resolution)
        shift_y = int((y - half_y - self.origin_y) / self.resolution)
        if shift_x or shift_y:
            self._shift(shift_x, shift_y)

    def _shift(self, shift_x: int, shift_y: int) -> None:
        old = self.cells
        self.cells = np.full_like(old, self.default)
        old_rows, new_rows = _overlap(shift_y, old.shape[0])
        old_columns, new_columns = _overlap(shift_x, old.shape[1])
        self.cells[new_rows, new_columns] = old[old_rows, old_columns]
        self.origin_x += shift_x * self.resolution
        self.origin_y += shift_y * self.resolution

    def columns_and_rows(
        self, x: np.ndarray, y: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Cells of the points (x, y), float64 metres in the global frame, and which are inside.

        Returns int32 columns, int32 rows and a bool mask; cells of points outside are (0, 0).
        NaN and infinite points are outside.
        """
        rows, columns = self.cells.shape
        with np.errstate(invalid="ignore", over="ignore"):
            u = (np.asarray(x, dtype=np.float64) - self.origin_x) / self.resolution
            v = (np.asarray(y, dtype=np.float64) - self.origin_y) / self.resolution
            inside = (u >= 0) & (v >= 0) & (u < columns) & (v < rows)
        return (
            np.where(inside, u, 0).astype(np.int32),
            np.where(inside, v, 0).astype(np.int32),
            inside,
        )

    def cell_box(self, box: Box) -> CellBox:
        """Cells that `box` touches, cut to the window; end < first when the box is empty."""
        rows, columns = self.cells.shape
        first_column = _clamped_cell(box.min_x, self.origin_x, self.resolution, columns)
        last_column = _clamped_cell(box.max_x, self.origin_x, self.resolution, columns)
        first_row = _clamped_cell(box.min_y, self.origin_y, self.resolution, rows)
        last_row = _clamped_cell(box.max_y, self.origin_y, self.resolution, rows)
        return first_column, last_column + 1, first_row, last_row + 1

    def cell_distance(self, metres: float) -> int:
        """Whole cells that cover a distance in metres."""
        return int(max(0.0, math.ceil(metres / self.resolution)))


def _overlap(shift: int, size: int) -> tuple[slice, slice]:
    """Where the cells that stay lie before and after a shift by `shift` cells."""
    first, end = min(max(shift, 0), size), min(max(shift + size, 0), size)
    return slice(first, end), slice(first - shift, end - shift)


def _clamped_cell(metres: float, origin: float, resolution: float, size: int) -> int:
    if metres < origin:
        return 0
    if metres >= resolution * size + origin:
        return size - 1
    return int((metres - origin) / resolution)
