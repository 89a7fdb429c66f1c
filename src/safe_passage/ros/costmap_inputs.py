"""What the costmap takes in: sensor topics as observations, and the pose of the robot."""

from __future__ import annotations

import rospy
import tf2_ros

from safe_passage.costmap import Observation, transform_points
from safe_passage.costmap.parameters import CostmapParameters, SourceParameters
from safe_passage.ros.conversions import planar_pose
from safe_passage.ros.costmap_conversions import MESSAGE_TYPES, sensor_points
from safe_passage.ros.diagnostics import NodeDiagnostics, Outcome
from safe_passage.ros.sensor_input import InputLimits, Received, SensorInput


class CostmapSource:
    """One topic: gives observations out when asked."""

    def __init__(
        self,
        source: SourceParameters,
        costmap: CostmapParameters,
        tf_buffer: tf2_ros.Buffer,
        diagnostics: NodeDiagnostics,
    ) -> None:
        self._source, self._costmap, self._tf = source, costmap, tf_buffer
        tolerance = costmap.transform_tolerance
        self._input = SensorInput(
            source.topic,
            MESSAGE_TYPES[source.data_type],
            InputLimits(costmap.max_observation_age, tolerance, tolerance),
            diagnostics,
            lambda message: sensor_points(message, source),
            self._observe,
        )

    def take(self, now: rospy.Time) -> list[tuple[Observation, float]]:
        """Observations whose transform is known by now, oldest first, and when they arrived."""
        return self._input.take(now)

    def restart(self) -> None:
        """Forget what waits and what came last."""
        self._input.restart()

    def _observe(self, entry: Received) -> Observation:
        moved = self._lookup(entry.frame, entry.stamp)
        origin = self._lookup(self._source.sensor_frame or entry.frame, entry.stamp)
        shift, turn = moved.translation, moved.rotation
        points = transform_points(
            entry.content, (shift.x, shift.y, shift.z), (turn.x, turn.y, turn.z, turn.w)
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
        """Newest pose (x m, y m, yaw rad), or None when older or ahead by transform_tolerance.

        What is ahead tf keeps as the newest, whatever comes after it. A missing pose is not counted
        but logged, so that diagnostics report it as awaited.
        """
        frames = self._costmap.global_frame, self._costmap.robot_base_frame
        try:
            found = self._tf.lookup_transform(*frames, rospy.Time())
        except tf2_ros.TransformException as error:
            rospy.logwarn_throttle(5.0, f"no update, {self.NAME} unknown: {error}")
            return None
        age = (now - found.header.stamp).to_sec()
        static = found.header.stamp.is_zero()
        if abs(age) > self._costmap.transform_tolerance and not static:
            rospy.logwarn_throttle(5.0, f"no update, {self.NAME} {age:.3f} s old")
            return None
        self._diagnostics.count(self.NAME, Outcome.OK)
        return planar_pose(found.transform.translation, found.transform.rotation)
