"""A sensor's topic: its messages wait for the transforms at their own stamp, or are dropped."""

from __future__ import annotations

import threading
import time
from collections import deque
from dataclasses import dataclass
from typing import Any, Callable

import rospy
import tf2_ros

from safe_passage.ros.diagnostics import NodeDiagnostics, Outcome
from safe_passage.ros.sensor_conversions import UnusableMessageError

QUEUE = 50  # messages that may wait, as in costmap_2d
NEWEST = 2  # images or clouds at once: tf and joint states may come less often than they
BUFFER = 2**24  # bytes; with rospy's own 2**16 a cloud of some MB arrives late


@dataclass(frozen=True)
class InputLimits:
    """Which messages are taken."""

    max_age: float  # [s] older ones are dropped
    max_future: float  # [s] those stamped farther ahead are dropped
    transform_tolerance: float  # [s] a message waits so long for its transforms


@dataclass(frozen=True)
class Received:
    """A message's content, which waits for the transforms at its stamp."""

    stamp: rospy.Time
    frame: str
    content: Any
    arrived: float  # [s] monotonic


class NotYetError(tf2_ros.TransformException):
    """What else a message waits for, and as what it is counted when it has waited too long."""

    def __init__(self, outcome: Outcome, detail: str) -> None:
        super().__init__(detail)
        self.outcome = outcome


class SensorInput:
    """Takes messages in as they come and gives out what is made of them when asked.

    A message is placed by the transforms at its own stamp or dropped, never by the latest ones: a
    wrong place would mark free space and clear obstacles.

    Args:
        topic, kind: of the messages, which have a header.
        read: a message's content; raises UnusableMessageError.
        place: what is given out; raises tf2_ros.TransformException while tf does not know it,
            NotYetError while something else is missing.
        on_news: called after each message.
        expected: whether its silence is a fault.
        most: is given out at once, the newest; with more the node is behind, and what it did with
            the oldest would be old: they are dropped.
    """

    def __init__(
        self,
        topic: str,
        kind: type,
        limits: InputLimits,
        diagnostics: NodeDiagnostics,
        read: Callable[[Any], Any],
        place: Callable[[Received], Any],
        on_news: Callable[[], None] = lambda: None,
        expected: bool = True,
        most: int = QUEUE,
    ) -> None:
        self._limits, self._diagnostics, self._most = limits, diagnostics, most
        self._read, self._place, self._on_news = read, place, on_news
        self._lock = threading.Lock()
        self._waiting: deque[Received] = deque()
        self._newest = rospy.Time()
        self.topic = rospy.resolve_name(topic)
        if expected:
            diagnostics.expect(self.topic)
        self._subscriber = rospy.Subscriber(
            topic, kind, self._receive, queue_size=QUEUE, buff_size=BUFFER
        )

    @property
    def waits(self) -> bool:
        """Whether a message is here that was not given out."""
        return bool(self._waiting)

    def take(self, now: rospy.Time) -> list[tuple[Any, float]]:
        """What can be placed by now, oldest first, with its time of arrival [s, monotonic].

        The others wait for up to transform_tolerance, unless newer ones are given out.
        """
        with self._lock:
            waiting, self._waiting = self._waiting, deque()
        taken: deque[tuple[Any, float]] = deque()
        later: deque[Received] = deque()
        for entry in reversed(waiting):
            if len(taken) == self._most:
                self._crowd_out(f"{(now - entry.stamp).to_sec():.3f} s old")
                continue
            placed = self._placed(entry, now, later)
            if placed is not None:
                taken.appendleft((placed, entry.arrived))
        with self._lock:
            self._waiting.extendleft(reversed(later))
        return list(taken)

    def restart(self) -> None:
        """Forget what waits and what came last."""
        with self._lock:
            self._waiting.clear()
            self._newest = rospy.Time()

    def _receive(self, message: Any) -> None:
        self._queue(message)
        self._on_news()

    def _queue(self, message: Any) -> None:
        header, arrived = message.header, time.monotonic()
        outcome, detail = self._judge(header.frame_id, header.stamp, rospy.Time.now())
        content = None
        if outcome is Outcome.OK:
            try:
                content = self._read(message)
            except UnusableMessageError as error:
                outcome, detail = error.outcome, str(error)
        if outcome is not Outcome.OK:
            self._diagnostics.count(self.topic, outcome, detail)
            return
        entry = Received(header.stamp, header.frame_id, content, arrived)
        with self._lock:
            self._newest = header.stamp
            self._waiting.append(entry)
            crowded_out = self._waiting.popleft() if len(self._waiting) > QUEUE else None
        if crowded_out:
            self._crowd_out("too many messages wait")

    def _crowd_out(self, detail: str) -> None:
        self._diagnostics.count(self.topic, Outcome.CROWDED_OUT, detail)

    def _judge(self, frame: str, stamp: rospy.Time, now: rospy.Time) -> tuple[Outcome, str]:
        age = (now - stamp).to_sec()
        if not frame:
            return Outcome.BAD_FIELDS, "no frame_id"
        if age > self._limits.max_age:
            return Outcome.STALE, f"{age:.3f} s old"
        if age < -self._limits.max_future:
            return Outcome.FUTURE, f"{-age:.3f} s ahead"
        if stamp < self._newest:
            return Outcome.OUT_OF_ORDER, f"{(self._newest - stamp).to_sec():.3f} s behind the last"
        return Outcome.OK, ""

    def _placed(self, entry: Received, now: rospy.Time, later: deque[Received]) -> Any:
        """What is made of the entry, or None: dropped and counted, or put before `later`."""
        try:
            placed = self._place(entry)
        except tf2_ros.TransformException as error:
            if (now - entry.stamp).to_sec() > self._limits.transform_tolerance:
                outcome = error.outcome if isinstance(error, NotYetError) else Outcome.NO_TF
                self._diagnostics.count(self.topic, outcome, str(error))
            else:
                later.appendleft(entry)
            return None
        self._diagnostics.count(self.topic, Outcome.OK)
        return placed
