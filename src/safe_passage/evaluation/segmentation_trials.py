"""Scan segmentation in random places with truth: doors, false ways, planes."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from safe_passage.evaluation.segmentation_places import Case, blocked_at, in_world, random_case
from safe_passage.scan_segmentation import (
    Colour,
    ColourMap,
    RobotConfiguration,
    ScanSegmenter,
    Segmentation,
    SegmentationError,
    SegmentationParameters,
)
from safe_passage.scan_segmentation.pipeline import Planes
from safe_passage.scan_segmentation.planes import Plane
from safe_passage.scan_segmentation.traversability import fine_map, orientations
from safe_passage.simulation.scan_scene import Place, Scanner, scan_place, upright

ROBOT = RobotConfiguration(length=1.2, width=0.85, height=1.4)
LEAST_AREA = 1.0  # [m^2] of a plane whose accuracy is judged
WIDE = 0.5  # [m] to its narrower side, as far as it was seen; noise turns a strip more than that
SEEN = 0.9  # of a plane's points on one surface: others are of several that lie in one plane
TOLERANCE = 2  # fine cells by which the true robot is narrower when ways are judged


@dataclass(frozen=True)
class PlaneErrors:
    """Of all planes of a scan that are large enough."""

    normal: np.ndarray  # (N,) [deg]
    offset: np.ndarray  # (N,) [mm] at the middle of its points
    wide: np.ndarray  # (N,) bool, not only a strip of it was seen


@dataclass(frozen=True)
class Trial:
    """What came of one random place."""

    number: int
    refused: str  # reason, empty: it was segmented
    width: float  # [m] of the door
    found_width: float = math.nan  # [m], NaN: not found
    least_width: float = math.nan  # [m] that the door surely has
    says_passable: bool = False  # the door does
    map_passes: bool = False  # drivable cells lead through
    false_cells: int = 0  # drivable where truth has a wall, a thing or a hole
    false_fits: int = 0  # drivable where the robot touches one in every orientation
    drivable_cells: int = 0
    errors: PlaneErrors | None = None

    @property
    def passable(self) -> bool:
        """By truth."""
        return self.width >= ROBOT.width

    def is_close(self, cell: float) -> bool:
        """Whether the door is as wide as the robot to a fine cell."""
        return abs(self.width - ROBOT.width) <= cell

    @property
    def is_right(self) -> bool:
        """The door says what is true, and no way leads through one that is too narrow."""
        return self.says_passable == self.passable and not (self.map_passes and not self.passable)


@dataclass(frozen=True)
class TrialJob:
    """One of a number of random places."""

    number: int
    seed: int
    upright: bool = False  # the scanner turns about the vertical: lines run along door frames


def judge_trial(job: TrialJob) -> Trial:
    """Segments one random place and holds it against the truth."""
    case = random_case(job.number, job.seed)
    if job.upright:
        case = replace(case, scanner=upright(case.scanner))
    scan, which = scan_place(case.place, case.scanner, job.number + job.seed)
    door = case.place.doors[0]
    try:
        found = ScanSegmenter().segment(scan, ROBOT, {"robot": ROBOT})
    except SegmentationError as error:
        return Trial(job.number, error.reason.name, door.width)
    false_cells, false_fits, drivable = judge_map(case, found)
    width, least, passable = _door(case, found)
    return Trial(
        job.number,
        "",
        door.width,
        width,
        least,
        passable,
        leads_through(case, found.drivable),
        false_cells,
        false_fits,
        drivable,
        plane_errors(case.place, case.scanner, found.planes, which),
    )


def plane_errors(place: Place, scanner: Scanner, planes: Planes, which: np.ndarray) -> PlaneErrors:
    """Each plane against the surface that most of its points are of.

    Args:
        which: (H, W) surface of each point, -1: no return.
    """
    surfaces, R = place.surfaces(), scanner.rotation()
    angles, offsets, wide = [], [], []
    for k, valid in enumerate(planes.valid):
        own = planes.labels == k
        counts = np.bincount(which[own] + 1, minlength=2)[1:]
        if valid.area < LEAST_AREA or counts.max() < SEEN * counts.sum():
            continue
        patch = surfaces[int(counts.argmax())]
        normal = np.cross(patch.along, patch.across)
        normal /= np.linalg.norm(normal)
        points = planes.scan.points[own].astype(float)
        middle = R @ (points.mean(axis=0) - _off(valid.plane, points)) + scanner.position
        angles.append(math.degrees(math.acos(min(1.0, abs(normal @ R @ valid.plane.normal)))))
        offsets.append(1e3 * abs(normal @ (middle - patch.corner)))
        spread = np.sqrt(np.linalg.eigvalsh(np.cov(points.T))[1])
        wide.append(math.sqrt(12.0) * spread >= WIDE)  # of an evenly filled strip
    return PlaneErrors(np.array(angles), np.array(offsets), np.array(wide, bool))


def _off(plane: Plane, points: np.ndarray) -> np.ndarray:
    """(3,) [m] from the plane to the points' middle."""
    return plane.distance(points.mean(axis=0)) * plane.normal


def judge_map(case: Case, found: Segmentation) -> tuple[int, int, int]:
    """Drivable cells that are none, those where the robot does not fit, and all of them."""
    colours = found.drivable
    drivable = np.isin(colours.cells, (Colour.GREEN, Colour.ORANGE))
    row, column = np.indices(colours.cells.shape)
    at = colours.origin + (np.stack([column, row], axis=-1) + 0.5) * colours.resolution
    world = in_world(case.scanner, at.reshape(-1, 2))
    truth = blocked_at(case.place, world, ROBOT.max_obstacle, ROBOT.clearance)
    blocked = truth.reshape(drivable.shape)
    less = 2.0 * TOLERANCE * colours.resolution
    narrower = replace(ROBOT, width=ROBOT.width - less, length=ROBOT.length - less)
    walls = [-case.scanner.yaw]
    angles = orientations(walls, SegmentationParameters(orientations=72))
    padded = np.pad(blocked, 100)  # what lies beyond the map is its own business
    ask = np.pad(drivable, 100)
    fits = fine_map(padded, ask, narrower, angles, 1, colours.resolution)
    return int((drivable & blocked).sum()), int((ask & ~fits).sum()), int(drivable.sum())


def leads_through(case: Case, colours: ColourMap) -> bool:
    """Whether drivable cells lead from before the wall into the doorway of the true door."""
    door = case.place.doors[0]
    drivable = np.isin(colours.cells, (Colour.GREEN, Colour.ORANGE))
    row, column = np.nonzero(drivable)
    at = colours.origin + (np.stack([column, row], axis=1) + 0.5) * colours.resolution
    world = in_world(case.scanner, at)
    near = (np.abs(world[:, 0] - door.x) < 1.0) & (np.abs(world[:, 1] - door.y) < 1.0)
    part = np.zeros_like(drivable)
    part[row[near], column[near]] = True
    of, _ = ndimage.label(part, np.ones((3, 3)))
    found = of[row[near], column[near]]
    before = set(found[world[near, 0] < door.x - 0.3])
    behind = set(found[world[near, 0] > door.x + 0.5 * door.thickness])
    return bool(before & behind)


def _door(case: Case, found: Segmentation) -> tuple[float, float, bool]:
    """Width and least width of the door found in the true one, and whether it says passable."""
    true = case.place.doors[0]
    for door in found.doors:
        x, y = in_world(case.scanner, np.array([door.middle[:2]]))[0]
        if abs(x - true.x) < 0.3 + true.thickness and abs(y - true.y) < 0.3:
            return door.width, door.least_width, bool(door.passable_by)
    return math.nan, math.nan, False
