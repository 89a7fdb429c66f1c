"""Cells drawn as text: a grid of the tracker with clusters where the letters are."""

from __future__ import annotations

import numpy as np
from safe_passage.monitoring.aggregation import Points
from safe_passage.monitoring.fusion_grid import Fusion, FusionGrid
from safe_passage.monitoring.ragged import Ragged

CELL = 0.1


def places(drawing: str, letters: str) -> np.ndarray:
    """Middles (N, 2) [m] of the cells with one of `letters`; the first line is the uppermost."""
    rows = drawing.split()
    return np.array(
        [
            ((column + 0.5) * CELL, (len(rows) - 1 - row + 0.5) * CELL)
            for row, line in enumerate(rows)
            for column, letter in enumerate(line)
            if letter in letters
        ]
    ).reshape(-1, 2)


def grid_of(drawing: str, points_a_cell: int = 3) -> FusionGrid:
    """Grid of all cells that are not dots, seen by one laser."""
    letters = "".join(set(drawing) - set(".\n "))
    xy = np.repeat(places(drawing, letters), points_a_cell, axis=0)
    xyz = np.column_stack([xy, np.zeros(len(xy))]).astype(np.float32)
    nothing = np.zeros(len(xyz))
    return Fusion(2.0, CELL, np.array([False])).fuse(
        Points(xyz, nothing > 0, nothing.astype(int), nothing, nothing == 0)
    )


def shapes_of(drawing: str, letters: str) -> Ragged:
    """A track's shape for each of `letters`."""
    return Ragged.of([places(drawing, letter) for letter in letters], np.empty((0, 2)))
