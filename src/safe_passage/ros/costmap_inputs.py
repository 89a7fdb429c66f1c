"""What the costmap takes in: sensor topics as observations, and the pose of the robot."""

from __future__ import annotations

import threading
import time
from collections import deque
from dataclasses import dataclass

import numpy as np
import rospy
import tf2_ros

from safe_passage.costmap import Observation, quaternion_yaw, transform_points
from safe_passage.costmap.parameters import CostmapParameters, SourceParameters
from safe_passage.ros.costmap_conversions import (
    MESSAGE_TYPES,
    SensorMessage,
    UnusableMessageError,
    sensor_points,
)
from safe_passage.ros.diagnostics import NodeDiagnostics, Outcome

QUEUE = 50  # messages that may wait for their transform, as in costmap_2d


@dataclass(frozen=True)
class Waiting:
    """Points that wait for the transform at their stamp."""

    stamp: rospy.Time
    frame: str
    points: np.ndarray  # (N, 3) m in `frame`
    arrived: float  # s, monotonic


class CostmapSource:
    """One topic: takes messages in as they come and gives observations out when asked.

    A message is transformed at its own stamp or dropped, never with the latest transform: a wrong
    place would mark free space and clear obstacles.
    """

    def __init__(
        self,
        source: SourceParameters,
        costmap: CostmapParameters,
        tf_buffer: tf2_ros.Buffer,
        diagnostics: NodeDiagnostics,
    ) -> None:
        self._source, self._costmap = source, costmap
        self._tf, self._diagnostics = tf_buffer, diagnostics
        self._lock = threading.Lock()
        self._waiting: deque[Waiting] = deque()
        self._newest = rospy.Time()
        self._topic = rospy.resolve_name(source.topic)
        diagnostics.expect(self._topic)
        kind = MESSAGE_TYPES[source.data_type]
        self._subscriber = rospy.Subscriber(source.topic, kind, self._receive, queue_size=QUEUE)

    def take(self, now: rospy.Time) -> list[tuple[Observation, float]]:
        """Observations whose transform is known by now, oldest first, with their time of arrival.

        The others wait for up to transform_tolerance.
        """
        with self._lock:
            waiting, self._waiting = self._waiting, deque()
        taken = []
        for entry in waiting:
            observation = self._observe(entry, now)
            if observation is not None:
                taken.append((observation, entry.arrived))
        return taken

    def restart(self) -> None:
        """Forget what waits and what came last."""
        with self._lock:
            self._waiting.clear()
            self._newest = rospy.Time()

    def _receive(self, message: SensorMessage) -> None:
        outcome, detail = self._judge_stamp(message.header.stamp, rospy.Time.now())
        points = None
        if outcome is Outcome.OK:
            try:
                points = sensor_points(message, self._source)
            except UnusableMessageError as error:
                outcome, detail = error.outcome, str(error)
        if points is None:
            self._diagnostics.count(self._topic, outcome, detail)
            return
        header = message.header
        entry = Waiting(header.stamp, header.frame_id, points, time.monotonic())
        with self._lock:
            self._newest = header.stamp
            self._waiting.append(entry)
            crowded_out = self._waiting.popleft() if len(self._waiting) > QUEUE else None
        if crowded_out:
            self._diagnostics.count(self._topic, Outcome.NO_TF, "too many messages wait")

    def _judge_stamp(self, stamp: rospy.Time, now: rospy.Time) -> tuple[Outcome, str]:
        age = (now - stamp).to_sec()
        if age > self._costmap.max_observation_age:
            return Outcome.STALE, f"{age:.3f} s old"
        if age < -self._costmap.transform_tolerance:
            return Outcome.FUTURE, f"{-age:.3f} s ahead"
        if stamp < self._newest:
            return Outcome.OUT_OF_ORDER, f"{(self._newest - stamp).to_sec():.3f} s behind the last"
        return Outcome.OK, ""

    def _observe(self, entry: Waiting, now: rospy.Time) -> Observation | None:
        """The observation, or None: dropped and counted, or put back to wait."""
        try:
            moved = self._lookup(entry.frame, entry.stamp)
            origin = self._lookup(self._source.sensor_frame or entry.frame, entry.stamp)
        except tf2_ros.TransformException as error:
            if (now - entry.stamp).to_sec() > self._costmap.transform_tolerance:
                self._diagnostics.count(self._topic, Outcome.NO_TF, str(error))
            else:
                with self._lock:
                    self._waiting.append(entry)
            return None
        self._diagnostics.count(self._topic, Outcome.OK)
        shift, turn = moved.translation, moved.rotation
        points = transform_points(
            entry.points, (shift.x, shift.y, shift.z), (turn.x, turn.y, turn.z, turn.w)
        )
        at = origin.translation
        return Observation(entry.stamp.to_sec(), (at.x, at.y, at.z), points)

    def _lookup(self, frame: str, stamp: rospy.Time):
        return self._tf.lookup_transform(self._costmap.global_frame, frame, stamp).transform


class RobotPose:
    """The robot in the global frame, where tf knows it."""

    NAME = "robot pose"

    def __init__(
        self, costmap: CostmapParameters, tf_buffer: tf2_ros.Buffer, diagnostics: NodeDiagnostics
    ) -> None:
        self._costmap, self._tf, self._diagnostics = costmap, tf_buffer, diagnostics
        diagnostics.expect(self.NAME)

    def at(self, now: rospy.Time) -> tuple[float, float, float] | None:
        """Newest pose (x m, y m, yaw rad), or None when older than transform_tolerance.

        A missing pose is not counted but logged, so that diagnostics report it as awaited.
        """
        frames = self._costmap.global_frame, self._costmap.robot_base_frame
        try:
            found = self._tf.lookup_transform(*frames, rospy.Time())
        except tf2_ros.TransformException as error:
            rospy.logwarn_throttle(5.0, f"no update, {self.NAME} unknown: {error}")
            return None
        age = (now - found.header.stamp).to_sec()
        static = found.header.stamp.is_zero()
        if age > self._costmap.transform_tolerance and not static:
            rospy.logwarn_throttle(5.0, f"no update, {self.NAME} {age:.3f} s old")
            return None
        self._diagnostics.count(self.NAME, Outcome.OK)
        at, turn = found.transform.translation, found.transform.rotation
        return at.x, at.y, quaternion_yaw((turn.x, turn.y, turn.z, turn.w))
