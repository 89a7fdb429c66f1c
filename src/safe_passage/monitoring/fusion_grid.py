"""All sensors' points in one robot-centred 2.5D grid (paper 000, 3.4)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from safe_passage.monitoring.aggregation import Points

RIM = 2  # cells at the border: what is there may go on beyond it


@dataclass(frozen=True)
class FusionGrid:
    """The obstacle cells, K of them, in rows from the lower left; what is not there is free."""

    side: int  # cells along x and along y
    resolution: float  # [m] a cell
    cell: np.ndarray  # (K,) row * side + column, ascending; row = y
    position: np.ndarray  # (K, 2) [m] mean of the points in it, frame base
    counts: np.ndarray  # (K, S) points of each sensor
    height: np.ndarray  # (K, 2) [m] lowest and highest point of 3D sensors, NaN: none saw it
    scanned: np.ndarray  # (K,) bool: scanners, which tell no heights, have points in it
    age: np.ndarray  # (K,) [s] mean of its points
    shadowed: np.ndarray  # (K,) bool: the object may go on behind a nearer one, or beyond the grid
    fresh: np.ndarray  # (K, 3) mean x, y [m] and age [s] of its fresh points, NaN: it has none
    new: np.ndarray  # (K,) bool: a short while ago nothing was there, as free_space knows
    stood: np.ndarray  # (K,) bool: something was
    left: np.ndarray  # (K,) bool: by now there is nothing any more
    label: np.ndarray  # (side * side,) int32 scratch: index of the obstacle cell, -1: free

    @property
    def density(self) -> np.ndarray:
        """(K,) points a square metre."""
        return self.counts.sum(axis=1) / self.resolution**2

    def cells_of(self, points: np.ndarray) -> np.ndarray:
        """Grid cell (N,) of `points` (N, 2) [m], -1: outside."""
        return cell_index(points, self.side, self.resolution)


def cell_index(points: np.ndarray, side: int, resolution: float) -> np.ndarray:
    """row * side + column (N,) of `points` (N, 2+) [m] around the robot, -1: outside."""
    half = 0.5 * side
    with np.errstate(invalid="ignore"):
        column = np.floor(points[:, 0] / resolution + half)
        row = np.floor(points[:, 1] / resolution + half)
        inside = (column >= 0) & (column < side) & (row >= 0) & (row < side)
        return np.where(inside, row * side + column, -1).astype(np.int64)


class Fusion:
    """Fills the grid; keeps the scratch memory between cycles.

    Args:
        radius: [m] half the side. resolution: [m] a cell.
        three_dimensional: for each sensor, whether it tells heights.
    """

    def __init__(self, radius: float, resolution: float, three_dimensional: np.ndarray) -> None:
        self._side = 2 * math.ceil(radius / resolution)
        self._resolution = resolution
        self._heights = np.asarray(three_dimensional, bool)
        self._label = np.full(self._side**2, -1, np.int32)
        self._used = np.empty(0, np.int64)

    def fuse(self, points: Points) -> FusionGrid:
        """The grid of these points; the last one's `label` is overwritten."""
        index = cell_index(points.xyz, self._side, self._resolution)
        inside = index >= 0
        index, sensor = index[inside], points.sensor[inside]
        xyz, age, fresh = points.xyz[inside], points.age[inside], points.fresh[inside]
        self._label[self._used] = -1
        self._label[index] = 0
        cell = np.flatnonzero(self._label + 1)
        self._label[cell] = np.arange(len(cell), dtype=np.int32)
        self._used = cell
        at = self._label[index]
        count, sensors = len(cell), len(self._heights)
        counts = np.bincount(at * sensors + sensor, minlength=count * sensors)
        total = np.bincount(at, minlength=count)
        told = (xyz[:, 0], xyz[:, 1], age)
        mean = [np.bincount(at, w, minlength=count) / total for w in told]
        with np.errstate(invalid="ignore"):
            news = np.bincount(at, fresh, minlength=count)
            new = [np.bincount(at, w * fresh, minlength=count) / news for w in told]
        row, column = np.divmod(cell, self._side)
        rim = np.minimum(np.minimum(row, column), self._side - 1 - np.maximum(row, column)) < RIM
        return FusionGrid(
            self._side,
            self._resolution,
            cell,
            np.stack(mean[:2], axis=1),
            counts.reshape(count, sensors),
            _heights(at, xyz[:, 2], self._heights[sensor], count),
            counts.reshape(count, sensors)[:, ~self._heights].any(axis=1),
            mean[2],
            rim | (np.bincount(at, points.shadowed[inside], minlength=count) > 0),
            np.stack(new, axis=1),
            np.zeros(count, bool),
            np.zeros(count, bool),
            np.zeros(count, bool),
            self._label,
        )


def _heights(at: np.ndarray, z: np.ndarray, told: np.ndarray, count: int) -> np.ndarray:
    """Lowest and highest z (count, 2) of the points `told` in each cell, NaN: none."""
    heights = np.full((count, 2), np.nan)
    at, z = at[told], z[told]
    if len(at):
        order = np.argsort(at, kind="stable")
        at, z = at[order], z[order]
        start = np.flatnonzero(np.append(True, at[1:] != at[:-1]))
        heights[at[start], 0] = np.minimum.reduceat(z, start)
        heights[at[start], 1] = np.maximum.reduceat(z, start)
    return heights
