"""The way to the goal, as its cost from everywhere (a navigation function). Frame: map."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import map_coordinates
from skimage.graph import MCP_Geometric

from safe_passage.core.geometry import Pose
from safe_passage.core.grid import GridMap

CELL = 0.1  # [m] of the navigation function
COMFORT = 0.35  # [m] beyond the robot's radius that it likes to keep
NEARNESS_COST = 4.0  # a metre along an obstacle costs up to so many more
ESCAPE_COST = 50.0  # a metre too near an obstacle: for leaving such a place only
UNREACHABLE = 1e4  # [m] cost where no way leads to the goal


class GlobalPlanner:
    """Costs to the goal over a static map.

    Args:
        static: the map.
        radius: [m] that the robot's middle keeps from obstacles.
        area_cost: what a metre through cells that only the costmap shows costs on top.
    """

    def __init__(self, static: GridMap, radius: float, area_cost: float) -> None:
        self._radius, self._area_cost = radius, area_cost
        self.static = static.coarser(CELL)
        self._clearance = self.static.distances()
        self._to_goal = np.full(self.static.occupied.shape, UNREACHABLE)

    def plan(self, goal: np.ndarray | Pose, seen: np.ndarray) -> None:
        """Costs to `goal` (x, y) [m] with obstacles `seen` (N, 2) [m] besides the map's.

        What only the costmap shows may be a person who walks on: it is dear, not impassable.
        """
        to_seen = self.static.with_cells_of(seen).distances()
        room = np.minimum(self._clearance, to_seen) - self._radius
        costs = 1.0 + NEARNESS_COST * np.clip(1.0 - room / COMFORT, 0.0, 1.0) ** 2
        costs[to_seen < self._radius] += self._area_cost
        costs[self._clearance < self._radius] = ESCAPE_COST
        costs[self.static.occupied] = -1.0  # impassable
        row, column, inside = self.static.cells(np.array(goal[:2]))
        self._to_goal = np.full(costs.shape, UNREACHABLE)
        if inside and not self.static.occupied[row, column]:
            found = CELL * MCP_Geometric(costs).find_costs([(int(row), int(column))])[0]
            self._to_goal = np.minimum(found, UNREACHABLE)

    def cost(self, points: np.ndarray) -> np.ndarray:
        """Cost [m of free way] from `points` (..., 2) [m] to the goal, interpolated."""
        at = (points - np.array(self.static.origin)) / CELL - 0.5
        places = np.moveaxis(at[..., ::-1], -1, 0)
        return map_coordinates(self._to_goal, places, order=1, mode="nearest")

    def way(self, start: np.ndarray | Pose) -> np.ndarray:
        """Points (N, 2) [m] downhill from `start` (x, y) to the goal; empty: there is no way."""
        row, column, inside = self.static.cells(np.array(start[:2]))
        if not inside or self._to_goal[row, column] >= UNREACHABLE:
            return np.empty((0, 2))
        cells = [(int(row), int(column))]
        while True:
            r, c = cells[-1]
            window = self._to_goal[max(r - 1, 0) : r + 2, max(c - 1, 0) : c + 2]
            dr, dc = divmod(int(np.argmin(window)), window.shape[1])
            lowest = (max(r - 1, 0) + dr, max(c - 1, 0) + dc)
            if self._to_goal[lowest] >= self._to_goal[r, c]:
                break
            cells.append(lowest)
        return np.array(self.static.origin) + (np.array(cells)[:, ::-1] + 0.5) * CELL
