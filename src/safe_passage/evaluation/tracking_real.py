"""The obstacle tracker on real recordings, with the node's own parameters.

What is judged depends on what a recording tells: somebody's marked legs, where another vehicle was,
that nobody was there; or, of a scanner that stands still and nothing more, what came and went.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Sequence

import numpy as np

from safe_passage.core.geometry import Pose, matrix, placed
from safe_passage.evaluation.tracking_metrics import (
    GATE,
    NEAR_PERSON,
    Truth,
    accumulate,
    identities,
    tracked,
)
from safe_passage.evaluation.tracking_real_truth import (
    Newcomers,
    People,
    linked,
    newcomers,
    persons_of_legs,
)
from safe_passage.evaluation.tracking_runs import FRESH, Told, told, tracker_parameters
from safe_passage.leg_detection.scan import Scan
from safe_passage.monitoring.aggregation import Measurement
from safe_passage.monitoring.parameters import SourceParameters, TrackerParameters
from safe_passage.monitoring.pipeline import ObstacleTracker, Snapshot
from safe_passage.monitoring.preprocessing import scan_points
from safe_passage.monitoring.views import ScanView

LEGS, VEHICLE, NOBODY, CAME = "marked legs", "other vehicle", "nobody there", "what came"
GAP = 1.0  # [s] without scans: what was cut out of a recording; the tracker begins anew
DT = 0.1  # [s] before and after, for a vehicle's velocity
NOWHERE = np.empty((0, 2))
SEEN = 0.35  # [m] from a vehicle's middle to a point of it


@dataclass(frozen=True)
class RealScanner:
    """What one scanner measured."""

    name: str  # as the yaml calls it
    scans: Sequence[Scan]  # in order of time
    mounting: Pose = (0.0, 0.0, 0.0)  # in base
    legs: Sequence[np.ndarray] | None = None  # (L, 2) [m] a scan, scanner's frame, where marked


@dataclass(frozen=True)
class RealRecording:
    """Scans of a robot that stands, or that drives on a known way.

    Ways: (K, 4) [s], x, y [m], yaw [rad] without jumps, frame of the odometry; empty: none.
    """

    name: str
    config: str  # the node's yaml that fits
    truth: str  # LEGS | VEHICLE | NOBODY | CAME
    scanners: tuple[RealScanner, ...]  # a cycle for each scan of the first one
    footprint: tuple[tuple[float, float], ...] = ()  # [m] of the robot; empty: not known
    way: np.ndarray = field(default_factory=lambda: np.empty((0, 4)))  # [s], pose of base
    vehicle: np.ndarray = field(default_factory=lambda: np.empty((0, 4)))  # [s], its pose

    @property
    def stands(self) -> bool:
        """Whether the robot does."""
        return not len(self.way)


@dataclass(frozen=True)
class Cycle:
    """What was measured since the last one."""

    stamp: float  # [s]
    scans: tuple[tuple[int, int], ...]  # of which scanner, which one


@dataclass(frozen=True)
class Run:
    """What the tracker said about a recording; frame of the odometry."""

    recording: RealRecording
    cycles: list[Cycle]
    poses: list[Pose]  # of base
    snapshots: list[Snapshot]
    told: list[Told]
    points: list[np.ndarray]  # (N, 2) [m] measured in each cycle
    milliseconds: np.ndarray  # of each cycle


@dataclass(frozen=True)
class Result:
    """How good that was."""

    recording: RealRecording
    seconds: float
    cycles: int
    tracks: float  # confirmed, in a cycle
    called_moving: int  # tracks, at any time
    movers: int  # that were seen to move
    found: int  # of them with a moving track at any time
    ids: int  # most that one of them had
    wait: (
        float  # [s] from when a mover had gone MOVED to its first moving track, median of the found
    )
    mover_cycles: int
    tracked: int  # of them with a moving track within half a metre
    error: float  # [m] mean distance then
    speed_error: float  # [m/s] median, where it is known
    static_tracks: int  # never near anything that could have moved
    false_moving: int  # of them called moving at any time
    milliseconds: float  # a cycle, median


def judge(recording: RealRecording, config: Path) -> tuple[Run, Truth, Result]:
    """Run the tracker and compare.

    Args:
        config: folder of the package's parameters.
    """
    ran = run(recording, parameters_for(recording, config))
    truth, mobile = truth_of(ran)
    return ran, truth, result(ran, truth, mobile)


def parameters_for(recording: RealRecording, config: Path) -> TrackerParameters:
    """The node's, with the sensors that there are and this robot's outline."""
    usual = tracker_parameters(config, name=recording.config)
    names = [scanner.name for scanner in recording.scanners]
    sources = tuple(source for source in usual.sources if source.name in names)
    return replace(usual, sources=sources, footprint=recording.footprint)


def cycles_of(recording: RealRecording) -> list[Cycle]:
    """One for each scan of the first scanner, with the others' that came since the last."""
    stamps = [np.array([scan.stamp for scan in one.scans]) for one in recording.scanners]
    cycles, taken = [], np.zeros(len(stamps), int)
    for stamp in stamps[0]:
        upto = np.array([np.searchsorted(own, stamp, side="right") for own in stamps])
        new = [(i, j) for i, (a, b) in enumerate(zip(taken, upto)) for j in range(a, b)]
        cycles.append(Cycle(float(stamp), tuple(new)))
        taken = upto
    return cycles


def pose_at(way: np.ndarray, stamp: float) -> Pose:
    """On a way (K, 4); the origin where there is none."""
    if not len(way):
        return 0.0, 0.0, 0.0
    x, y, yaw = (float(np.interp(stamp, way[:, 0], values)) for values in way[:, 1:].T)
    return x, y, yaw


def run(recording: RealRecording, parameters: TrackerParameters) -> Run:
    """All cycles; the time of one is that of its preprocessing and the tracker's update."""
    tracker = ObstacleTracker(parameters)
    sources = {source.name: source for source in parameters.sources}
    cycles = cycles_of(recording)
    every = float(np.median(np.diff([cycle.stamp for cycle in cycles])))
    poses, snapshots, points, ms = [], [], [], []
    for before, cycle in zip([cycles[0], *cycles], cycles):
        if cycle.stamp - before.stamp > GAP:
            tracker.reset()
        start = time.perf_counter()
        measured = [
            _measurement(recording, recording.scanners[i], j, sources) for i, j in cycle.scans
        ]
        pose = pose_at(recording.way, cycle.stamp)
        snapshots.append(tracker.update(cycle.stamp, pose, measured))
        ms.append(1e3 * (time.perf_counter() - start))
        poses.append(pose)
        points.append(np.concatenate([placed(m.points[:, :2], m.pose) for m in measured]))
    said = [told(one, max(1, int(FRESH / every))) for one in snapshots]
    return Run(recording, cycles, poses, snapshots, said, points, np.array(ms))


def _measurement(
    recording: RealRecording,
    scanner: RealScanner,
    number: int,
    sources: dict[str, SourceParameters],
) -> Measurement:
    scan = scanner.scans[number]
    with np.errstate(invalid="ignore"):
        measured = (scan.ranges >= scan.range_min) & (scan.ranges <= scan.range_max)
    ranges = np.where(measured, scan.ranges, np.nan)  # as the node reads a message
    source, T = sources[scanner.name], matrix(scanner.mounting)
    points = scan_points(ranges, scan.angle_min, scan.angle_increment, T, source)
    pose = pose_at(recording.way, scan.stamp)
    return Measurement(
        source.name, scan.stamp, pose, points, ScanView.of(points, scanner.mounting[:2])
    )


def truth_of(ran: Run) -> tuple[People, list[np.ndarray]]:
    """Who moved, and of each cycle the points (N, 2) [m] of all that could have."""
    recording = ran.recording
    by_background = recording.truth in (LEGS, CAME)
    came = [newcomers(one.scans) if by_background else [] for one in recording.scanners]
    places, mobile = [], []
    for cycle, points in zip(ran.cycles, ran.points):
        if recording.truth == VEHICLE:
            middle = np.array(pose_at(recording.vehicle, cycle.stamp)[:2])
            seen = bool((np.hypot(*(points - middle).T) < SEEN).any())
            places.append(middle[None] if seen else NOWHERE)
            mobile.append(middle[None])
        elif by_background:
            here, could = zip(*(_came(recording.scanners[i], came[i], j) for i, j in cycle.scans))
            several = len(recording.scanners) > 1  # that see the same person
            places.append(persons_of_legs(np.concatenate(here)) if several else here[0])
            mobile.append(np.concatenate([*here, *could]))
        else:
            places.append(NOWHERE)
            mobile.append(NOWHERE)
    return linked(np.array([cycle.stamp for cycle in ran.cycles]), places), mobile


def _came(
    scanner: RealScanner, came: Sequence[Newcomers], number: int
) -> tuple[np.ndarray, np.ndarray]:
    """Persons, and points of all that is no furniture; frame base."""
    new = came[number]
    persons = new.persons if scanner.legs is None else persons_of_legs(scanner.legs[number])
    return placed(persons, scanner.mounting), placed(new.points, scanner.mounting)


def result(ran: Run, truth: People, mobile: Sequence[np.ndarray]) -> Result:
    """Judge what was said."""
    events = accumulate(truth, ran.told)
    matches = tracked(events)
    ids = identities(truth, ran.told)
    stamps = np.array([cycle.stamp for cycle in ran.cycles])
    wanted = truth.visible & truth.moved
    first = matches.reset_index().groupby("OId").FrameId.min()
    waits = [
        stamps[int(frame)] - stamps[wanted[:, int(person)].argmax()]
        for person, frame in first.items()
    ]
    static, false = _static(ran.told, mobile)
    moving = np.concatenate([said.id[said.moving] for said in ran.told])
    return Result(
        ran.recording,
        seconds=float(stamps[-1] - stamps[0]),
        cycles=len(stamps),
        tracks=float(np.mean([len(said.id) for said in ran.told])),
        called_moving=len(np.unique(moving)),
        movers=int(wanted.any(axis=0).sum()),
        found=len(ids),
        ids=max(map(len, ids.values()), default=0),
        wait=float(np.median(waits)) if waits else float("nan"),
        mover_cycles=int(wanted.sum()),
        tracked=len(matches),
        error=float(matches.D.mean()) if len(matches) else float("nan"),
        speed_error=_speed_error(ran),
        static_tracks=len(static),
        false_moving=len(false),
        milliseconds=float(np.median(ran.milliseconds)),
    )


def _static(cycles: Sequence[Told], mobile: Sequence[np.ndarray]) -> tuple[set[int], set[int]]:
    """Tracks that were never near anything that could move; those called moving all the same."""
    known: set[int] = set()
    near: set[int] = set()
    called: set[int] = set()
    for said, points in zip(cycles, mobile):
        known.update(said.id.tolist())
        called.update(said.id[said.moving].tolist())
        away = np.hypot(*np.moveaxis(said.position[:, None] - points[None], -1, 0))
        near.update(said.id[away.min(axis=1, initial=np.inf) < NEAR_PERSON].tolist())
    return known - near, (known - near) & called


def _speed_error(ran: Run) -> float:
    """[m/s] of the vehicle's moving track, median; NaN without a vehicle."""
    way, errors = ran.recording.vehicle, []
    for cycle, said in zip(ran.cycles, ran.told):
        if not len(way):
            break
        before, now, after = (np.array(pose_at(way, cycle.stamp + dt)[:2]) for dt in (-DT, 0, DT))
        away = np.hypot(*(said.position - now).T)
        for i in np.flatnonzero(said.moving & said.fresh & (away <= GATE)):
            errors.append(np.hypot(*(said.velocity[i] - (after - before) / (2 * DT))))
    return float(np.median(errors)) if errors else float("nan")
