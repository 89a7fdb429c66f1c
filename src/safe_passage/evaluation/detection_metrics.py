"""Detection metrics of paper 002, section 3.1."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DetectionCounts:
    """Candidates by truth and verdict; a metric without any case to judge is NaN."""

    tp: int = 0  # persons accepted
    fp: int = 0  # others accepted
    fn: int = 0  # persons missed, whether rejected or never proposed
    tn: int = 0  # others rejected

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


def _ratio(part: int, whole: int) -> float:
    return part / whole if whole else float("nan")
