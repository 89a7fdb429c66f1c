"""What stands where on the ground, cell by cell (paper 003, section II-D). Frame: level."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np

import safe_passage._scan_segmentation as kernels
from safe_passage.scan_segmentation.ground import GroundHeight, GroundPlane, ground_height
from safe_passage.scan_segmentation.parameters import RobotConfiguration, SegmentationParameters
from safe_passage.scan_segmentation.planes import is_closed
from safe_passage.scan_segmentation.scan import Level, OrganisedScan
from safe_passage.scan_segmentation.stairs import Stairs, over_stairs
from safe_passage.scan_segmentation.validation import ValidPlane

MAX_CELLS = 16_000_000  # of a map; a larger place gets coarser cells
FOOT = 0.5  # [m] over the ground: what stands on it is seen down to here
NOTHING, GROUND, FEET = 0, 1, 2  # as in the kernel
SUNK = 0.5  # of the tolerance: a hole begins so deep under the ground, or deeper where
NOISE = 1.3  # times what all but a hundredth of the ground's points keep to is more
SLANT = 0.15  # sine under which a beam meets a plane too flatly to be moved along it


class Colour(enum.IntEnum):
    """Of a cell."""

    UNKNOWN = 0
    GREEN = 1  # drivable
    ORANGE = 2  # with care: a low obstacle, a narrow way
    RED = 3  # not passable


@dataclass(frozen=True)
class ColourMap:
    """Cells of `Colour`. Frame: level."""

    cells: np.ndarray  # (rows, columns) uint8, row = y
    origin: np.ndarray  # (2,) [m] lower-left corner
    resolution: float  # [m] a cell

    def at(self, xy: np.ndarray) -> np.ndarray:
        """Colours of points (N, 2) [m]; unknown beyond the border."""
        rows, columns = self.cells.shape
        column, row = np.floor((xy - self.origin) / self.resolution).astype(int).T
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        found = self.cells[np.where(inside, row, 0), np.where(inside, column, 0)]
        return np.where(inside, found, np.uint8(Colour.UNKNOWN))


@dataclass(frozen=True)
class Survey:
    """The scan as the map sees it."""

    points: np.ndarray  # (H, W, 3) [m] level frame, those of planes moved onto them, NaN
    height: np.ndarray  # (H, W) [m] over the local ground, NaN
    ground: GroundHeight
    map: ColourMap


def on_their_planes(
    scan: OrganisedScan,
    level: Level,
    planes: list[ValidPlane],
    labels: np.ndarray,
    firm: np.ndarray,
) -> np.ndarray:
    """Points (H, W, 3) [m], level frame; those of a plane where their beam meets it.

    The range is what a scanner measures badly: along the beam its noise goes, edges stay.

    Args:
        firm: (H, W) bool, points inside a segment that lies in the plane. Others may be of what
            begins behind the plane's edge, such as a door's frame, and stay where they are.
    """
    points = level.points(scan.points.astype(np.float64))
    for k, valid in enumerate(planes):
        normal = level.R_level_scan @ valid.plane.normal
        offset = float(valid.plane.distance(level.origin))
        moved = (labels == k) & firm
        own = points[moved]
        facing = own @ normal
        flat = np.abs(facing) < SLANT * np.linalg.norm(own, axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            along = own * (-offset / facing)[:, None]
        aside = own - (facing + offset)[:, None] * normal
        points[moved] = np.where(flat[:, None], aside, along)
    return points


def survey(
    scan: OrganisedScan,
    level: Level,
    planes: list[ValidPlane],
    labels: np.ndarray,
    firm: np.ndarray,
    ground: list[GroundPlane],
    stairs: list[Stairs],
    robot: RobotConfiguration,
    p: SegmentationParameters,
) -> Survey:
    """Colours each fine cell by what was seen over the local ground.

    Ground lies between neighbouring ground points that are near each other, and up to the feet of
    what stands on it where beams passed over it. What a beam met under the ground is a hole where
    it went through. All else is unknown.
    """
    points = on_their_planes(scan, level, planes, labels, firm)
    is_ground = np.isin(labels, [g.index for g in ground])
    far = np.linalg.norm(points[..., :2], axis=2) > p.max_range
    origin, shape, per_rough, fine = _extent(points[is_ground & ~far], robot, p)
    rough = (shape[0] // per_rough, shape[1] // per_rough)
    heights = ground_height(
        ground, points[is_ground], labels[is_ground], origin, rough, per_rough * fine
    )
    valid = np.isfinite(points).all(axis=2) & ~far
    height = np.full(labels.shape, np.nan)
    height[valid] = points[valid][:, 2] - heights.z(points[valid][:, :2])
    over_flight = np.full(labels.shape, np.nan)
    over_flight[valid] = over_stairs(stairs, points[valid], robot)
    on_flight = np.isfinite(over_flight)
    height[on_flight] = over_flight[on_flight]
    height[on_flight & (height < 0.0)] = 0.0  # a step's edge, no hole
    sunk = height < -_depth(scan, planes, labels, ground, p)
    vertex = _vertices(height, sunk, robot, p)
    vertex[on_flight] = Colour.ORANGE
    cells = _draw(
        points, height, vertex, sunk, heights, is_closed(scan.beta), shape, fine, robot, p
    )
    return Survey(points, height, heights, ColourMap(cells, origin, fine))


def _extent(
    points: np.ndarray, robot: RobotConfiguration, p: SegmentationParameters
) -> tuple[np.ndarray, tuple[int, int], int, float]:
    """Origin, shape in fine cells, fine cells a rough one, and their size [m]."""
    border = p.rough_cell * 4
    low = points[:, :2].min(axis=0) - border
    high = points[:, :2].max(axis=0) + border
    fine, per_rough = p.fine_cell, p.fine_per_rough
    while np.prod((high - low) / fine) > MAX_CELLS and per_rough > 1:
        per_rough = max(1, per_rough // 2)
        fine = p.rough_cell / per_rough
    origin = np.floor(low / p.rough_cell) * p.rough_cell
    columns, rows = (np.ceil((high - origin) / p.rough_cell).astype(int)) * per_rough
    return origin, (int(rows), int(columns)), per_rough, fine


def _depth(
    scan: OrganisedScan,
    planes: list[ValidPlane],
    labels: np.ndarray,
    ground: list[GroundPlane],
    p: SegmentationParameters,
) -> float:
    """[m] under the ground at which no longer noise but a hole is seen."""
    off = [
        planes[plane.index].plane.distance(scan.points[labels == plane.index]) for plane in ground
    ]
    noise = NOISE * -float(np.percentile(np.concatenate(off), 1.0))
    return min(max(SUNK * p.ground_tolerance, noise), p.ground_tolerance)


def _vertices(
    height: np.ndarray, sunk: np.ndarray, robot: RobotConfiguration, p: SegmentationParameters
) -> np.ndarray:
    """(H, W) uint8 colour of each point, UNKNOWN: none of the robot's business."""
    found = np.zeros(height.shape, np.uint8)
    with np.errstate(invalid="ignore"):
        even = (height <= p.ground_tolerance) & ~sunk
        low = (height > 0.0) & (height <= robot.max_obstacle)
        high = (height > robot.max_obstacle) & (height <= robot.clearance)
    found[high | sunk] = Colour.RED  # how deep it is under the beam nobody knows
    found[low] = Colour.ORANGE
    found[even] = Colour.GREEN
    return found


def _draw(
    points: np.ndarray,
    height: np.ndarray,
    vertex: np.ndarray,
    sunk: np.ndarray,
    heights: GroundHeight,
    closed: bool,
    shape: tuple[int, int],
    fine: float,
    robot: RobotConfiguration,
    p: SegmentationParameters,
) -> np.ndarray:
    """(rows, columns) uint8 colours of the fine cells."""
    at = points.copy()
    # a beam that ends under the ground went through it farther to the front
    ended = points[sunk]
    entered = ended * np.clip((ended[:, 2] - height[sunk]) / ended[:, 2], 0.0, 1.0)[:, None]
    same = heights.plane_at(entered[:, :2]) == heights.plane_at(ended[:, :2])
    at[sunk] = np.where(same[:, None], entered, ended)
    at[..., :2] -= heights.origin
    at /= fine
    gap, step = p.mesh_gap / fine, 2.0 * p.ground_tolerance / fine
    vertex = _bridge(at, vertex, gap)
    cover = np.zeros(shape, np.uint8)
    with np.errstate(invalid="ignore"):
        foot = (vertex >= Colour.ORANGE) & (height > 0.0) & (height <= FOOT)
    kinds = np.where(vertex == Colour.GREEN, GROUND, np.where(foot, FEET, NOTHING))
    kernels.draw_ground(at, kinds.astype(np.uint8), closed, gap, step, cover)
    passed = np.zeros(shape, np.uint8)
    start, end = _rays(points, at, heights, robot, fine)
    kernels.draw_rays(start, end, passed)
    cells = ((cover == 1) | ((cover == 2) & (passed > 0))).astype(np.uint8)
    if (vertex == Colour.ORANGE).any():
        rough_ground = np.isin(vertex, (Colour.GREEN, Colour.ORANGE)).astype(np.uint8)
        both = np.zeros(shape, np.uint8)
        kernels.draw_ground(at, rough_ground, closed, gap, robot.max_obstacle / fine + step, both)
        cells[(both == 1) & (cells == 0)] = Colour.ORANGE
    for colour in (Colour.ORANGE, Colour.RED):
        mark = vertex == colour
        column, row = np.floor(at[mark][:, :2]).astype(int).T
        inside = (row >= 0) & (row < shape[0]) & (column >= 0) & (column < shape[1])
        cells[row[inside], column[inside]] = colour
    return cells


def _bridge(at: np.ndarray, vertex: np.ndarray, gap: float) -> np.ndarray:
    """`vertex` with single lost beams between ground on both sides set to ground, and `at` with it.

    A hole of the size of a gap swallows or shows more than one beam.
    """
    found = vertex.copy()
    lost = np.isnan(at[..., 0])
    for axis in (1, 0):
        before, after = np.roll(at, 1, axis), np.roll(at, -1, axis)
        both = (np.roll(vertex, 1, axis) == Colour.GREEN) & (np.roll(vertex, -1, axis) == GROUND)
        with np.errstate(invalid="ignore"):
            near = np.hypot(*np.moveaxis((after - before)[..., :2], -1, 0)) <= gap
        if axis == 1:
            both[:, [0, -1]] = False
        fill = lost & both & near & (found != Colour.GREEN)
        at[fill] = 0.5 * (before[fill] + after[fill])
        found[fill] = Colour.GREEN
    return found


def _rays(
    points: np.ndarray,
    at: np.ndarray,
    heights: GroundHeight,
    robot: RobotConfiguration,
    fine: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Where beams run between ground and the robot's top: start and end (N, 2) in cells."""
    valid = np.isfinite(at).all(axis=2)
    top = float(heights.z(np.zeros((1, 2)))[0]) + robot.clearance  # [m] over the scanner
    z, end = points[valid][:, 2], at[valid][:, :2]
    start = np.zeros_like(end) - heights.origin / fine
    enter = np.zeros(len(z))
    leave = np.ones(len(z))
    if top > 0.0:
        leave[z > top] = top / z[z > top]
    else:
        with np.errstate(divide="ignore", invalid="ignore"):
            enter = np.where(z < top, top / z, np.nan)
    along = end - start
    first, last = start + enter[:, None] * along, start + leave[:, None] * along
    within = np.isfinite(first).all(axis=1)
    return first[within], last[within]
