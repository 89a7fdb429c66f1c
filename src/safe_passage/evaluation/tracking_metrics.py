"""How well moving people are tracked: CLEAR-MOT and IDF1, by the library motmetrics.

Truth is everyone who has begun to move, from that moment on (pauses included), as long as it is
visible; a tracker's answer is its confirmed tracks that it calls moving and has just seen. Whoever
has moved but is hidden or out of reach is neither wanted nor forbidden: a track on it counts
nothing. Who never moved, and any thing, must not be called moving: its track is a false positive.
A person and a track can be the same within GATE.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, Sequence

import motmetrics
import numpy as np
import pandas
from scipy.optimize import linear_sum_assignment

from safe_passage.evaluation.tracking_recording import Recording
from safe_passage.evaluation.tracking_runs import Told

GATE = 0.5  # [m] between a person's middle and a track's position: half a metre is a person's width
NEAR_PERSON = 0.6  # [m] a track that came so near to a person who moves may be that person
FAR = 1e6
COUNTS = ("num_objects", "num_misses", "num_false_positives", "num_switches")
IDENTITIES = ("idtp", "idfp", "idfn")


class Truth(Protocol):
    """C cycles, P people, as a Recording has them."""

    @property
    def people(self) -> np.ndarray:
        """(C, P, 2 or more) x, y [m], ..., frame of the odometry"""

    @property
    def visible(self) -> np.ndarray:
        """(C, P) bool"""

    @property
    def moved(self) -> np.ndarray:
        """(C, P) bool: has begun to move, by now"""


@dataclass(frozen=True)
class Score:
    """Sums, so that scores can be added."""

    objects: int = 0  # person-cycles that there were to track
    misses: int = 0
    false_positives: int = 0
    switches: int = 0
    matches: int = 0  # person-cycles that were tracked
    distance: float = 0.0  # [m] sum of the matches'
    idtp: int = 0
    idfp: int = 0
    idfn: int = 0
    static_tracks: int = 0
    false_moving: int = 0  # of them

    def __add__(self, other: Score) -> Score:
        names = self.__dataclass_fields__
        return Score(**{name: getattr(self, name) + getattr(other, name) for name in names})

    @property
    def mota(self) -> float:
        """1 - (misses + false positives + switches) / objects; NaN without objects."""
        wrong = self.misses + self.false_positives + self.switches
        return 1.0 - wrong / self.objects if self.objects else float("nan")

    @property
    def motp(self) -> float:
        """[m] mean distance between a person's middle and its track."""
        return self.distance / self.matches if self.matches else float("nan")

    @property
    def idf1(self) -> float:
        """Share of person-cycles with the right identity, harmonic mean of both sides'."""
        both = 2 * self.idtp + self.idfp + self.idfn
        return 2 * self.idtp / both if both else float("nan")

    @property
    def false_moving_share(self) -> float:
        """Of the tracks that were no moving person, those called moving at any time."""
        return self.false_moving / self.static_tracks if self.static_tracks else float("nan")


def score(recording: Recording, cycles: Sequence[Told]) -> Score:
    """Judge what a tracker said about a recording."""
    events = accumulate(recording, cycles)
    host = motmetrics.metrics.create()
    names = [*COUNTS, *IDENTITIES]
    found = host.compute(events, metrics=names, return_dataframe=False)
    matches = tracked(events)  # not its motp: that adds a switch's distance up to three times
    false, static = false_moving(recording, cycles)
    return Score(
        objects=int(found["num_objects"]),
        misses=int(found["num_misses"]),
        false_positives=int(found["num_false_positives"]),
        switches=int(found["num_switches"]),
        matches=len(matches),
        distance=float(matches.D.sum()),
        **{name: int(found[name]) for name in IDENTITIES},
        static_tracks=static,
        false_moving=false,
    )


def accumulate(recording: Truth, cycles: Sequence[Told]) -> motmetrics.MOTAccumulator:
    """Each cycle's people and tracks, as motmetrics takes them."""
    events = motmetrics.MOTAccumulator(auto_id=True)
    for people, visible, moved, said in zip(
        recording.people, recording.visible, recording.moved, cycles
    ):
        answer = said.moving & said.fresh
        ids, positions = said.id[answer], said.position[answer]
        distances = pair_distances(people[:, :2], positions)
        wanted = visible & moved
        kept = ~on_unwanted(distances, wanted, moved & ~wanted)
        within = np.where(distances <= GATE, distances, np.nan)
        events.update(np.flatnonzero(wanted), ids[kept], within[wanted][:, kept])
    return events


def tracked(events: motmetrics.MOTAccumulator) -> pandas.DataFrame:
    """A row for each cycle of each person that had a track."""
    rows = events.mot_events
    return rows[rows.Type.isin(["MATCH", "SWITCH"])]


def pair_distances(people: np.ndarray, tracks: np.ndarray) -> np.ndarray:
    """(P, N) [m] between `people` (P, 2) and `tracks` (N, 2)."""
    return np.hypot(*np.moveaxis(people[:, None] - tracks[None], -1, 0))


def on_unwanted(distances: np.ndarray, wanted: np.ndarray, unwanted: np.ndarray) -> np.ndarray:
    """Which tracks (N,) are those of people who are not judged.

    Args:
        distances: (P, N) [m] of each person and track.
        wanted, unwanted: (P,) bool: people who are judged, and who are left out.
    """
    rows = np.flatnonzero(wanted | unwanted)
    near = np.where(distances[rows] <= GATE, distances[rows], FAR)
    row, column = linear_sum_assignment(near)
    found = (near[row, column] < FAR) & unwanted[rows[row]]
    left_out = np.zeros(distances.shape[1], bool)
    left_out[column[found]] = True
    return left_out


def false_moving(recording: Recording, cycles: Sequence[Told]) -> tuple[int, int]:
    """Tracks of what does not move that are called moving at any time, and all such tracks."""
    movers = recording.moved.any(axis=0)
    near: set[int] = set()
    called: set[int] = set()
    known: set[int] = set()
    for people, said in zip(recording.people, cycles):
        distances = pair_distances(people[movers, :2], said.position)
        near.update(said.id[distances.min(axis=0, initial=np.inf) < NEAR_PERSON].tolist())
        called.update(said.id[said.moving].tolist())
        known.update(said.id.tolist())
    static = known - near
    return len(static & called), len(static)


def identities(recording: Truth, cycles: Sequence[Told]) -> dict[int, list[int]]:
    """The track ids that each person had, in order."""
    matched = tracked(accumulate(recording, cycles))
    return {
        int(person): list(dict.fromkeys(int(i) for i in rows.HId))
        for person, rows in matched.groupby("OId")
    }
