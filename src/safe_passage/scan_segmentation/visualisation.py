"""What an operator is shown in three dimensions (paper 003, section II-E). Frame: the scanner's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import Delaunay, QhullError

from safe_passage.scan_segmentation.basic_map import Colour
from safe_passage.scan_segmentation.pipeline import Segmentation
from safe_passage.scan_segmentation.scan import unique_cells

CUBE = 0.1  # [m] of obstacles
LONGEST = 0.35  # [m] edge of a triangle: over longer ones nothing is known
SPACING = 0.04  # [m] cells of which one point is a corner: near the scanner there are many
NARROW = 0.05  # [m] between the points that a narrow way is drawn of


@dataclass(frozen=True)
class Mesh:
    """Triangles over drivable ground."""

    points: np.ndarray  # (N, 3) [m]
    triangles: np.ndarray  # (T, 3) int
    colours: np.ndarray  # (T,) Colour


@dataclass(frozen=True)
class Pictured:
    """Shapes to draw."""

    ground: Mesh
    cubes: np.ndarray  # (N, 3) [m] middles of obstacles that are probably passable, CUBE wide
    cuboids: np.ndarray  # (N, 5) [m] x, y, lowest and highest z, level frame, and width
    walls: list[np.ndarray]  # polygons (M, 3) [m] of planes that are no ground


def pictured(found: Segmentation) -> Pictured:
    """Triangles, cubes, cuboids and walls of a segmentation."""
    points, height = found.survey.points, found.survey.height
    known = np.isfinite(height)
    xyz, over = points[known], height[known]
    ground = {plane.index for plane in found.ground}
    walls = [
        polygon
        for k, valid in enumerate(found.planes.valid)
        if k not in ground
        for polygon in valid.outline()
    ]
    return Pictured(
        _mesh(found, xyz, over), _cubes(found, xyz, over), _cuboids(found, xyz, over), walls
    )


def _mesh(found: Segmentation, xyz: np.ndarray, over: np.ndarray) -> Mesh:
    """2D Delaunay triangulation of the drivable ground points, seen from above."""
    even = xyz[np.abs(over) <= 0.05]
    drivable = even[np.isin(found.drivable.at(even[:, :2]), (Colour.GREEN, Colour.ORANGE))]
    points = np.concatenate([drivable[unique_cells(drivable, SPACING)[1]], _narrow(found)])
    if len(points) < 4:
        return Mesh(np.empty((0, 3)), np.empty((0, 3), int), np.empty(0, np.uint8))
    try:
        triangles = Delaunay(points[:, :2]).simplices
    except QhullError:  # all in a line
        return Mesh(np.empty((0, 3)), np.empty((0, 3), int), np.empty(0, np.uint8))
    corners = points[triangles]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    colours = found.drivable.at(corners.mean(axis=1)[:, :2])
    keep = (edges.max(axis=1) < LONGEST) & np.isin(colours, (Colour.GREEN, Colour.ORANGE))
    return Mesh(found.level.back(points), triangles[keep], colours[keep])


def _narrow(found: Segmentation) -> np.ndarray:
    """(N, 3) points of orange ways, which may be narrower than beams are apart."""
    step = max(1, round(NARROW / found.drivable.resolution))
    row, column = np.nonzero(found.drivable.cells == Colour.ORANGE)
    keep = (row % step == 0) | (column % step == 0)
    keep &= (row + column) % step == 0
    cells = np.stack([column[keep], row[keep]], axis=1) + 0.5
    at = found.drivable.origin + cells * found.drivable.resolution
    return np.column_stack([at, found.survey.ground.z(at)])


def _cubes(found: Segmentation, xyz: np.ndarray, over: np.ndarray) -> np.ndarray:
    low = (np.abs(over) > 0.04) & (np.abs(over) <= found.robot.max_obstacle)
    low &= found.basic.at(xyz[:, :2]) == Colour.ORANGE
    cells, _, _ = unique_cells(xyz[low], CUBE)
    return found.level.back((cells + 0.5) * CUBE)


def _cuboids(found: Segmentation, xyz: np.ndarray, over: np.ndarray) -> np.ndarray:
    """From the ground (or the lowest point over it, under a lintel) to the highest seen."""
    high = (over > found.robot.max_obstacle) & (over <= found.robot.clearance)
    at = xyz[high]
    if not len(at):
        return np.empty((0, 5))
    cells, _, which = unique_cells(at[:, :2], CUBE)
    low, top = np.full(len(cells), np.inf), np.full(len(cells), -np.inf)
    np.minimum.at(low, which, at[:, 2])
    np.maximum.at(top, which, at[:, 2])
    middle = (cells + 0.5) * CUBE
    return np.column_stack([middle, low, top, np.full(len(cells), CUBE)])
