"""What describes an object as it is seen now (paper 000, 4.1)."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from safe_passage.monitoring.fusion_grid import FusionGrid
from safe_passage.monitoring.ragged import Ragged, moments

MOSTLY = 0.5  # share of an object's cells that speaks for all of it
LEAST_NEW = 3  # cells of a thing that has come; fewer are noise


@dataclass(frozen=True)
class Features:
    """Of H objects."""

    position: np.ndarray  # (H, 2) [m] centroid of the cells, frame base
    extent: np.ndarray  # (H, 2, 2) [m^2] second moment of the cells around it
    cells: np.ndarray  # (H,) number of occupied cells
    counts: np.ndarray  # (H, S) points of each sensor
    height: np.ndarray  # (H, 2) [m] lowest and highest point, NaN: no 3D sensor saw it
    age: np.ndarray  # (H,) [s] mean age of the measurements
    shadowed: np.ndarray  # (H,) bool: the object may go on behind a nearer one
    new: np.ndarray  # (H,) share of its cells where nothing was a short while ago
    stood: np.ndarray  # (H,) share of its cells where something was
    here: np.ndarray  # (H,) bool: the sensors' last measurements have it
    left: np.ndarray  # (H,) bool: nothing of it is there any more

    def of(self, which: np.ndarray) -> Features:
        """Those of `which` (M,)."""
        return Features(*[getattr(self, field.name)[which] for field in fields(self)])


def describe(grid: FusionGrid, cells: Ragged) -> Features:
    """Features of these sets of obstacle cells."""
    owner, at, number = cells.owner, cells.values, cells.lengths
    if not len(cells):
        return no_features(grid.counts.shape[1])

    def mean(values: np.ndarray) -> np.ndarray:
        return np.bincount(owner, values[at], minlength=len(cells)) / number

    centre, extent = moments(Ragged(grid.position[at], cells.start))
    start = cells.start[:-1]
    lowest = np.fmin.reduceat(grid.height[at, 0], start)
    highest = np.fmax.reduceat(grid.height[at, 1], start)
    here = mean(np.isfinite(grid.fresh[:, 2])) > 0.0
    return Features(
        centre,
        extent,
        number,
        np.add.reduceat(grid.counts[at], start, axis=0),
        np.stack([lowest, highest], axis=1),
        mean(grid.age),
        mean(grid.shadowed) > 0.0,
        mean(grid.new),
        mean(grid.stood),
        here,
        ~here & (mean(grid.left) >= MOSTLY),
    )


def no_features(sensors: int) -> Features:
    """Of nothing."""
    none = np.empty(0)
    return Features(
        np.empty((0, 2)),
        np.empty((0, 2, 2)),
        np.empty(0, np.int64),
        np.empty((0, sensors), np.int64),
        np.empty((0, 2)),
        *(none, none > 0, none, none, none > 0, none > 0),
    )
