"""What the obstacle tracker takes in: sensors' messages as measurements, where tf knows all."""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np
import rospy
import tf2_ros
from sensor_msgs.msg import LaserScan, PointCloud2
from tf2_msgs.msg import TFMessage

from safe_passage.monitoring.aggregation import Measurement
from safe_passage.monitoring.parameters import LASER, SourceParameters
from safe_passage.monitoring.preprocessing import cloud_points, scan_points
from safe_passage.monitoring.views import CloudView, ScanView, View
from safe_passage.ros.conversions import from_transform, planar_pose
from safe_passage.ros.diagnostics import NodeDiagnostics
from safe_passage.ros.fields_of_view import FieldOfView, of_cloud, of_scan
from safe_passage.ros.sensor_conversions import sampled_xyz, scan_beams
from safe_passage.ros.sensor_input import NEWEST, InputLimits, Received, SensorInput
from safe_passage.ros.tracker_parameters import TrackerNodeParameters


@dataclass(frozen=True)
class Taken:
    """A measurement that the tracker can use."""

    stamp: rospy.Time  # exactly the message's
    measurement: Measurement
    arrived: float  # [s] monotonic


class TrackerInputs:
    """All sources and tf. `tf` is theirs to read."""

    def __init__(self, parameters: TrackerNodeParameters, diagnostics: NodeDiagnostics) -> None:
        self._news, self._is_news = threading.Condition(), False
        self.tf = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self.tf)
        self._sources = [
            _Source(source, parameters, self.tf, diagnostics, self._notify)
            for source in parameters.sources
        ]
        # After the listener's own subscription: when this is called, the buffer has the news.
        self._tf_subscriber = rospy.Subscriber("/tf", TFMessage, self._on_tf)
        rospy.on_shutdown(self._notify)

    @property
    def topics(self) -> list[str]:
        """Resolved names."""
        return [source.input.topic for source in self._sources]

    def wait(self, timeout: float) -> None:
        """Until something has come since the last call, or `timeout` [s of wall time] is over."""
        with self._news:
            self._news.wait_for(lambda: self._is_news, timeout)
            self._is_news = False

    def take(self, now: rospy.Time) -> list[Taken]:
        """Everything new that tf can place by now."""
        return [
            Taken(stamp, measurement, arrived)
            for source in self._sources
            for (stamp, measurement), arrived in source.input.take(now)
        ]

    def fields_of_view(self) -> list[FieldOfView]:
        """Of the sources that have spoken, as their last messages show."""
        return [view for view in (source.field_of_view() for source in self._sources) if view]

    def restart(self) -> None:
        """Forget everything."""
        self.tf.clear()
        for source in self._sources:
            source.restart()

    def _on_tf(self, _: TFMessage) -> None:
        if any(source.input.waits for source in self._sources):
            self._notify()

    def _notify(self) -> None:
        with self._news:
            self._is_news = True
            self._news.notify_all()


class _Source:
    """One sensor."""

    def __init__(
        self,
        source: SourceParameters,
        parameters: TrackerNodeParameters,
        tf_buffer: tf2_ros.Buffer,
        diagnostics: NodeDiagnostics,
        on_news,
    ) -> None:
        self._source, self._p, self._tf = source, parameters, tf_buffer
        self._last: tuple[Received, np.ndarray] | None = None
        self._is_scan = source.type == LASER
        self.input = SensorInput(
            source.topic,
            LaserScan if self._is_scan else PointCloud2,
            InputLimits(parameters.max_age, parameters.max_future, parameters.transform_tolerance),
            diagnostics,
            scan_beams if self._is_scan else self._read_cloud,
            self._measure,
            on_news,
            most=max(source.aggregate, NEWEST),  # older ones are put together with nothing
        )

    def field_of_view(self) -> FieldOfView | None:
        """None before the first message."""
        if self._last is None:
            return None
        received, T_base_sensor = self._last
        find = of_scan if self._is_scan else of_cloud
        return find(received.content, T_base_sensor, self._source)

    def restart(self) -> None:
        """Forget what waits and what came last."""
        self.input.restart()
        self._last = None

    def _read_cloud(self, cloud: PointCloud2) -> np.ndarray:
        """As many points as no cell within range lacks one for."""
        return sampled_xyz(cloud, self._source.range_max, 0.5 * self._p.resolution)

    def _measure(self, received: Received) -> tuple[rospy.Time, Measurement]:
        base, stamp = self._p.base_frame, received.stamp
        T_base_sensor = from_transform(self._tf.lookup_transform(base, received.frame, stamp))
        in_odom = self._tf.lookup_transform(self._p.odom_frame, base, stamp).transform
        pose = planar_pose(in_odom.translation, in_odom.rotation)
        content, source = received.content, self._source
        if self._is_scan:
            beams = (content.ranges, content.angle_min, content.angle_increment)
            points = scan_points(*beams, T_base_sensor, source)
            origin = float(T_base_sensor[0, 3]), float(T_base_sensor[1, 3])
            view: View | None = ScanView.of(points, origin)
        else:
            points = cloud_points(content, T_base_sensor, source)
            view = CloudView.of(content, T_base_sensor)
        if self._last is None or self._last[0].stamp < stamp:  # the newest may come first
            self._last = received, T_base_sensor
        return stamp, Measurement(source.name, stamp.to_sec(), pose, points, view)
