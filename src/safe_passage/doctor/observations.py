"""What can be seen of a running graph in some seconds."""

from __future__ import annotations

import statistics
from dataclasses import dataclass, field
from typing import Any, Mapping

import numpy as np

from safe_passage.simulation.robots import Robot


@dataclass(frozen=True)
class Topic:
    """One topic that our nodes read or write, and what came on it while we listened."""

    name: str
    type: str  # as its publishers say; empty: nobody publishes it
    wanted: str = ""  # type that our nodes expect; empty: they only write it
    publishers: tuple[str, ...] = ()  # nodes
    readers: tuple[str, ...] = ()  # nodes of ours
    seconds: float = 0.0  # listened
    count: int = 0  # messages
    frames: tuple[str, ...] = ()  # different ones, of stamped messages
    ages: tuple[float, ...] = ()  # [s] of stamped messages when they came, by our clock
    empty_share: float = 0.0  # of scans in which no beam came back

    @property
    def rate(self) -> float:
        """[Hz]"""
        return self.count / self.seconds if self.seconds > 0.0 else 0.0

    @property
    def age(self) -> float:
        """[s] median, NaN without stamped messages."""
        return statistics.median(self.ages) if self.ages else float("nan")


@dataclass(frozen=True)
class Frame:
    """Where tf has a frame."""

    name: str
    T_base_frame: np.ndarray | None = None  # (4, 4), None: no way from base
    age: float = 0.0  # [s] of the newest transform from odom, 0: static
    error: str = ""  # why there is none, as tf says


@dataclass(frozen=True)
class Clock:
    """Which time the graph runs in."""

    simulated: bool = False  # use_sim_time
    publishers: tuple[str, ...] = ()  # of /clock
    advanced: float = 1.0  # [s] that it went on in a second of the wall's


@dataclass(frozen=True)
class Graph:
    """All of it."""

    nodes: tuple[str, ...] = ()  # ours that run and answer
    expected: tuple[str, ...] = ()  # ours that bringup was told to start
    dead: tuple[str, ...] = ()  # the master knows them, they do not answer
    topics: Mapping[str, Topic] = field(default_factory=dict)
    frames: Mapping[str, Frame] = field(default_factory=dict)
    odom_frame: str = "odom"
    base_frame: str = "base_footprint"
    clock: Clock = field(default_factory=Clock)
    diagnostics: Mapping[str, tuple[int, str]] = field(default_factory=dict)  # level, message
    parameters: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)  # of each node
    robot: Robot | None = None  # what its yaml says, if bringup was used
    namespace: str = "/"

    def resolved(self, topic: str) -> str:
        """The whole name of a topic in the robot's namespace."""
        return topic if topic.startswith("/") else self.namespace.rstrip("/") + "/" + topic
