"""Faults on demand: which messages are lost or late, when tf fails, how far odometry drifts.

Decisions only; who sends the messages asks for them. A decision depends on seed, target and time
alone, not on what was asked before.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Collection, Sequence

import numpy as np

from safe_passage.core.errors import ParameterError, shown
from safe_passage.core.parameters import check_choice, check_range
from safe_passage.core.reading import build_list

# What `value` means: least, most, unit; None: nothing, the kind takes no value.
VALUES = {
    "dropout": (0.0, 1.0, "share of messages"),
    "latency": (0.0, 60.0, "s"),
    "silence": None,
    "tf_gap": None,
    "odometry_drift": (-0.5, 0.5, "share of the way"),
}
OF_A_SENSOR = ("dropout", "latency", "silence")  # kinds that need a target


@dataclass(frozen=True)
class Fault:
    """One fault, from `start` until before `end`."""

    kind: str  # one of VALUES
    target: str = ""  # name of a sensor
    start: float = 0.0  # [s] of the simulation
    end: float = math.inf  # [s]
    value: float = 0.0  # see VALUES

    def __post_init__(self) -> None:
        check_choice("kind", self.kind, tuple(VALUES))
        check_range("start", self.start, 0.0, 1e9, "s")
        check_range("end", self.end, self.start, math.inf, "s")
        limits = VALUES[self.kind]
        if limits is not None:
            check_range("value", self.value, *limits)
        elif self.value != 0.0:
            raise ParameterError(f"value is {shown(self.value)}, but a {self.kind} takes none")
        if (self.kind in OF_A_SENSOR) != bool(self.target):
            need = "the name of a sensor" if self.kind in OF_A_SENSOR else "left out"
            raise ParameterError(
                f"target is {shown(self.target)}, must be {need} for a {self.kind}"
            )

    def at(self, time: float) -> bool:
        """Whether it acts at `time` [s]."""
        return self.start <= time < self.end


class FaultPlan:
    """Faults, and what they do at a given time.

    Args:
        faults: that happen; of one kind and target, several may act at once.
        seed: of the dropouts.
    """

    def __init__(self, faults: Sequence[Fault] = (), seed: int = 0) -> None:
        self.faults, self._seed = tuple(faults), seed

    def delivered(self, target: str, time: float) -> bool:
        """Whether the message that `target` measures at `time` [s] is sent at all."""
        if self._acting("silence", target, time):
            return False
        kept = math.prod(1.0 - fault.value for fault in self._acting("dropout", target, time))
        return kept >= 1.0 or self._draw(target, time) < kept

    def delay(self, target: str, time: float) -> float:
        """[s] by which that message comes late."""
        return sum(fault.value for fault in self._acting("latency", target, time))

    def tf_available(self, time: float) -> bool:
        """Whether transforms are sent at `time` [s]."""
        return not self._acting("tf_gap", "", time)

    def odometry_drift(self, time: float) -> float:
        """Share by which odometry overrates the way at `time` [s]."""
        return sum(fault.value for fault in self._acting("odometry_drift", "", time))

    def _acting(self, kind: str, target: str, time: float) -> list[Fault]:
        return [f for f in self.faults if (f.kind, f.target) == (kind, target) and f.at(time)]

    def _draw(self, target: str, time: float) -> float:
        """Even in [0, 1)."""
        label = int.from_bytes(target.encode(), "little")
        moment = round(time * 1e6)
        return float(np.random.default_rng((self._seed, label, moment)).random())


def make_fault_plan(
    entries: Any, targets: Collection[str], seed: int = 0, where: str = "faults"
) -> FaultPlan:
    """A plan of a yaml's list of mappings.

    Args:
        entries: the list; None is an empty one.
        targets: names of the sensors there are.
        seed: of the dropouts.
        where: to name in errors.

    Raises:
        ParameterError: names the entry and the key that is wrong.
    """
    faults = build_list(Fault, entries, where)
    for i, fault in enumerate(faults):
        if fault.target and fault.target not in targets:
            known = ", ".join(sorted(targets))
            raise ParameterError(
                f"parameter {where}[{i}]/target is {shown(fault.target)}, must be one of {known}"
            )
    return FaultPlan(faults, seed)
