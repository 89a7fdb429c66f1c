"""What is known of recorded scans: who was marked, what came and went, who that was over time.

Recordings have no truth as a simulator has. They tell, each in its own way, where somebody was:
legs are marked, another vehicle is followed by cameras, nobody was there at all; or the scanner
stood still, so that what most scans show in the same place is furniture and the rest has come.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from safe_passage.leg_detection.persons import Leg, pair_legs
from safe_passage.leg_detection.scan import Scan
from safe_passage.leg_detection.segmentation import segment
from safe_passage.leg_detection.training_data import background_beams

JUMP = 0.13  # [m] between neighbours of two things
POINTS = 4  # of a thing that has come; fewer may be an edge that two beams meet in turn
BODY = 0.8  # [m] what is larger is no person's leg or body
BOTH_LEGS = 0.7  # [m] apart at most
STEP = 0.7  # [m] somebody may be from where he was last seen
ABSENT = 1.0  # [s] who was not seen for longer is somebody else
MOVED = 0.5  # [m] from where he was first seen: from then on he is known to move
FAR = 1e6


@dataclass(frozen=True)
class People:
    """C cycles, P people (or other movers), frame of the odometry."""

    people: np.ndarray  # (C, P, 2) [m], NaN where not seen
    visible: np.ndarray  # (C, P) bool
    moved: np.ndarray  # (C, P) bool: has gone MOVED, by now


def persons_of_legs(legs: np.ndarray) -> np.ndarray:
    """Middles (P, 2) [m] of persons whose `legs` (L, 2) [m] are known; one leg may be hidden."""
    found = [Leg((float(x), float(y)), 1.0) for x, y in legs]
    pairs = pair_legs(found, BOTH_LEGS, lone_legs=True)
    return np.array([person.position for person in pairs]).reshape(-1, 2)


@dataclass(frozen=True)
class Newcomers:
    """What is in a scan, but not in most of them; frame of the scanner."""

    persons: np.ndarray  # (P, 2) [m] middles of what is as small as a person
    points: np.ndarray  # (M, 2) [m] all of it


def newcomers(scans: Sequence[Scan]) -> list[Newcomers]:
    """Of each scan of a scanner that stands still."""
    return [_new(scan, furniture) for scan, furniture in zip(scans, background_beams(scans))]


def _new(scan: Scan, furniture: np.ndarray) -> Newcomers:
    segments = segment(scan, JUMP)
    if not len(segments):
        return Newcomers(np.empty((0, 2)), np.empty((0, 2)))
    new = 2.0 * segments.sums(furniture[segments.beams].astype(float)) < segments.sizes
    new &= segments.sizes >= POINTS
    width = np.hypot(*(segments.points[segments.ends - 1] - segments.points[segments.starts]).T)
    persons = persons_of_legs(segments.centres()[new & (width < BODY)])
    return Newcomers(persons, segments.points[new[segments.owners]])


def linked(stamps: np.ndarray, places: Sequence[np.ndarray]) -> People:
    """Who is who: each place is that of the nearest one seen shortly before, or of somebody new.

    Args:
        stamps: (C,) [s].
        places: of each cycle (N, 2) [m], frame of the odometry.
    """
    last: list[tuple[float, np.ndarray]] = []  # of each person: when and where
    numbers: list[int] = []
    for stamp, found in zip(stamps, places):
        alive = [i for i, (seen, _) in enumerate(last) if stamp - seen <= ABSENT]
        before = np.array([last[i][1] for i in alive]).reshape(-1, 2)
        away = np.hypot(*np.moveaxis(found[:, None] - before[None], -1, 0))
        row, column = linear_sum_assignment(np.where(away <= STEP, away, FAR))
        known = {int(r): alive[int(c)] for r, c in zip(row, column) if away[r, c] <= STEP}
        for i, place in enumerate(found):
            number = known.get(i, len(last))
            last[number : number + 1] = [(float(stamp), place)]
            numbers.append(number)
    return _people(places, numbers, len(last))


def _people(places: Sequence[np.ndarray], numbers: Sequence[int], count: int) -> People:
    """`numbers`: of the person at each place, cycle by cycle."""
    people = np.full((len(places), count, 2), np.nan)
    left = iter(numbers)
    for cycle, found in enumerate(places):
        for place in found:
            people[cycle, next(left)] = place
    visible = np.isfinite(people[..., 0])
    first = people[visible.argmax(axis=0), np.arange(count)]
    with np.errstate(invalid="ignore"):
        gone = np.hypot(*np.moveaxis(people - first, -1, 0)) >= MOVED
    return People(people, visible, np.logical_or.accumulate(gone, axis=0))
