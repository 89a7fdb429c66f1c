"""Marks what sensors see and clears what they see through (costmap_2d::ObstacleLayer)."""

from __future__ import annotations

from typing import Iterator

import numpy as np

from safe_passage.costmap.costs import FREE_SPACE, LETHAL_OBSTACLE, NO_INFORMATION
from safe_passage.costmap.crossing import crossed
from safe_passage.costmap.footprint import fill_polygon
from safe_passage.costmap.grid import Box, CellBox, RollingGrid
from safe_passage.costmap.observation import Observation, ObservationBuffer
from safe_passage.costmap.parameters import (
    MAXIMUM,
    OVERWRITE,
    CostmapParameters,
    ObstacleLayerParameters,
    SourceParameters,
)
from safe_passage.costmap.raytrace import line_indices

MOST_BEAMS = 4096  # of larger clouds one beam to each end cell is asked what it crosses
EDGE_MARGIN = 0.001  # m inside the window's far edges, where cut rays end


class ObstacleLayer:
    """A grid of its own that remembers obstacles between updates."""

    def __init__(self, parameters: ObstacleLayerParameters, costmap: CostmapParameters) -> None:
        self.parameters = parameters
        self.buffers: dict[str, ObservationBuffer] = {
            source.name: ObservationBuffer(source) for source in parameters.sources
        }
        default = NO_INFORMATION if parameters.track_unknown_space else FREE_SPACE
        self.grid = RollingGrid(
            costmap.shape, costmap.resolution, (costmap.origin_x, costmap.origin_y), default
        )

    def tune(self, parameters: ObstacleLayerParameters) -> None:
        """Other parameters from the next update on; what was seen stays."""
        self.parameters = parameters
        for source in parameters.sources:
            self.buffers[source.name].parameters = source

    def clear(self) -> Box:
        """Free the cells that rays pass; returns the area touched."""
        touched = Box()
        for source, observation in self._observations():
            if source.clearing:
                touched = touched.joined(self._trace_free_space(observation, source.raytrace_range))
        return touched

    def mark(self) -> Box:
        """Make the cells of seen points lethal; returns the area touched."""
        touched = Box()
        for source, observation in self._observations():
            if source.marking:
                touched = touched.joined(self._mark_points(observation, source.obstacle_range))
        return touched

    def clear_footprint(self, polygon: np.ndarray) -> None:
        """Free the robot's own place: polygon (N, 2) m in the global frame."""
        if self.parameters.footprint_clearing_enabled:
            fill_polygon(self.grid, polygon, FREE_SPACE)

    def combine_into(self, master: RollingGrid, box: CellBox) -> None:
        """Write this layer's known cells into the master grid, inside `box`."""
        first_column, end_column, first_row, end_row = box
        area = (slice(first_row, end_row), slice(first_column, end_column))
        own, target = self.grid.cells[area], master.cells[area]
        known = own != NO_INFORMATION
        if self.parameters.combination_method == MAXIMUM:
            known &= (target == NO_INFORMATION) | (target < own)
        elif self.parameters.combination_method != OVERWRITE:
            return
        np.copyto(target, own, where=known)

    def reset(self) -> None:
        """Forget everything."""
        self.grid.cells.fill(self.grid.default)
        for buffer in self.buffers.values():
            buffer.clear()

    def _observations(self) -> Iterator[tuple[SourceParameters, Observation]]:
        for buffer in self.buffers.values():
            for observation in buffer.kept:
                yield buffer.parameters, observation

    def _trace_free_space(self, observation: Observation, raytrace_range: float) -> Box:
        origin_x, origin_y = observation.origin[:2]
        column, row, inside = self.grid.columns_and_rows(np.array([origin_x]), np.array([origin_y]))
        if not inside[0]:
            return Box()  # a ray that starts outside the window cannot be followed
        x, y = _cut_to_window(self.grid, observation)
        columns, rows, inside = self.grid.columns_and_rows(x, y)
        width = self.grid.cells.shape[1]
        beam_to = np.full(self.grid.cells.size, -1)  # one beam to each end cell: many share one
        beam_to[rows[inside] * width + columns[inside]] = np.flatnonzero(inside)
        ends = np.flatnonzero(beam_to >= 0)
        cells = line_indices(
            int(column[0]),
            int(row[0]),
            ends % width,
            ends // width,
            width,
            self.grid.cell_distance(raytrace_range),
        )
        self.grid.cells.reshape(-1)[cells] = FREE_SPACE
        box = _ray_bounds(origin_x, origin_y, x[inside], y[inside], raytrace_range)
        if self.parameters.clear_crossed_cells:
            points = observation.points
            beams = points if len(points) <= MOST_BEAMS else points[beam_to[ends]]
            box = box.joined(self._clear_crossed(beams, origin_x, origin_y, raytrace_range))
        return box

    def _clear_crossed(
        self, points: np.ndarray, origin_x: float, origin_y: float, raytrace_range: float
    ) -> Box:
        """Free the marked cells that a beam crosses although no line between cells does.

        costmap_2d leaves them: stray cells of a person who has left, until the robot moves.
        """
        rows, columns = np.nonzero(self.grid.cells == LETHAL_OBSTACLE)
        x = self.grid.origin_x + (columns + 0.5) * self.grid.resolution
        y = self.grid.origin_y + (rows + 0.5) * self.grid.resolution
        origin = np.array([origin_x, origin_y])
        free = crossed(
            np.column_stack((x, y)) - origin,
            points[:, :2] - origin,
            self.grid.resolution,
            raytrace_range,
        )
        self.grid.cells[rows[free], columns[free]] = FREE_SPACE
        return Box().touching(x[free], y[free])

    def _mark_points(self, observation: Observation, obstacle_range: float) -> Box:
        points = observation.points.astype(np.float64)
        offset = points - np.asarray(observation.origin, dtype=np.float64)
        near = (offset[:, 0] ** 2 + offset[:, 1] ** 2) + offset[:, 2] ** 2 < obstacle_range**2
        near &= points[:, 2] <= self.parameters.max_obstacle_height
        x, y = points[near, 0], points[near, 1]
        columns, rows, inside = self.grid.columns_and_rows(x, y)
        self.grid.cells[rows[inside], columns[inside]] = LETHAL_OBSTACLE
        return Box().touching(x[inside], y[inside])


def _cut_to_window(grid: RollingGrid, observation: Observation) -> tuple[np.ndarray, np.ndarray]:
    """Ends (x, y) of the rays, moved back along the ray onto the window's edge where they leave it.

    The edges are cut in costmap_2d's order: left, bottom, right, top.
    """
    rows, columns = grid.cells.shape
    origin_x, origin_y = observation.origin[:2]
    x, y = observation.points[:, :2].astype(np.float64).T.copy()
    along_x, along_y = x - origin_x, y - origin_y
    right = grid.origin_x + columns * grid.resolution
    top = grid.origin_y + rows * grid.resolution

    def cut_x(beyond: np.ndarray, edge: float, margin: float) -> None:
        y[beyond] = origin_y + along_y[beyond] * ((edge - origin_x) / along_x[beyond])
        x[beyond] = edge - margin

    def cut_y(beyond: np.ndarray, edge: float, margin: float) -> None:
        x[beyond] = origin_x + along_x[beyond] * ((edge - origin_y) / along_y[beyond])
        y[beyond] = edge - margin

    cut_x(x < grid.origin_x, grid.origin_x, 0.0)
    cut_y(y < grid.origin_y, grid.origin_y, 0.0)
    cut_x(x > right, right, EDGE_MARGIN)
    cut_y(y > top, top, EDGE_MARGIN)
    return x, y


def _ray_bounds(
    origin_x: float, origin_y: float, x: np.ndarray, y: np.ndarray, raytrace_range: float
) -> Box:
    """Area that holds the rays to (x, y), none longer than `raytrace_range`."""
    dx, dy = x - origin_x, y - origin_y
    length = np.hypot(dx, dy)
    scale = np.minimum(1.0, raytrace_range / np.maximum(length, np.finfo(float).tiny))
    box = Box(origin_x, origin_y, origin_x, origin_y)
    return box.touching(origin_x + dx * scale, origin_y + dy * scale)
