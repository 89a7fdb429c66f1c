"""A robot as its URDF describes it: where its links are, what they look like to a camera."""

from safe_passage.robot_model.camera import PinholeCamera
from safe_passage.robot_model.joint_history import JointHistory
from safe_passage.robot_model.renderer import DepthRenderer
from safe_passage.robot_model.resources import Packages
from safe_passage.robot_model.robot import RobotModel, load_robot_model

__all__ = [
    "DepthRenderer",
    "JointHistory",
    "Packages",
    "PinholeCamera",
    "RobotModel",
    "load_robot_model",
]
