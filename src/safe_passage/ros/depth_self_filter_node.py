"""Node `depth_self_filter`: a depth camera's images without the robot itself."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass

import numpy as np
import rospy
import tf2_ros
from sensor_msgs.msg import CameraInfo, Image, JointState, PointCloud2

from safe_passage.core.errors import InputError
from safe_passage.core.parameters import check_range, check_text
from safe_passage.core.reading import build
from safe_passage.robot_model import JointHistory, PinholeCamera, RobotModel, load_robot_model
from safe_passage.ros.clock import JumpDetector
from safe_passage.ros.conversions import from_transform
from safe_passage.ros.depth_conversions import (
    from_camera_info,
    from_depth_image,
    to_points,
    to_same_image,
)
from safe_passage.ros.diagnostics import NodeDiagnostics, Outcome
from safe_passage.ros.packages import package_folder
from safe_passage.ros.parameters import private_values
from safe_passage.ros.sensor_conversions import UnusableMessageError
from safe_passage.ros.sensor_input import InputLimits, NotYetError, Received, SensorInput
from safe_passage.self_filter import SelfFilter, SelfFilterParameters

LOOK_ROUND = 0.2  # [s] of wall time without news, after which the clock is looked at
WAITING = 0.005  # [s] the same while an image waits for tf or joint states
NEXT_LOOK = 1.0  # [s] between two looks for the robot's description


@dataclass(frozen=True)
class SelfFilterNodeParameters(SelfFilterParameters):
    """The filter's, and the node's own."""

    description_parameter: str = "robot_description"  # parameter with the URDF, looked for upwards
    root_frame: str = ""  # tf frame of the URDF's root link; empty: its name
    max_age: float = 0.5  # [s] older images are dropped
    max_future: float = 0.1  # [s] images stamped farther ahead are dropped
    transform_tolerance: float = 0.1  # [s] an image waits so long for tf and joint states
    input_timeout: float = 1.0  # [s] silence reported in /diagnostics

    def __post_init__(self) -> None:
        super().__post_init__()
        check_text("description_parameter", self.description_parameter)
        check_text("root_frame", self.root_frame, may_be_empty=True)
        check_range("max_age", self.max_age, 0.0, 10.0, "s")
        check_range("max_future", self.max_future, 0.0, 10.0, "s")
        check_range("transform_tolerance", self.transform_tolerance, 0.0, 10.0, "s")
        check_range("input_timeout", self.input_timeout, 0.01, 60.0, "s")


@dataclass(frozen=True)
class _Ready:
    """An image and all that is needed to filter it."""

    message: Image
    pixels: np.ndarray  # (H, W) uint16 [mm] or float32 [m]
    camera: PinholeCamera
    T_camera_root: np.ndarray  # (4, 4)


class DepthSelfFilterNode:
    """Passes on images from which the robot could be removed, and no others.

    An image with the robot in it would pass for one without: its arm would be an obstacle.
    """

    def __init__(self) -> None:
        self._p = build(SelfFilterNodeParameters, private_values(), rospy.get_name())
        self._jumps, self._news = JumpDetector(), threading.Event()
        self._model: RobotModel | None = None
        self._filter: SelfFilter | None = None
        self._camera: PinholeCamera | None = None
        self._used: PinholeCamera | None = None
        self._info: CameraInfo | None = None
        self._looked = -NEXT_LOOK
        self._joints = JointHistory(tolerance=self._p.joint_tolerance, max_gap=self._p.joint_gap)
        self._diagnostics = NodeDiagnostics(self._p.input_timeout)
        self._tf = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._tf)
        self._image_pub = rospy.Publisher("depth_filtered/image_rect", Image, queue_size=2)
        self._info_pub = rospy.Publisher("depth_filtered/camera_info", CameraInfo, queue_size=2)
        self._points_pub = rospy.Publisher("depth_filtered/points", PointCloud2, queue_size=2)
        self._look_for_model()
        self._info_topic = rospy.resolve_name("depth/camera_info")
        self._joints_topic = rospy.resolve_name("joint_states")
        self._diagnostics.expect(self._info_topic)
        self._diagnostics.expect(self._joints_topic)
        rospy.Subscriber("depth/camera_info", CameraInfo, self._on_info, queue_size=2)
        rospy.Subscriber("joint_states", JointState, self._on_joints, queue_size=100)
        limits = InputLimits(self._p.max_age, self._p.max_future, self._p.transform_tolerance)
        self._input = SensorInput(
            "depth/image_rect",
            Image,
            limits,
            self._diagnostics,
            lambda message: (message, from_depth_image(message)),
            self._ready,
            self._news.set,
        )
        rospy.on_shutdown(self._news.set)
        rospy.loginfo(f"self-filter waits for {self._input.topic}, {self._joints_topic}")

    def spin(self) -> None:
        """Filter until shutdown; in the main thread, so that a fault ends the node."""
        while not rospy.is_shutdown():
            self._news.wait(WAITING if self._input.waits else LOOK_ROUND)
            self._news.clear()
            self._look_for_model()
            now = rospy.Time.now()
            if self._jumps.jumped_back(now):
                self._restart()
            for ready, arrived in self._input.take(now):
                self._pass_on(ready, arrived)

    def _ready(self, received: Received) -> _Ready:
        """What is needed at the image's stamp, or what it waits for."""
        if self._model is None:
            name = rospy.resolve_name(self._p.description_parameter)
            raise NotYetError(Outcome.NO_MODEL, f"no parameter {name}")
        if self._camera is None:
            raise NotYetError(Outcome.NO_CAMERA, f"nothing on {self._info_topic}")
        message, pixels = received.content
        camera = self._camera
        if pixels.shape != (camera.height, camera.width):
            size = f"{message.width} x {message.height}, camera_info's another"
            raise NotYetError(Outcome.NO_CAMERA, size)
        stamp = received.stamp.to_sec()
        waited = (rospy.Time.now() - received.stamp).to_sec()
        behind = self._joints.latest(self._model.movable) < stamp
        if behind and waited <= self._p.transform_tolerance:
            raise NotYetError(Outcome.NO_JOINTS, "")
        try:
            self._joints.at(stamp, self._model.movable)
        except InputError as error:
            raise NotYetError(Outcome.NO_JOINTS, str(error)) from None
        root = self._p.root_frame or self._model.root
        transform = self._tf.lookup_transform(received.frame, root, received.stamp)
        return _Ready(message, pixels, camera, from_transform(transform))

    def _pass_on(self, ready: _Ready, arrived: float) -> None:
        message = ready.message
        stamp = message.header.stamp.to_sec()
        try:
            filtered = self._of(ready.camera).filter(
                ready.pixels, stamp, self._joints, ready.T_camera_root
            )
        except InputError as error:  # joint states have gone since: the clock has jumped
            self._diagnostics.count(self._input.topic, Outcome.NO_JOINTS, str(error))
            return
        self._image_pub.publish(to_same_image(message, filtered.image))
        if self._info is not None:
            self._info.header = message.header
            self._info_pub.publish(self._info)
        if self._points_pub.get_num_connections():
            self._points_pub.publish(to_points(message.header, filtered.depth, filtered.camera))
        self._diagnostics.latency(time.monotonic() - arrived)

    def _of(self, camera: PinholeCamera) -> SelfFilter:
        """The filter of the camera as it is now."""
        assert self._model is not None  # _ready has seen to it
        if self._filter is None or self._used != camera:
            if self._filter is not None:
                self._filter.close()
            self._filter, self._used = SelfFilter(self._model, camera, self._p), camera
        return self._filter

    def _look_for_model(self) -> None:
        """Read the robot's description as soon as it is there; one that is broken ends the node."""
        if self._model is not None or time.monotonic() - self._looked < NEXT_LOOK:
            return
        self._looked = time.monotonic()
        found = rospy.search_param(self._p.description_parameter)
        if found is None:
            rospy.logwarn_throttle(
                10.0, f"waiting for: parameter {rospy.resolve_name(self._p.description_parameter)}"
            )
            return
        try:
            model = load_robot_model(rospy.get_param(found), package_folder, self._p.visual)
        except InputError as error:
            raise InputError(f"parameter {found}: {error}") from None
        SelfFilter(model, PinholeCamera(16, 16, 16, 16, 8, 8), self._p).close()  # refuses now
        rospy.loginfo(f"{found}: {model.name}, {len(model.movable)} joints")
        self._model = model

    def _on_info(self, message: CameraInfo) -> None:
        outcome, detail = Outcome.OK, ""
        try:
            self._camera, self._info = from_camera_info(message), message
        except UnusableMessageError as error:
            outcome, detail = error.outcome, str(error)
        self._diagnostics.count(self._info_topic, outcome, detail)

    def _on_joints(self, message: JointState) -> None:
        outcome, detail = Outcome.OK, ""
        ahead = (message.header.stamp - rospy.Time.now()).to_sec()
        if ahead > self._p.max_future:
            outcome, detail = Outcome.FUTURE, f"{ahead:.3f} s ahead"
        else:
            try:
                self._joints.add(message.header.stamp.to_sec(), message.name, message.position)
            except InputError as error:
                outcome, detail = Outcome.BAD_FIELDS, str(error)
        self._diagnostics.count(self._joints_topic, outcome, detail)
        if self._input_waits():
            self._news.set()

    def _input_waits(self) -> bool:
        return hasattr(self, "_input") and self._input.waits

    def _restart(self) -> None:
        rospy.logwarn("the clock went back: joint states, tf and waiting images are forgotten")
        self._input.restart()
        self._joints.clear()
        self._tf.clear()


def main() -> None:
    """Run the node."""
    rospy.init_node("depth_self_filter")
    DepthSelfFilterNode().spin()
