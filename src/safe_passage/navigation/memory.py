"""Remembers what the rolling costmap showed: a way that is blocked stays so while nobody looks."""

from __future__ import annotations

import math

import numpy as np

from safe_passage.core.geometry import Pose, inverse, placed
from safe_passage.core.grid import GridMap

KEEP = 60.0  # [s]
REACH, HALF_VIEW = 3.5, 0.5  # [m], [rad] before the robot: what is there is seen anew
SAMPLES = 20  # of a line of sight


class ObstacleMemory:
    """Obstacles on the cells of a static map.

    Args:
        static: the map, which hides what is behind its obstacles.
    """

    def __init__(self, static: GridMap) -> None:
        self._static = static
        self._seen = np.full(static.occupied.shape, -math.inf)  # [s]

    def update(self, time: float, pose: Pose, seen: np.ndarray) -> np.ndarray:
        """Obstacles (N, 2) [m] of now and of before; `seen` (M, 2) [m] are those of now."""
        grid = self._static
        self._seen[self._in_view(pose)] = -math.inf
        rows, columns, inside = grid.cells(seen)
        self._seen[rows[inside], columns[inside]] = time
        self._seen[(time - self._seen > KEEP) | (self._seen > time)] = -math.inf
        return GridMap(self._seen > -math.inf, grid.origin, grid.resolution).centres()

    def _in_view(self, pose: Pose) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns of remembered cells that the robot looks at."""
        rows, columns = np.nonzero(self._seen > -math.inf)
        middles = (np.stack([columns, rows], axis=1) + 0.5) * self._static.resolution
        middles += np.array(self._static.origin)
        local = placed(middles, inverse(pose))
        near = np.hypot(local[:, 0], local[:, 1]) < REACH
        near &= np.abs(np.arctan2(local[:, 1], local[:, 0])) < HALF_VIEW
        here = np.array(pose[:2])
        shares = np.linspace(0.0, 0.95, SAMPLES)[:, None, None]
        lines = here + shares * (middles[near] - here)
        clear = ~self._static.at(lines, outside=True).any(axis=0)
        return rows[near][clear], columns[near][clear]
