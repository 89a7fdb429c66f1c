"""Bresenham lines between cells, all at once."""

from __future__ import annotations

import numpy as np


def line_indices(
    start_columns: int | np.ndarray,
    start_rows: int | np.ndarray,
    end_columns: np.ndarray,
    end_rows: np.ndarray,
    width: int,
    max_length: float = np.inf,
) -> np.ndarray:
    """Flat indices of the cells on the lines from start cells to end cells.

    start_columns, start_rows: one cell for all lines, or (N,); end_columns, end_rows: (N,) int32;
    all inside the grid; width: columns of the grid; max_length: cells after which a line stops,
    measured along the line.
    Returns (N, L) int32 flat indices (row * width + column); a line shorter than L repeats its
    last cell.
    Which of two equally near cells a line takes is that of costmap_2d's raytraceLine: after i
    steps along the longer axis (length a) it has made (a // 2 + i b) // a along the shorter (b).
    """
    dx = end_columns.astype(np.int32) - np.asarray(start_columns, dtype=np.int32)
    dy = end_rows.astype(np.int32) - np.asarray(start_rows, dtype=np.int32)
    abs_dx, abs_dy = np.abs(dx), np.abs(dy)
    x_leads = abs_dx >= abs_dy
    leading, trailing = np.where(x_leads, abs_dx, abs_dy), np.where(x_leads, abs_dy, abs_dx)
    step_x, step_y = np.where(dx > 0, 1, -1), np.where(dy > 0, width, -width)
    leading_step = np.where(x_leads, step_x, step_y).astype(np.int32)
    trailing_step = np.where(x_leads, step_y, step_x).astype(np.int32)

    length = np.hypot(dx, dy)
    scale = np.minimum(1.0, max_length / np.maximum(length, 1.0))
    last = np.minimum((scale * leading).astype(np.int32), leading)
    steps = np.arange(int(last.max(initial=0)) + 1, dtype=np.int32)
    along = np.minimum(steps[None, :], last[:, None])
    across = along * trailing[:, None]
    across += (leading // 2)[:, None]
    across //= np.maximum(leading, 1)[:, None]
    along *= leading_step[:, None]
    across *= trailing_step[:, None]
    along += across
    start = np.asarray(start_rows * width + start_columns, dtype=np.int32)
    along += start.reshape(-1, 1)
    return along
