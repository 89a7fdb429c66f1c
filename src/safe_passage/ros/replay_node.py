"""Node replay_camera: plays a recording or the analytic scene as a live camera, lidar and tf."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

import numpy as np
import rospy
import tf2_ros
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud2

from safe_passage.core.errors import InputError
from safe_passage.core.parameters import check_range
from safe_passage.replay.sources import FileSource, FrameSource, Lidar, SceneSource
from safe_passage.ros import conversions
from safe_passage.ros.parameters import read_parameters


@dataclass(frozen=True)
class ReplayParameters:
    """Private parameters of the node."""

    cloud: str = ""  # PCD file or folder of *_rgb.png + *_depth.png; empty: the analytic scene
    rate: float = 10.0  # [Hz] of the camera
    scan_rate: float = 20.0  # [Hz] of the lidar
    seconds_per_frame: float = 2.0  # [s] how long each frame of a folder is shown
    lidar_x: float = 0.2  # [m] before the base
    lidar_z: float = 0.12  # [m] over the ground
    scan_beams: int = 1081
    scan_field_of_view: float = 1.5 * math.pi  # [rad]
    range_min: float = 0.06  # [m]
    range_max: float = 20.0  # [m]
    odom_frame: str = "odom"
    base_frame: str = "base_footprint"
    robot_frame: str = "base_link"  # the same place: the robot is flat
    camera_frame: str = "camera_rgb_optical_frame"
    laser_frame: str = "laser"

    def __post_init__(self) -> None:
        check_range("rate", self.rate, 0.1, 60.0, "Hz")
        check_range("scan_rate", self.scan_rate, 0.1, 200.0, "Hz")
        check_range("seconds_per_frame", self.seconds_per_frame, 0.1, 3600.0, "s")
        check_range("lidar_z", self.lidar_z, 0.0, 5.0, "m")
        check_range("scan_beams", self.scan_beams, 2, 100000, "beams")
        check_range("scan_field_of_view", self.scan_field_of_view, 0.1, 2.0 * math.pi, "rad")


class ReplayNode:
    """Publishes camera, lidar and tf of a robot that stands still."""

    def __init__(self) -> None:
        self._p = read_parameters(ReplayParameters)
        self._source: FrameSource = SceneSource()
        if self._p.cloud:
            path = Path(self._p.cloud).expanduser()
            self._source = FileSource(path, self._p.seconds_per_frame)
        self._frame = self._source.frame(0.0)
        half = 0.5 * self._p.scan_field_of_view
        step = 2.0 * half / (self._p.scan_beams - 1)
        if self._p.cloud:  # where the camera does not look, nothing is known and nothing clears
            half = min(half, self._frame.half_view())
        angles = np.arange(-half, half + 0.5 * step, step)
        self._lidar = Lidar(angles, self._p.lidar_x, self._p.lidar_z, self._p.range_max)
        self._cloud_pub = rospy.Publisher("depth_registered/points", PointCloud2, queue_size=1)
        self._depth_pub = rospy.Publisher("depth_registered/image_rect", Image, queue_size=1)
        self._image_pub = rospy.Publisher("rgb/image_rect_color", Image, queue_size=1)
        self._info_pub = rospy.Publisher("rgb/camera_info", CameraInfo, queue_size=1)
        self._scan_pub = rospy.Publisher("scan", LaserScan, queue_size=1)
        self._tf = tf2_ros.TransformBroadcaster()
        self._start = rospy.Time.now()
        self._broadcast(self._start)
        self._every(1.0 / self._p.scan_rate, self._publish_scan)
        self._every(1.0 / self._p.rate, self._publish_frame)

    @staticmethod
    def _every(period: float, publish: Callable[[], None]) -> None:
        """Call `publish` every `period` [s], also after the clock went back."""
        rospy.Timer(rospy.Duration.from_sec(period), lambda event: publish(), reset=True)

    def _time(self, stamp: rospy.Time) -> float:
        return max(0.0, (stamp - self._start).to_sec())

    def _broadcast(self, stamp: rospy.Time) -> None:
        p, frame = self._p, self._frame
        base = conversions.to_header(stamp, p.base_frame)
        self._tf.sendTransform(
            [
                conversions.to_transform(
                    conversions.to_header(stamp, p.odom_frame), p.base_frame, np.zeros(3)
                ),
                conversions.to_transform(base, p.robot_frame, np.zeros(3)),
                conversions.to_transform(
                    base, p.laser_frame, np.array([p.lidar_x, 0.0, p.lidar_z])
                ),
                conversions.to_transform(
                    base, p.camera_frame, frame.p_base_camera, frame.R_base_camera
                ),
            ]
        )

    def _publish_scan(self) -> None:
        p, stamp = self._p, rospy.Time.now()
        ranges = self._source.scan(self._lidar, self._frame, self._time(stamp))
        self._broadcast(stamp)
        header = conversions.to_header(stamp, p.laser_frame)
        limits = (p.range_min, p.range_max)
        self._scan_pub.publish(conversions.to_scan(header, self._lidar.angles, ranges, limits))

    def _publish_frame(self) -> None:
        stamp = rospy.Time.now()
        try:
            frame = self._frame = self._source.frame(self._time(stamp))
        except InputError as error:  # one file of a folder: the next may be good
            rospy.logwarn_throttle(5.0, f"no frame: {error}")
            return
        self._broadcast(stamp)
        header = conversions.to_header(stamp, self._p.camera_frame)
        size = frame.bgr.shape[:2]
        self._info_pub.publish(conversions.to_camera_info(header, size, frame.intrinsics))
        self._image_pub.publish(conversions.to_image(header, frame.bgr))
        if self._depth_pub.get_num_connections():
            self._depth_pub.publish(conversions.to_depth_image(header, frame.xyz[..., 2]))
        if self._cloud_pub.get_num_connections():
            self._cloud_pub.publish(conversions.to_cloud(header, frame.xyz, frame.bgr))


def main() -> None:
    """Run the node."""
    rospy.init_node("replay_camera")
    ReplayNode()
    rospy.spin()
