"""What is known of an arm and the depth camera that sees it: camera_info, joint states, URDF."""

from __future__ import annotations

from typing import Sequence

import numpy as np
import rospy
from sensor_msgs.msg import CameraInfo, JointState

from safe_passage.core.errors import InputError
from safe_passage.robot_model import JointHistory, PinholeCamera, RobotModel, load_robot_model
from safe_passage.ros.depth_conversions import from_camera_info
from safe_passage.ros.diagnostics import NodeDiagnostics, Outcome
from safe_passage.ros.packages import package_folder
from safe_passage.ros.sensor_conversions import UnusableMessageError
from safe_passage.ros.sensor_input import InputLimits, NotYetError


def described_robot(parameter: str, visual: bool) -> RobotModel | None:
    """The robot whose URDF is in `parameter`, looked for upwards; None: there is no such one.

    Raises:
        InputError: it cannot be used; names the parameter.
    """
    found = rospy.search_param(parameter)
    if found is None:
        return None
    try:
        return load_robot_model(rospy.get_param(found), package_folder, visual)
    except InputError as error:
        raise InputError(f"parameter {found}: {error}") from None


class ArmInputs:
    """Topics depth/camera_info and joint_states.

    Args:
        joints: that the joint states go to.
    """

    def __init__(
        self, joints: JointHistory, limits: InputLimits, diagnostics: NodeDiagnostics
    ) -> None:
        self._limits, self._diagnostics = limits, diagnostics
        self.joints = joints
        self.info: CameraInfo | None = None  # the last that could be used
        self.camera: PinholeCamera | None = None  # the same
        self.info_topic = rospy.resolve_name("depth/camera_info")
        self.joints_topic = rospy.resolve_name("joint_states")
        diagnostics.expect(self.info_topic)
        diagnostics.expect(self.joints_topic)
        rospy.Subscriber("depth/camera_info", CameraInfo, self._on_info, queue_size=2)
        rospy.Subscriber("joint_states", JointState, self._on_joints, queue_size=100)

    def camera_of(self, pixels: np.ndarray) -> PinholeCamera:
        """The camera of an image (H, W); raises NotYetError."""
        camera = self.camera
        if camera is None:
            raise NotYetError(Outcome.NO_CAMERA, f"nothing usable on {self.info_topic}")
        if pixels.shape != (camera.height, camera.width):
            height, width = pixels.shape
            size = f"{width} x {height}, on {self.info_topic} another"
            raise NotYetError(Outcome.NO_CAMERA, size)
        return camera

    def positions(self, stamp: float, names: Sequence[str]) -> dict[str, float]:
        """Of the joints at a stamp [s]; raises NotYetError, also while they may still come."""
        waited = rospy.Time.now().to_sec() - stamp
        if self.joints.latest(names) < stamp and waited <= self._limits.transform_tolerance:
            raise NotYetError(Outcome.NO_JOINTS, "")
        try:
            return self.joints.at(stamp, names)
        except InputError as error:
            raise NotYetError(Outcome.NO_JOINTS, str(error)) from None

    def _on_info(self, message: CameraInfo) -> None:
        outcome, detail = Outcome.OK, ""
        try:
            self.camera, self.info = from_camera_info(message), message
        except UnusableMessageError as error:
            outcome, detail = error.outcome, str(error)
        self._diagnostics.count(self.info_topic, outcome, detail)

    def _on_joints(self, message: JointState) -> None:
        outcome, detail = Outcome.OK, ""
        ahead = (message.header.stamp - rospy.Time.now()).to_sec()
        if ahead > self._limits.max_future:
            outcome, detail = Outcome.FUTURE, f"{ahead:.3f} s ahead"
        else:
            try:
                self.joints.add(message.header.stamp.to_sec(), message.name, message.position)
            except InputError as error:
                outcome, detail = Outcome.BAD_FIELDS, str(error)
        self._diagnostics.count(self.joints_topic, outcome, detail)
