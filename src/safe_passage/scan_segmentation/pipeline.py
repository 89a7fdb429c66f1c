"""One scan -> planes -> ground -> where the robot fits (paper 003)."""

from __future__ import annotations

import dataclasses
import time
from dataclasses import dataclass
from typing import Callable, Mapping

import numpy as np

from safe_passage.scan_segmentation.basic_map import ColourMap, Survey, survey
from safe_passage.scan_segmentation.doors import Door, find_doors
from safe_passage.scan_segmentation.ground import GroundPlane, ground_candidates, select_ground
from safe_passage.scan_segmentation.lines import Segments, find_segments
from safe_passage.scan_segmentation.parameters import RobotConfiguration, SegmentationParameters
from safe_passage.scan_segmentation.planes import cluster_segments
from safe_passage.scan_segmentation.scan import (
    MIN_LINES,
    MIN_POINTS,
    Level,
    OrganisedScan,
    Reason,
    SegmentationError,
)
from safe_passage.scan_segmentation.stairs import Stairs, find_stairs
from safe_passage.scan_segmentation.traversability import check_traversability
from safe_passage.scan_segmentation.validation import ValidPlane, validate

LEAST_EXTENT = 0.3  # [m] of a cloud in its second direction
STAGES = ("lines", "planes", "ground", "map", "traversability", "doors")
Progress = Callable[[str, float], bool]  # stage that begins, share done; False: cancel


@dataclass(frozen=True)
class Planes:
    """What is known before the ground is looked for."""

    scan: OrganisedScan  # as it was used
    segments: Segments
    owner: np.ndarray  # (S,) plane of each segment before validation, -1: none
    valid: list[ValidPlane]  # largest first
    labels: np.ndarray  # (H, W) valid plane of each point, -1: none
    firm: np.ndarray  # (H, W) bool, points inside a segment of their plane
    notes: tuple[str, ...]  # what was done to the scan, for the operator


@dataclass(frozen=True)
class Segmentation:
    """All that one scan showed. Frame: level, z up, origin in the scanner."""

    planes: Planes
    level: Level
    ground: list[GroundPlane]
    survey: Survey  # points, heights, and the basic map
    drivable: ColourMap  # for the robot's centre
    doors: list[Door]
    stairs: list[Stairs]
    robot: RobotConfiguration
    seconds: dict[str, float]  # of each stage

    @property
    def basic(self) -> ColourMap:
        """What stands where."""
        return self.survey.map


class ScanSegmenter:
    """Segments scans, one by one."""

    def __init__(self, parameters: SegmentationParameters | None = None) -> None:
        self._p = parameters or SegmentationParameters()

    def segment(
        self,
        scan: OrganisedScan,
        robot: RobotConfiguration | None = None,
        robots: Mapping[str, RobotConfiguration] | None = None,
        progress: Progress | None = None,
        on_planes: Callable[[Planes], None] | None = None,
    ) -> Segmentation:
        """Where `robot` can drive.

        Args:
            robots: other configurations that doors are measured against, by name.
            progress: is told each stage as it begins; False from it cancels.
            on_planes: is given the planes before the rest is done.

        Raises:
            SegmentationError: the scan does not support a result, or it was cancelled.
        """
        robot = robot or RobotConfiguration()
        watch = _Watch(progress)
        planes = self._planes(scan, watch)
        if on_planes is not None:
            on_planes(planes)
        watch.begin("ground")
        scan, level = planes.scan, Level.of(planes.scan)
        points = level.points(scan.points[scan.valid].astype(np.float64))
        labels = planes.labels[scan.valid]
        candidates = ground_candidates(planes.valid, level, robot.max_slope)
        ground = select_ground(candidates, planes.valid, points, labels, self._p)
        stairs = find_stairs(points, ground[0], _no_steps(planes.valid, level)[labels])
        watch.begin("map")
        seen = survey(
            scan, level, planes.valid, planes.labels, planes.firm, ground, stairs, robot, self._p
        )
        watch.begin("traversability")
        drivable = check_traversability(seen.map, robot, _walls(planes.valid, level), self._p)
        watch.begin("doors")
        named = {**(robots or {}), **({} if robots else {"robot": robot})}
        doors = find_doors(seen, level, planes.valid, planes.labels, named)
        seconds = watch.end()
        return Segmentation(planes, level, ground, seen, drivable, doors, stairs, robot, seconds)

    def find_planes(self, scan: OrganisedScan) -> Planes:
        """The first half alone."""
        return self._planes(scan, _Watch(None))

    def _planes(self, scan: OrganisedScan, watch: _Watch) -> Planes:
        watch.begin("lines")
        scan = usable(scan, self._p)
        segments = find_segments(scan, self._p)
        watch.begin("planes")
        planes, owner = cluster_segments(scan, segments, self._p)
        valid, labels = validate(scan, segments, planes, owner, self._p)
        if not valid:
            seen = f"{len(segments)} segments, {len(planes)} planes, none large enough"
            raise SegmentationError(Reason.NO_PLANE, seen)
        return Planes(
            scan, segments, owner, valid, labels, segments.inner_points(labels.shape), scan.notes
        )


def usable(scan: OrganisedScan, p: SegmentationParameters) -> OrganisedScan:
    """The scan without what is no measurement, thinned out where it is too large.

    Raises:
        SegmentationError: too little is left, or it has no extent.
    """
    notes = list(scan.notes)
    step = int(np.ceil(np.sqrt(scan.points.shape[0] * scan.points.shape[1] / p.max_points)))
    if step > 1:
        remission = None if scan.remission is None else scan.remission[::step, ::step]
        scan = dataclasses.replace(
            scan,
            points=scan.points[::step, ::step],
            beta=scan.beta[::step],
            remission=remission,
        )
        notes.append(f"thinned out: one line in {step}, of it one point in {step}")
    with np.errstate(over="ignore", invalid="ignore"):
        distance = np.linalg.norm(scan.points - np.asarray(scan.origin), axis=2)
        wrong = ~(distance <= p.max_range)
    points = scan.points
    far = int((wrong & np.isfinite(points).all(axis=2)).sum())
    if far:
        notes.append(f"{far} points beyond {p.max_range:g} m are left out")
    points = np.where(wrong[..., None], np.nan, points).astype(np.float32)
    scan = dataclasses.replace(scan, points=points, notes=tuple(notes))
    _check_extent(scan)
    return scan


def _check_extent(scan: OrganisedScan) -> None:
    inside = scan.valid
    count, lines = int(inside.sum()), int(inside.any(axis=1).sum())
    if count < MIN_POINTS or lines < MIN_LINES:
        detail = f"{count} points on {lines} lines, {MIN_POINTS} on {MIN_LINES} are needed"
        raise SegmentationError(Reason.TOO_FEW_POINTS, detail)
    points = scan.points[inside].astype(np.float64)
    spread = np.sqrt(np.linalg.eigvalsh(np.cov(points.T)))  # ascending
    if 4.0 * spread[1] < LEAST_EXTENT:
        detail = f"the points reach {4 * spread[2]:.2f} m by {4 * spread[1]:.2f} m"
        raise SegmentationError(Reason.DEGENERATE, detail)


def _normals(planes: list[ValidPlane], level: Level) -> np.ndarray:
    return np.array([level.R_level_scan @ valid.plane.normal for valid in planes])


def _walls(planes: list[ValidPlane], level: Level) -> list[float]:
    """[rad] directions of walls' normals."""
    normals = _normals(planes, level)
    return [float(np.arctan2(n[1], n[0])) for n in normals if abs(n[2]) < 0.3]


def _no_steps(planes: list[ValidPlane], level: Level) -> np.ndarray:
    """(P + 1,) bool: planes that are no part of stairs, walls and ramps; False for no plane."""
    upward = np.abs(_normals(planes, level)[:, 2])
    large = np.array([valid.area > 1.0 for valid in planes])
    return np.append(large & ((upward < 0.2) | ((upward > 0.7) & (upward < 0.998))), False)


class _Watch:
    """Times stages, tells how far it is."""

    def __init__(self, progress: Progress | None) -> None:
        self._progress, self._stage = progress, ""
        self._since = time.perf_counter()
        self.seconds: dict[str, float] = {}

    def begin(self, stage: str) -> None:
        self.end()
        self._stage = stage
        share = STAGES.index(stage) / len(STAGES)
        if self._progress is not None and self._progress(stage, share) is False:
            raise SegmentationError(Reason.CANCELLED, f"before {stage}")

    def end(self) -> dict[str, float]:
        now = time.perf_counter()
        if self._stage:
            self.seconds[self._stage] = now - self._since
        self._since = now
        return self.seconds
