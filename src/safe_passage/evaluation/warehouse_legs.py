"""Laser scans of a simulated warehouse, segment by segment: what is a leg, what is the rest."""

from __future__ import annotations

import dataclasses
from collections import Counter
from dataclasses import dataclass
from typing import Iterator, Sequence

import numpy as np

from safe_passage.core.geometry import Pose, compose, placed, rotation
from safe_passage.evaluation.parallel import Workers, batches, run_jobs
from safe_passage.evaluation.setting import Setting
from safe_passage.evaluation.views import ROOM, ViewSampler
from safe_passage.leg_detection.classifiers import LegModel
from safe_passage.leg_detection.scan import Scan
from safe_passage.leg_detection.segmentation import segment
from safe_passage.leg_detection.training_data import LEG, LabelledScan, from_labelled_scans
from safe_passage.simulation.robots import LidarModel
from safe_passage.simulation.sensors import measured_ranges
from safe_passage.simulation.walkers import PersonState
from safe_passage.simulation.worlds import World

SCANS, PERIOD = 10, 0.1  # of a run, [s] from one to the next, as in the recordings
THINGS = {  # what blocks of a material are, at the height of a scanner
    "wood": "pallet",
    "steel": "rack upright",
    "wall": "wall",
    "cardboard": "goods",
    "plastic": "goods",
}


@dataclass(frozen=True)
class LegRun:
    """Consecutive scans of a robot that stands, as the scanners of the recordings do."""

    scans: tuple[LabelledScan, ...]
    laser: Pose  # frame map


@dataclass(frozen=True)
class JudgedSegment:
    """One that a model has judged."""

    points: np.ndarray  # (N, 2) [m], scanner's frame
    label: int  # LEG, OTHER
    probability: float  # of being a leg
    thing: str  # what most of its points lie on; legs: person

    @property
    def false_alarm(self) -> bool:
        return self.label != LEG and self.probability >= 0.5


def draw_runs(setting: Setting, first: int, count: int, workers: Workers) -> list[LegRun]:
    """The runs with the numbers from `first` on; the same number gives the same run."""
    jobs = [(setting, numbers) for numbers in batches(first, count)]
    return [run for part in run_jobs(_draw_batch, jobs, workers, "laser runs") for run in part]


def _draw_batch(job: tuple[Setting, range]) -> list[LegRun]:
    setting, numbers = job
    sampler = ViewSampler(*setting.load())
    try:
        return [draw_run(sampler, number) for number in numbers]
    finally:
        sampler.close()


def draw_run(sampler: ViewSampler, number: int) -> LegRun:
    """One run: people stand, or walk where nothing is in their way."""
    rng = np.random.default_rng((number, 5))
    pose, people = sampler.draw_places(rng)
    end = (SCANS - 1) * PERIOD
    people = [person and _walks_or_stands(sampler, person, end) for person in people]
    scans = []
    for i in range(SCANS):
        time = i * PERIOD
        hits = sampler.exact_scan(pose, [person and _moved(person, time) for person in people])
        ranges = measured_ranges(hits.distances, sampler.lidar, rng)
        scans.append(LabelledScan(as_scan(ranges, sampler.lidar, time), hits.persons >= 0))
    lidar = sampler.lidar
    return LegRun(tuple(scans), compose(pose, (lidar.x, lidar.y, lidar.yaw)))


def as_scan(ranges: np.ndarray, lidar: LidarModel, stamp: float) -> Scan:
    """Ranges (N,) [m] of the lidar as a scan."""
    step = lidar.field_of_view / (lidar.beams - 1)
    half = 0.5 * lidar.field_of_view
    return Scan(ranges, -half, step, lidar.range_min, lidar.range_max, stamp)


def judged_segments(
    model: LegModel, run: LegRun, world: World, height: float
) -> Iterator[JudgedSegment]:
    """All segments of a run that the model classifies; `height` [m]: of the scanner."""
    shape = model.segmentation
    labelled = from_labelled_scans(run.scans, shape, "", judging=True)
    probabilities = model.probabilities(labelled.features)
    verdicts = iter(zip(labelled.labels, probabilities))
    for scan in run.scans:
        segments = segment(scan.scan, shape.jump_distance)
        for start, end in zip(segments.starts, segments.ends):
            if end - start < shape.min_points:
                continue
            points = segments.points[start:end]
            label, probability = next(verdicts)
            thing = "person"
            if label != LEG:
                thing = thing_at(world, placed(points, run.laser), height)
            yield JudgedSegment(points, int(label), float(probability), thing)


def thing_at(world: World, points: np.ndarray, height: float) -> str:
    """What most of `points` (N, 2) [m], frame map, lie on, of what reaches `height` [m]."""
    blocks = [b for b in world.blocks if b.z <= height <= b.z + b.size[2]]
    if not blocks:
        return "nothing"
    away = np.empty((len(blocks), len(points)))
    for distances, block in zip(away, blocks):
        local = np.abs((points - (block.x, block.y)) @ rotation(block.yaw))
        distances[:] = np.hypot(*np.maximum(local - 0.5 * np.array(block.size[:2]), 0.0).T)
    materials = [blocks[i].material for i in np.argmin(away, axis=0)]
    most = Counter(materials).most_common(1)[0][0]
    return THINGS.get(most, most)


def shares(segments: Sequence[JudgedSegment]) -> list[tuple[str, int, int, float]]:
    """By thing: how many segments, how many of them taken for legs, their share of all of those."""
    others = Counter(s.thing for s in segments if s.label != LEG)
    alarms = Counter(s.thing for s in segments if s.false_alarm)
    total = max(sum(alarms.values()), 1)
    return [(thing, n, alarms[thing], alarms[thing] / total) for thing, n in others.most_common()]


def _walks_or_stands(sampler: ViewSampler, person: PersonState, seconds: float) -> PersonState:
    """The person, standing if it would walk into something within `seconds`."""
    along = [_moved(person, time) for time in np.linspace(0.0, seconds, 10)]
    free = all(sampler.room(state.x, state.y) >= ROOM for state in along)
    return person if free else dataclasses.replace(person, velocity=(0.0, 0.0))


def _moved(person: PersonState, time: float) -> PersonState:
    vx, vy = person.velocity
    return dataclasses.replace(
        person,
        x=person.x + vx * time,
        y=person.y + vy * time,
        walked=person.walked + float(np.hypot(vx, vy)) * time,
    )
