"""The robot's outline: its polygon, its inscribed radius, the cells it covers."""

from __future__ import annotations

import math

import numpy as np

from safe_passage.costmap.grid import RollingGrid
from safe_passage.costmap.parameters import FootprintParameters
from safe_passage.costmap.raytrace import line_indices

CIRCLE_VERTICES = 16


def footprint_polygon(parameters: FootprintParameters) -> np.ndarray:
    """Padded outline in the base frame: (N, 2) float64 metres.

    Padding moves each coordinate that is not 0 away from 0, as costmap_2d's does. Coordinates
    pass through float32 as there, which decides whether a cell that lies exactly at the inscribed
    radius counts as inscribed.
    """
    if parameters.footprint:
        points = np.array(parameters.footprint, dtype=np.float32).astype(np.float64)
    else:
        angles = np.arange(CIRCLE_VERTICES) * 2 * math.pi / CIRCLE_VERTICES
        points = parameters.robot_radius * np.column_stack((np.cos(angles), np.sin(angles)))
    return points + np.sign(points) * parameters.footprint_padding


def inscribed_radius(polygon: np.ndarray) -> float:
    """Distance in metres from the base frame's origin to the nearest point of the outline."""
    start, end = polygon, np.roll(polygon, -1, axis=0)
    edge = end - start
    length_squared = np.maximum((edge**2).sum(axis=1), np.finfo(float).tiny)
    along = np.clip(-(start * edge).sum(axis=1) / length_squared, 0.0, 1.0)
    nearest = start + along[:, None] * edge
    return float(np.hypot(nearest[:, 0], nearest[:, 1]).min())


def place_polygon(polygon: np.ndarray, pose: tuple[float, float, float]) -> np.ndarray:
    """The outline (N, 2) at a pose (x m, y m, yaw rad) of the global frame."""
    x, y, yaw = pose
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.column_stack(
        (
            x + (polygon[:, 0] * cos - polygon[:, 1] * sin),
            y + (polygon[:, 0] * sin + polygon[:, 1] * cos),
        )
    )


def fill_polygon(grid: RollingGrid, polygon: np.ndarray, cost: int) -> bool:
    """Set the cells of a convex polygon (N, 2) of the global frame, outline included.

    Returns False and sets nothing when a vertex lies outside the window, as costmap_2d does.
    """
    columns, rows, inside = grid.columns_and_rows(polygon[:, 0], polygon[:, 1])
    if not inside.all():
        return False
    width = grid.cells.shape[1]
    outline = line_indices(columns, rows, np.roll(columns, -1), np.roll(rows, -1), width)
    outline_rows, outline_columns = np.divmod(outline.ravel(), width)
    first = int(outline_columns.min())
    span = int(outline_columns.max()) - first + 1
    lowest = np.full(span, np.iinfo(np.int32).max)
    highest = np.full(span, -1)
    np.minimum.at(lowest, outline_columns - first, outline_rows)
    np.maximum.at(highest, outline_columns - first, outline_rows)
    bottom, top = int(lowest.min()), int(highest.max()) + 1
    row = np.arange(bottom, top)[:, None]
    covered = (row >= lowest) & (row <= highest)
    grid.cells[bottom:top, first : first + span][covered] = cost
    return True
