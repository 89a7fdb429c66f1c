"""Which tracks are persons, as detectors have said so and time has passed since."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Iterable, Sequence

import numpy as np

from safe_passage.core.parameters import check_range
from safe_passage.monitoring.person_looks import Look, Places, in_sight, match, places_of
from safe_passage.monitoring.pipeline import Snapshot

LEAST = 0.7  # a detector that speaks at all says that much
LONGEST_LOOK = 0.5  # [s] that one look stands for


@dataclass(frozen=True)
class PersonLabelParameters:
    """How detections become labels, and how these fade."""

    label_gate: float = 0.6  # [m] farthest from a detection to the track on which it falls
    person_size: float = 1.6  # [m] larger tracks are not labelled: walls, furniture
    person_threshold: float = 0.6  # probability from which on a track is a person
    person_certainty: float = 0.99  # most that all detections together say
    moving_half_life: float = 60.0  # [s] of the log-odds of a track that walks
    standing_half_life: float = 20.0  # [s] of one that stands
    left_half_life: float = 2.0  # [s] of one that stands where a person has gone from
    walking_speed: float = 0.25  # [m/s] from which on a track walks
    walker_probability: float = 0.0  # of who walks where no camera looks; 0: not known
    denial: float = 1.5  # [1/s] log-odds lost while a camera looks at a track and sees nobody
    waiting_time: float = 5.0  # [s] that a detection on no track labels one that appears there
    birth_reach: float = 0.8  # [m] from a person to a new track that may have come from it
    birth_time: float = 1.0  # [s] that such a track is labelled whatever it does
    confirmation_time: float = (
        0.5  # [s] after a detection that a camera counts as seeing the person
    )

    def __post_init__(self) -> None:
        check_range("label_gate", self.label_gate, 0.01, 5.0, "m")
        check_range("person_size", self.person_size, 0.1, 10.0, "m")
        check_range("person_threshold", self.person_threshold, 0.501, LEAST, "")
        check_range("person_certainty", self.person_certainty, LEAST, 0.9999, "")
        for half_life in ("moving_half_life", "standing_half_life", "left_half_life"):
            check_range(half_life, getattr(self, half_life), 0.01, 1e5, "s")
        check_range("walking_speed", self.walking_speed, 0.0, 5.0, "m/s")
        check_range("walker_probability", self.walker_probability, 0.0, 0.9999, "")
        check_range("denial", self.denial, 0.0, 100.0, "1/s")
        check_range("waiting_time", self.waiting_time, 0.0, 60.0, "s")
        check_range("birth_reach", self.birth_reach, 0.0, 5.0, "m")
        check_range("birth_time", self.birth_time, 0.0, 60.0, "s")
        check_range("confirmation_time", self.confirmation_time, 0.0, 60.0, "s")


@dataclass(frozen=True)
class Unattached:
    """A detection that fell on no track."""

    stamp: float  # [s]
    position: tuple[float, float]  # [m] frame of the odometry
    probability: float
    said: Any


@dataclass(frozen=True)
class Persons:
    """Who is a person; N tracks, those of the snapshot."""

    probability: np.ndarray  # (N,) NaN: nobody has judged it
    labelled: np.ndarray  # (N,) bool
    places: dict[int, np.ndarray]  # index of each labelled track -> (M, 2) [m] its pieces, odometry
    said: tuple[Any, ...]  # N; what the detector said of whom it sees now, else None
    unattached: tuple[Unattached, ...]  # new ones


@dataclass(frozen=True)
class _Label:
    odds: float  # log-odds; 0: as likely as not
    detected: float  # [s] when a detector last saw a person here
    said: Any  # by it
    left: bool = False  # what was born beside it may have been the person


class PersonLabels:
    """Keeps the probability of being a person for each track. In doubt a label stays.

    - A detection falls on the nearest confirmed track of a person's size, where that was at the
      detection's time, and adds its log-odds. A wall is never labelled. What falls on no track is
      handed on, and labels a track that appears there soon: nothing is lost.
    - Log-odds halve in a time: long while the track walks, shorter while it stands, as a thing
      does. Time alone never changes their sign; below the threshold the label ends.
    - They shrink faster while a camera looks at the track, nothing is between, and sees nobody.
    - Of a labelled track in pieces each piece may be the person, and is told.
    - A track that appears beside a labelled one is its child, and weakly labelled for a moment: the
      first may have got hold of something else. The child is labelled as well as the first once it
      walks, or when the first is no longer seen: it may be the person, who put a trolley there.
      Standing, the one that is left fades quickly, until a detection falls on it.
    - A detection that falls on the child while none falls on the other moves the label as well.
    - With `walker_probability` whatever is of a person's size and walks is taken for one until a
      camera that looks at it sees nobody: cameras look ahead, people come from everywhere.
    """

    def __init__(self, parameters: PersonLabelParameters) -> None:
        self.tune(parameters)
        self.reset()

    def tune(self, parameters: PersonLabelParameters) -> None:
        """Other parameters from the next cycle on; labels stay."""
        self._p = parameters
        self._most = _log_odds(parameters.person_certainty)
        least = _log_odds(parameters.person_threshold)
        lasting = 2.0 ** (parameters.birth_time / parameters.left_half_life)
        self._weak = min(least * lasting, self._most)

    def reset(self) -> None:
        """Forget everything."""
        self._labels: dict[int, _Label] = {}
        self._parents: dict[int, int] = {}  # id of a child -> id of the labelled track beside it
        self._known: set[int] = set()
        self._told: set[int] = set()  # the confirmed of them
        self._looked: dict[int, float] = {}  # id -> [s] of the last look at its place
        self._waiting: list[Unattached] = []  # detections of whom no lidar has seen yet
        self._last: float | None = None

    def update(self, snapshot: Snapshot, looks: Sequence[Look]) -> Persons:
        """One cycle; `looks`: since the last, of any detectors, not newer than the snapshot."""
        places, ids = places_of(snapshot), snapshot.tracks.id.tolist()
        index = {number: i for i, number in enumerate(ids)}
        self._fade(snapshot, places, index)
        self._note_births(places, index)
        self._greet(snapshot, places, ids)
        unattached = [
            lost
            for look in sorted(looks, key=lambda look: look.stamp)
            for lost in self._take(look, snapshot, places, index)
        ]
        self._wait(unattached)
        self._hand_over(snapshot, places, index)
        self._suppose(snapshot, places, index)
        self._forget(index)
        self._last = snapshot.stamp
        return self._persons(snapshot, places, ids, unattached)

    def _fade(self, snapshot: Snapshot, places: Places, index: dict[int, int]) -> None:
        elapsed = snapshot.stamp - self._last if self._last is not None else 0.0
        p = self._p
        for number, label in self._labels.items():
            walks = number in index and self._walks(snapshot, places, index[number])
            standing = p.left_half_life if label.left else p.standing_half_life
            half_life = p.moving_half_life if walks else standing
            faded = label.odds * 0.5 ** (max(0.0, elapsed) / half_life)
            self._labels[number] = replace(label, odds=faded)

    def _note_births(self, places: Places, index: dict[int, int]) -> None:
        """Remember beside which person a track has appeared."""
        sure = [number for number, label in self._labels.items() if label.odds > self._weak]
        persons = [number for number in sure if number in index]
        for number in index.keys() - self._known:
            i = index[number]
            if persons and places.size[i] <= self._p.person_size:
                distance = places.distances(places.position[i])
                parent = min(persons, key=lambda person: distance[index[person]])
                if distance[index[parent]] <= self._p.birth_reach:
                    self._parents[number] = parent
                    self._labels[number] = _Label(self._weak, -math.inf, None, left=True)
        self._known = set(index)

    def _greet(self, snapshot: Snapshot, places: Places, ids: list[int]) -> None:
        """Label tracks that are told for the first time where a camera has seen somebody before."""
        since = snapshot.stamp - self._p.waiting_time
        self._waiting = [one for one in self._waiting if one.stamp >= since]
        new = snapshot.confirmed & ~np.isin(snapshot.tracks.id, list(self._told))
        self._told = set(snapshot.tracks.id[snapshot.confirmed].tolist())
        if not self._waiting or not new.any():
            return
        seen = np.array([one.position for one in self._waiting])
        chances = np.array([one.probability for one in self._waiting])
        look = Look(snapshot.stamp, seen, chances)
        owner = match(look, places, new & (places.size <= self._p.person_size), self._p.label_gate)
        for one, i in zip(self._waiting, owner):
            if i >= 0:
                self._reinforce(ids[i], one.probability, one.stamp, one.said)
        self._waiting = [one for one, i in zip(self._waiting, owner) if i < 0]

    def _wait(self, lost: Sequence[Unattached]) -> None:
        """The newest detection of each place counts."""
        for new in lost:
            apart = [math.dist(old.position, new.position) for old in self._waiting]
            others = [old for old, d in zip(self._waiting, apart) if d > self._p.label_gate]
            self._waiting = [*others, new]

    def _take(
        self, look: Look, snapshot: Snapshot, places: Places, index: dict[int, int]
    ) -> Iterable[Unattached]:
        """Label the tracks on which its detections fall; those that fall on none are returned."""
        then = places.at(look.stamp - snapshot.stamp)
        fits = snapshot.confirmed & (places.size <= self._p.person_size)
        owner = match(look, then, fits, self._p.label_gate)
        hit = {int(snapshot.tracks.id[i]) for i in owner if i >= 0}
        lost = []
        for k, i in enumerate(owner):
            probability = float(look.probability[k])
            if i < 0:
                x, y = look.position[k].tolist()
                lost.append(Unattached(look.stamp, (x, y), probability, look.told(k)))
            else:
                number = int(snapshot.tracks.id[i])
                self._reinforce(number, probability, look.stamp, look.told(k))
                if self._parents.get(number) not in hit:
                    self._leave(self._parents.pop(number, None), number)
        self._deny(look, then, index)
        return lost

    def _reinforce(self, number: int, probability: float, stamp: float, said: Any) -> None:
        label = self._labels.get(number, _Label(0.0, stamp, said))
        odds = max(label.odds, 0.0) + _log_odds(min(max(probability, LEAST), 0.9999))
        self._labels[number] = _Label(min(odds, self._most), stamp, said)

    def _deny(self, look: Look, then: Places, index: dict[int, int]) -> None:
        """Lower the labels of those whom the detector should have seen."""
        if look.view is None:
            return
        for number, label in list(self._labels.items()):
            if number not in index or not in_sight(look.view, then, index[number]):
                continue
            since = look.stamp - max(label.detected, self._looked.get(number, -math.inf))
            self._looked[number] = look.stamp
            lost = self._p.denial * min(max(since, 0.0), LONGEST_LOOK)
            self._labels[number] = replace(label, odds=max(label.odds - lost, -self._most))

    def _hand_over(self, snapshot: Snapshot, places: Places, index: dict[int, int]) -> None:
        """Label the children that may be the person."""
        for child, parent in list(self._parents.items()):
            if child not in index or parent not in self._labels:
                del self._parents[child]
                continue
            seen = snapshot.tracks.misses == 0
            i = index[child]
            alone = parent not in index or not seen[index[parent]]
            walks = self._walks(snapshot, places, i)
            if seen[i] and snapshot.confirmed[i] and (alone or walks):
                self._leave(self._parents.pop(child), child)

    def _suppose(self, snapshot: Snapshot, places: Places, index: dict[int, int]) -> None:
        """Label who walks where no camera has looked."""
        if self._p.walker_probability < self._p.person_threshold:
            return
        odds = _log_odds(self._p.walker_probability)
        fits = snapshot.confirmed & (places.size <= self._p.person_size)
        for number in index.keys() - self._looked.keys():
            i, label = index[number], self._labels.get(number, _Label(0.0, -math.inf, None))
            if fits[i] and label.odds < odds and self._walks(snapshot, places, i):
                self._labels[number] = replace(label, odds=odds)

    def _leave(self, parent: int | None, child: int) -> None:
        """The child is as much a person as its parent, which may no longer be one."""
        if parent not in self._labels:
            return
        label = self._labels[parent]
        own = self._labels[child]
        self._labels[child] = replace(own, odds=max(own.odds, label.odds), left=False)
        self._labels[parent] = replace(label, left=True)

    def _forget(self, index: dict[int, int]) -> None:
        """Ended tracks; a child may still come of one that has just ended."""
        awaited = set(self._parents.values())
        self._labels = {n: label for n, label in self._labels.items() if n in index or n in awaited}
        self._looked = {n: stamp for n, stamp in self._looked.items() if n in self._labels}

    def _walks(self, snapshot: Snapshot, places: Places, i: int) -> bool:
        speed = float(np.hypot(*places.velocity[i]))
        return bool(snapshot.tracks.moving[i]) and speed >= self._p.walking_speed

    def _persons(
        self,
        snapshot: Snapshot,
        places: Places,
        ids: list[int],
        unattached: list[Unattached],
    ) -> Persons:
        labels = [self._labels.get(number) for number in ids]
        odds = np.array([label.odds if label else math.nan for label in labels], float)
        probability = 1.0 / (1.0 + np.exp(-odds))
        fresh = snapshot.stamp - self._p.confirmation_time
        said = tuple(one.said if one and one.detected >= fresh else None for one in labels)
        with np.errstate(invalid="ignore"):
            labelled = (probability >= self._p.person_threshold) & snapshot.confirmed
        where = {i: places.pieces(i) for i in np.flatnonzero(labelled).tolist()}
        return Persons(probability, labelled, where, said, tuple(unattached))


def _log_odds(probability: float) -> float:
    return math.log(probability / (1.0 - probability))
