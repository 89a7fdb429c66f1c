"""Costs that fall off around lethal cells (costmap_2d::InflationLayer)."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import distance_transform_edt

from safe_passage.costmap.costs import (
    FREE_SPACE,
    INSCRIBED_INFLATED_OBSTACLE,
    LETHAL_OBSTACLE,
    NO_INFORMATION,
)
from safe_passage.costmap.grid import Box, CellBox, RollingGrid
from safe_passage.costmap.parameters import InflationLayerParameters


def inflation_costs(
    parameters: InflationLayerParameters, resolution: float, inscribed_radius: float
) -> np.ndarray:
    """Cost by squared distance in cells to the nearest lethal cell: (r * r + 2,) uint8.

    r is the inflation radius in whole cells, rounded up; the last entry, for everything farther,
    is 0. Lethal at 0, inscribed up to the inscribed radius (m), then 252 exp(-k (d - inscribed)),
    cut to a whole number.
    """
    radius = int(max(0.0, math.ceil(parameters.inflation_radius / resolution)))
    distance = np.sqrt(np.arange(radius * radius + 2)) * resolution
    decay = np.exp(-parameters.cost_scaling_factor * (distance - inscribed_radius))
    scale = INSCRIBED_INFLATED_OBSTACLE - 1
    costs = np.clip(scale * decay, 0, scale).astype(np.uint8)
    costs[distance <= inscribed_radius] = INSCRIBED_INFLATED_OBSTACLE
    costs[0] = LETHAL_OBSTACLE
    costs[-1] = FREE_SPACE
    return costs


class InflationLayer:
    """Raises costs in the master grid; keeps only the area of its last update."""

    def __init__(
        self, parameters: InflationLayerParameters, resolution: float, inscribed_radius: float
    ) -> None:
        self._resolution, self._inscribed = resolution, inscribed_radius
        self.tune(parameters)

    def tune(self, parameters: InflationLayerParameters) -> None:
        """Other parameters from the next update on, which computes the whole window anew."""
        self.parameters = parameters
        self._costs = inflation_costs(parameters, self._resolution, self._inscribed)
        self._radius = math.isqrt(len(self._costs) - 2)
        self._last_touched = Box.everywhere()

    def grow(self, touched: Box) -> Box:
        """Area to recompute: what was touched now and last time, and what inflation reaches."""
        area = touched.joined(self._last_touched).padded(self.parameters.inflation_radius)
        self._last_touched = touched
        return area

    def inflate(self, master: RollingGrid, box: CellBox) -> None:
        """Raise the costs around the lethal cells in `box` and within the inflation radius of it.

        Distances are exact Euclidean ones. costmap_2d spreads them from cell to neighbour, which
        is exact but for rare cells whose nearest obstacle's wave is cut off by another's.
        """
        if self._radius == 0:
            return
        rows, columns = master.cells.shape
        first_column, end_column, first_row, end_row = box
        area = (
            slice(max(0, first_row - self._radius), min(rows, end_row + self._radius)),
            slice(max(0, first_column - self._radius), min(columns, end_column + self._radius)),
        )
        free_of_obstacle = np.ones(master.cells.shape, dtype=bool)
        free_of_obstacle[area] = master.cells[area] != LETHAL_OBSTACLE
        if free_of_obstacle[area].all():
            return
        squared = distance_transform_edt(free_of_obstacle)
        squared *= squared
        squared += 0.5
        index = np.minimum(squared, len(self._costs) - 1, out=squared).astype(np.intp)
        self._raise_costs(master.cells, self._costs[index])

    def reset(self) -> None:
        self._last_touched = Box.everywhere()

    def _raise_costs(self, cells: np.ndarray, costs: np.ndarray) -> None:
        unknown = cells == NO_INFORMATION
        np.maximum(cells, costs, out=cells)
        lowest = FREE_SPACE + 1 if self.parameters.inflate_unknown else INSCRIBED_INFLATED_OBSTACLE
        np.copyto(cells, costs, where=unknown & (costs >= lowest))
