"""Node `depth_self_filter`: a depth camera's images without the robot itself."""

from __future__ import annotations

import copy
import threading
import time
from dataclasses import dataclass

import numpy as np
import rospy
import tf2_ros
from sensor_msgs.msg import CameraInfo, Image, PointCloud2

from safe_passage.core.errors import InputError
from safe_passage.core.parameters import check_range, check_text
from safe_passage.core.reading import build
from safe_passage.robot_model import JointHistory, PinholeCamera, RobotModel
from safe_passage.ros.arm_inputs import ArmInputs, described_robot
from safe_passage.ros.conversions import from_transform
from safe_passage.ros.depth_conversions import from_depth_image, to_points, to_same_image
from safe_passage.ros.diagnostics import NodeDiagnostics, Outcome
from safe_passage.ros.input_loop import rounds
from safe_passage.ros.live_tuning import LiveTuning
from safe_passage.ros.parameters import private_values
from safe_passage.ros.sensor_input import NEWEST, InputLimits, NotYetError, Received, SensorInput
from safe_passage.self_filter import SelfFilter, SelfFilterParameters

LIVE = (  # may be changed while it runs; not the model or frames
    "padding", "depth_noise", "edge", "sliver_band", "sliver_support", "sliver_depth",
    "time_uncertainty", "joint_tolerance", "joint_gap",
)  # fmt: skip
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
        self._news = threading.Event()
        self._model: RobotModel | None = None
        self._filter: SelfFilter | None = None
        self._used: PinholeCamera | None = None
        self._looked = -NEXT_LOOK
        self._diagnostics = NodeDiagnostics(self._p.input_timeout)
        self._tf = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._tf)
        self._image_pub = rospy.Publisher("depth_filtered/image_rect", Image, queue_size=2)
        self._info_pub = rospy.Publisher("depth_filtered/camera_info", CameraInfo, queue_size=2)
        self._points_pub = rospy.Publisher("depth_filtered/points", PointCloud2, queue_size=2)
        self._look_for_model()
        limits = InputLimits(self._p.max_age, self._p.max_future, self._p.transform_tolerance)
        joints = JointHistory(tolerance=self._p.joint_tolerance, max_gap=self._p.joint_gap)
        self._arm = ArmInputs(joints, limits, self._diagnostics)
        self._input = SensorInput(
            "depth/image_rect",
            Image,
            limits,
            self._diagnostics,
            lambda message: (message, from_depth_image(message)),
            self._ready,
            self._news.set,
            most=NEWEST,
        )
        self._tuning = LiveTuning(self._p, LIVE)
        rospy.loginfo(f"self-filter waits for {self._input.topic}, {self._arm.joints_topic}")

    def spin(self) -> None:
        """Filter until shutdown."""
        for now in rounds(self._news, lambda: self._input.waits, self._restart):
            self._tune()
            self._look_for_model()
            for ready, arrived in self._input.take(now):
                self._pass_on(ready, arrived)

    def _tune(self) -> None:
        """Between two images; joint states stay."""
        parameters = self._tuning.take()
        if parameters is None:
            return
        self._p = parameters
        self._arm.joints.tune(parameters.joint_tolerance, parameters.joint_gap)
        if self._filter is not None:
            self._filter.tune(parameters)

    def _ready(self, received: Received) -> _Ready:
        """What is needed at the image's stamp, or what it waits for."""
        if self._model is None:
            name = rospy.resolve_name(self._p.description_parameter)
            raise NotYetError(Outcome.NO_MODEL, f"no parameter {name}")
        message, pixels = received.content
        camera = self._arm.camera_of(pixels)
        self._arm.positions(received.stamp.to_sec(), self._model.movable)
        root = self._p.root_frame or self._model.root
        transform = self._tf.lookup_transform(received.frame, root, received.stamp)
        return _Ready(message, pixels, camera, from_transform(transform))

    def _pass_on(self, ready: _Ready, arrived: float) -> None:
        message = ready.message
        stamp = message.header.stamp.to_sec()
        try:
            filtered = self._of(ready.camera).filter(
                ready.pixels, stamp, self._arm.joints, ready.T_camera_root
            )
        except InputError as error:  # joint states have gone since: the clock has jumped
            self._diagnostics.count(self._input.topic, Outcome.NO_JOINTS, str(error))
            return
        self._image_pub.publish(to_same_image(message, filtered.image))
        if self._arm.info is not None:
            info = copy.copy(self._arm.info)
            info.header = message.header
            self._info_pub.publish(info)
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
        name = rospy.resolve_name(self._p.description_parameter)
        model = described_robot(self._p.description_parameter, self._p.visual)
        if model is None:
            rospy.logwarn_throttle(10.0, f"waiting for: parameter {name}")
            return
        SelfFilter(model, PinholeCamera(16, 16, 16, 16, 8, 8), self._p).close()  # refuses now
        rospy.loginfo(f"{name}: {model.name}, {len(model.movable)} joints")
        self._model = model

    def _restart(self) -> None:
        rospy.logwarn("the clock went back: joint states, tf and waiting images are forgotten")
        self._input.restart()
        self._arm.joints.clear()
        self._tf.clear()


def main() -> None:
    """Run the node."""
    rospy.init_node("depth_self_filter")
    DepthSelfFilterNode().spin()
