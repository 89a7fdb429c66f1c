"""Was there a way? What a robot could have done that knew how everybody would walk."""

from __future__ import annotations

import math
from typing import Callable, Sequence

import cv2
import numpy as np

from safe_passage.core.grid import GridMap

STEP = 0.25  # [s]
SUBSTEPS = 2  # times within a step at which people are looked at
RADIUS = 0.36  # [m] of the disc that stands for the robot: half a Summit XL's length
KEEP = 1.2  # [m] from the disc's edge to a person's middle

Place = Callable[[float], Sequence[float]]  # time [s] -> x, y [m], frame map


def earliest_arrival(
    static: GridMap,
    start: Sequence[float],
    goal: Sequence[float],
    people: Sequence[Place],
    speed: float,
    within: float,
    keep: float = KEEP,
    radius: float = RADIUS,
) -> float:
    """Earliest time [s] at which a disc that keeps away from everybody can be at the goal.

    The set of cells where the disc can be grows from time step to time step by the way it can drive
    in one, less what is too near to obstacles of the map or, at that time, to people (reachability
    in space and time). It drives and stops in any direction at once, and knows the people's motion:
    where it finds no way, a robot finds none; where it finds one, a robot with its inertia, its
    corners and only its own eyes may still not. Ways are judged at cells' middles; along diagonals
    it is slower than `speed`, by an eighth at most at 0.8 m/s and cells of 0.05 m.

    Args:
        static: the map.
        start, goal: x, y [m] of the disc's middle, frame map.
        people: where each is at any time.
        speed: [m/s] that it drives at most.
        within: [s] it must be there.
        keep: [m] between the disc's edge and anybody's middle at all times, the start included.
        radius: [m] of the disc.

    Returns:
        math.inf where there is no way.
    """
    half = 0.5 * static.resolution  # from a cell's middle to the edge of the one that is occupied
    open_floor = static.distances() >= radius + half
    (row, goal_row), (column, goal_column), inside = static.cells(
        np.array([start[:2], goal[:2]], float)
    )
    if not inside.all():
        return math.inf
    open_floor[row, column] = True  # it stands there, whatever the map says
    here = np.zeros(open_floor.shape, np.uint8)
    here[row, column] = not _near_people(static, people, 0.0, keep + radius)[row, column]
    growth = _disc(speed * STEP / static.resolution)
    for step in range(round(within / STEP) + 1):
        time = step * STEP
        if not here.any():
            return math.inf
        if here[goal_row, goal_column]:
            return time
        here = cv2.dilate(here, growth, borderType=cv2.BORDER_CONSTANT, borderValue=0)
        here &= open_floor
        for sub in range(1, SUBSTEPS + 1):
            here &= ~_near_people(static, people, time + STEP * sub / SUBSTEPS, keep + radius)
    return math.inf


def _near_people(
    static: GridMap, people: Sequence[Place], time: float, distance: float
) -> np.ndarray:
    """Cells (rows, columns) bool whose middle is nearer than `distance` [m] to anybody."""
    rows, columns = static.occupied.shape
    x = static.origin[0] + (np.arange(columns) + 0.5) * static.resolution
    y = static.origin[1] + (np.arange(rows) + 0.5) * static.resolution
    near = np.zeros((rows, columns), bool)
    for place in people:
        px, py = place(time)
        near |= (x - px) ** 2 + (y[:, None] - py) ** 2 < distance**2
    return near


def _disc(cells: float) -> np.ndarray:
    """Cells whose middle lies within `cells` of the one in the middle."""
    reach = int(cells + 1e-9)
    offsets = np.arange(-reach, reach + 1)
    return (offsets**2 + offsets[:, None] ** 2 <= (cells + 1e-9) ** 2).astype(np.uint8)
