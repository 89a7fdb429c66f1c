"""Lists of different lengths as one array."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Sequence

import numpy as np


@dataclass(frozen=True)
class Ragged:
    """N lists, one behind the other."""

    values: np.ndarray  # (T, ...)
    start: np.ndarray  # (N + 1,) where each begins; the last is T

    @staticmethod
    def of(lists: Sequence[np.ndarray], like: np.ndarray) -> Ragged:
        """Join `lists`; `like` gives type and shape where there are none."""
        lengths = np.fromiter(map(len, lists), np.int64, len(lists))
        return Ragged.of_lengths(np.concatenate(lists) if len(lists) else like[:0], lengths)

    @staticmethod
    def of_lengths(values: np.ndarray, lengths: np.ndarray) -> Ragged:
        """Cut `values` into lists of these `lengths`."""
        return Ragged(values, np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64))

    def __len__(self) -> int:
        return len(self.start) - 1

    def __getitem__(self, index: int) -> np.ndarray:
        return self.values[self.start[index] : self.start[index + 1]]

    @cached_property
    def lengths(self) -> np.ndarray:
        """(N,)"""
        return np.diff(self.start)

    @cached_property
    def owner(self) -> np.ndarray:
        """(T,) the list that each value is in."""
        return np.repeat(np.arange(len(self)), self.lengths)

    def of_lists(self, which: np.ndarray) -> Ragged:
        """The lists `which` (M,)."""
        return Ragged.of_lengths(*gather(self, which))

    def unions(self, sets: list[tuple[int, ...]]) -> Ragged:
        """For each of `sets` the lists that it names, joined."""
        flat = np.fromiter((i for s in sets for i in s), np.int64)
        sizes = np.fromiter(map(len, sets), np.int64, len(sets))
        values, lengths = gather(self, flat)
        ends = np.concatenate([[0], np.cumsum(lengths)])
        at = np.concatenate([[0], np.cumsum(sizes)])
        return Ragged(values, ends[at].astype(np.int64))


def gather(lists: Ragged, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The values of the lists `which` (M,), one list behind the other, and their lengths (M,)."""
    lengths = lists.lengths[which]
    shift = lists.start[which] - (np.cumsum(lengths) - lengths)
    return lists.values[np.arange(lengths.sum()) + np.repeat(shift, lengths)], lengths


def moments(points: Ragged) -> tuple[np.ndarray, np.ndarray]:
    """Mean (N, 2) and second moment about it (N, 2, 2) of each list of points (M, 2); M > 0."""
    count = len(points)

    def mean(values: np.ndarray) -> np.ndarray:
        return np.bincount(points.owner, values, minlength=count) / np.maximum(points.lengths, 1)

    centre = np.stack([mean(points.values[:, 0]), mean(points.values[:, 1])], axis=1)
    dx, dy = (points.values - centre[points.owner]).T
    xx, xy, yy = mean(dx * dx), mean(dx * dy), mean(dy * dy)
    return centre, np.stack([xx, xy, xy, yy], axis=1).reshape(count, 2, 2)
