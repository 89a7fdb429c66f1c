"""What the campaign knows of a node: its inputs, and what `docs/safety.md` says of each."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Callable, ClassVar, List

import rospy

from bench.fault_graph import Output
from bench.fault_transforms import Transform

SLACK = 0.2  # [s] simulated, from a time-out until the answer to it is out

Seen = List[Output]  # a window of the outputs
Check = Callable[[Seen], str]  # what is wrong with them; empty: nothing


@dataclass(frozen=True)
class Stated:
    """What must be seen while a fault lasts."""

    check: Check
    told: bool  # in /diagnostics or the log
    late: float = 0.0  # [s] simulated, by which it may be well later than after other faults


@dataclass(frozen=True)
class Sent:
    """A message that the node was given."""

    name: str  # of the input
    at: float  # [s] simulated
    message: Any


@dataclass(frozen=True)
class Input:
    """A topic that the node reads."""

    name: str
    topic: str
    kind: type
    make: Callable[[rospy.Time], Any]  # a healthy message of that time
    timeout: float  # [s] after which the loss of it must show
    lost: Check  # what then must be seen
    told: bool = True  # whether the loss is told in /diagnostics or the log
    stated: dict[str, Stated] = field(default_factory=dict)  # by fault, where that is another
    every: int = 1  # steps between two messages
    special: dict[str, Transform] = field(
        default_factory=dict
    )  # faults made otherwise than others'
    # faults that its messages could have but that mean nothing, and why
    without: dict[str, str] = field(default_factory=dict)


class Subject:
    """A node under test; the world around it stands still."""

    name: str
    node: str = ""  # its name in the launch file, where that is another
    launch: str
    arguments: tuple[str, ...] = ()
    parameters: ClassVar[dict[str, Any]] = {}  # of the node, other than the launch file's
    outputs: dict[str, type]  # by topic
    inputs: tuple[Input, ...]
    tick = 0.05  # [s] a step of simulated time
    pause = 0.025  # [s] of wall time that a step takes at least
    recovery = 3.0  # [s] simulated, until it is well again
    work = 0.3  # [s] of its own work in which it has answered a step, or is late
    judged = 0.6  # [s] simulated, for which the stated behaviour is watched
    without_number: frozenset[str] = frozenset()  # fields of outputs that may be NaN or infinite
    frames: frozenset[str]  # that outputs may have

    def prepare(self) -> None:
        """Before the node starts: static transforms, parameters."""

    def begin(self, now: rospy.Time) -> None:
        """The clock has jumped, or the node was killed."""

    def healthy(self, seen: Seen) -> str:
        """What is missing or wrong when all inputs are well."""
        raise NotImplementedError

    def wrong(self, seen: Seen, sent: list[Sent]) -> str:
        """What no fault excuses; `sent`: what the node was given since."""
        del seen, sent
        return ""


def of(topic: str, seen: Seen) -> list[Any]:
    """The messages of a topic."""
    return [output.message for output in seen if output.topic == topic]


def silence(*topics: str) -> Check:
    """Nothing may come out of these."""

    def check(seen: Seen) -> str:
        spoke = [output for output in seen if output.topic in topics]
        return f"{len(spoke)} messages of {spoke[0].topic}" if spoke else ""

    return check
