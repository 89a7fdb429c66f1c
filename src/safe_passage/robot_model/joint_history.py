"""Joint positions over the last moments, read at an image's stamp."""

from __future__ import annotations

import threading
from bisect import insort
from collections import deque
from typing import Iterable, Mapping, Sequence

import numpy as np

from safe_passage.core.errors import InputError


class JointHistory:
    """Joint states, each of any subset of the joints, in any order of arrival, from any thread.

    Args:
        length: [s] that is kept of each joint.
        tolerance: [s] that a stamp may lie outside of what is known of a joint.
        max_gap: [s] between two states over which is interpolated.
    """

    def __init__(self, length: float = 2.0, tolerance: float = 0.02, max_gap: float = 0.2) -> None:
        self._length, self._tolerance, self._max_gap = length, tolerance, max_gap
        self._lock = threading.Lock()
        self._joints: dict[str, deque[tuple[float, float]]] = {}

    def tune(self, tolerance: float, max_gap: float) -> None:
        """Other limits from now on; what is known stays."""
        with self._lock:
            self._tolerance, self._max_gap = tolerance, max_gap

    def add(self, stamp: float, names: Sequence[str], positions: Sequence[float]) -> None:
        """One joint state. `stamp` [s]; `positions` [rad] or [m].

        Raises:
            InputError: there are not as many names as positions, or one is not finite.
        """
        if len(names) != len(positions):
            raise InputError(f"joint state: {len(names)} names for {len(positions)} positions")
        for name, position in zip(names, positions):
            if not np.isfinite(position):
                raise InputError(f"joint {name}: its position is {position}")
        with self._lock:
            self._add(stamp, names, positions)

    def _add(self, stamp: float, names: Sequence[str], positions: Sequence[float]) -> None:
        for name, position in zip(names, positions):
            known = self._joints.setdefault(name, deque())
            entry = (stamp, float(position))
            if known and known[-1][0] > stamp:
                if all(at != stamp for at, _ in known):
                    insort(known, entry)
            elif not known or known[-1][0] < stamp:
                known.append(entry)
            while known[-1][0] - known[0][0] > self._length:
                known.popleft()

    def clear(self) -> None:
        """Forget everything: the clock has jumped."""
        with self._lock:
            self._joints.clear()

    def at(self, stamp: float, names: Iterable[str]) -> dict[str, float]:
        """Positions at `stamp` [s], between states linearly, beyond the last as it is.

        Raises:
            InputError: names a joint of which nothing, or nothing near enough, is known.
        """
        with self._lock:
            return {name: self._position(name, stamp) for name in names}

    def latest(self, names: Iterable[str]) -> float:
        """[s] until which all of `names` are known; -inf: one never was."""
        with self._lock:
            return min(self._joints[n][-1][0] if n in self._joints else -np.inf for n in names)

    def _position(self, name: str, stamp: float) -> float:
        known = self._joints.get(name)
        if not known:
            raise InputError(f"joint {name}: no state has come")
        stamps = np.array([at for at, _ in known])
        early, late = stamps[0] - stamp, stamp - stamps[-1]
        if max(early, late) > self._tolerance:
            raise InputError(
                f"joint {name}: its {'first' if early > late else 'last'} state is "
                f"{max(early, late):.3f} s {'after' if early > late else 'before'} the stamp, "
                f"more than {self._tolerance} s"
            )
        after = int(np.searchsorted(stamps, stamp))
        if 0 < after < len(stamps) and stamps[after] - stamps[after - 1] > self._max_gap:
            gap = stamps[after] - stamps[after - 1]
            raise InputError(f"joint {name}: a gap of {gap:.3f} s in its states at the stamp")
        return float(np.interp(stamp, stamps, [position for _, position in known]))


def moved(a: Mapping[str, float], b: Mapping[str, float]) -> float:
    """The largest difference [rad or m] of a joint."""
    return max((abs(a[name] - b[name]) for name in a), default=0.0)
