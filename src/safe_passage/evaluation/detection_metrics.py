"""Detection metrics of paper 002, section 3.1."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Collection, Iterable

import numpy as np


@dataclass(frozen=True)
class DetectionCounts:
    """Candidates by truth and verdict; a metric without any case to judge is NaN."""

    tp: int = 0  # persons accepted
    fp: int = 0  # others accepted
    fn: int = 0  # persons missed, whether rejected or never proposed
    tn: int = 0  # others rejected

    @classmethod
    def of(cls, truth: np.ndarray, accepted: np.ndarray) -> DetectionCounts:
        """Candidates (N,) bool: whether each is a person, and whether it was accepted."""
        return cls(
            tp=int((truth & accepted).sum()),
            fp=int((~truth & accepted).sum()),
            fn=int((truth & ~accepted).sum()),
            tn=int((~truth & ~accepted).sum()),
        )

    def __add__(self, other: DetectionCounts) -> DetectionCounts:
        return DetectionCounts(
            self.tp + other.tp, self.fp + other.fp, self.fn + other.fn, self.tn + other.tn
        )

    @property
    def precision(self) -> float:
        """TP / (TP + FP)."""
        return _ratio(self.tp, self.tp + self.fp)

    @property
    def recall(self) -> float:
        """TP / (TP + FN)."""
        return _ratio(self.tp, self.tp + self.fn)

    @property
    def accuracy(self) -> float:
        """(TP + TN) / all."""
        return _ratio(self.tp + self.tn, self.tp + self.fp + self.fn + self.tn)

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall, as 2 TP / (2 TP + FP + FN)."""
        return _ratio(2 * self.tp, 2 * self.tp + self.fp + self.fn)

    @property
    def fp_rate(self) -> float:
        """FP / (FP + TN)."""
        return _ratio(self.fp, self.fp + self.tn)

    @property
    def person_share(self) -> float:
        """Persons / all: precision, accuracy and F1 depend on it, recall and FP rate do not."""
        return _ratio(self.tp + self.fn, self.tp + self.fp + self.fn + self.tn)

    def f1_at(self, person_share: float) -> float:
        """F1 of the same recall and FP rate among candidates of which this share are persons."""
        found = person_share * self.recall
        return 2.0 * found / (found + person_share + (1.0 - person_share) * self.fp_rate)


def count_frame(
    candidates: Iterable[tuple[bool, int | None]],
    wanted: Collection[int],
    optional: Collection[int] = (),
) -> DetectionCounts:
    """Count one frame's candidates.

    Args:
        candidates: (accepted, the person that it is or None), the surest first.
        wanted: persons that must be found.
        optional: persons that may be found or missed: candidates that are theirs do not count.

    A second accepted candidate on the same person is a false one: the robot would see two.
    """
    found: set[int] = set()
    counts = DetectionCounts()
    for accepted, owner in candidates:
        if owner in optional:
            continue
        if accepted:
            new = owner is not None and owner not in found
            counts += DetectionCounts(tp=int(new), fp=int(not new))
            found |= {owner} if owner is not None else set()
        elif owner is None:
            counts += DetectionCounts(tn=1)
    return counts + DetectionCounts(fn=len(set(wanted) - found))


def _ratio(part: int, whole: int) -> float:
    return part / whole if whole else float("nan")
