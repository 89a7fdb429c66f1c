"""What a goal of the camera calibrator asks for, or why it cannot be had."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import rospy
from geometry_msgs.msg import TransformStamped

from safe_passage.calibration.writers import folder_for
from safe_passage.core.errors import InputError, ParameterError
from safe_passage.core.parameters import check_range
from safe_passage.msg import CalibrateCameraGoal
from safe_passage.robot_model import RobotModel
from safe_passage.ros.actions import RefusedError
from safe_passage.ros.arm_inputs import described_robot
from safe_passage.ros.calibrator_parameters import LONGEST, MOST_POSES
from safe_passage.ros.conversions import from_transform, is_transform


def check_goal(goal: CalibrateCameraGoal) -> None:
    """Raises RefusedError where a number of it has no meaning."""
    try:
        check_range("poses", goal.poses, 0, MOST_POSES, "")
        check_range("timeout", goal.timeout, 0.0, LONGEST, "s")
    except ParameterError as error:
        raise RefusedError("BAD_GOAL", str(error)) from None


def folder_of(goal: CalibrateCameraGoal) -> Path | None:
    """Where the files go; one that cannot be is not found after all the poses."""
    try:
        return folder_for(goal.output_folder) if goal.output_folder else None
    except InputError as error:
        raise RefusedError("BAD_GOAL", f"output_folder {error}") from None


def guess_of(goal: CalibrateCameraGoal) -> np.ndarray | None:
    """T_root_camera (4, 4) that the goal gives; None: it gives none."""
    if not goal.guess_given:
        return None
    given = TransformStamped()
    given.transform.translation = goal.guess.position
    given.transform.rotation = goal.guess.orientation
    if not is_transform(given.transform):
        raise RefusedError("BAD_GOAL", "guess: finite, its quaternion of length 1")
    return from_transform(given)


def arm_of(parameter: str, visual: bool) -> RobotModel:
    """The robot as `parameter` describes it now."""
    try:
        model = described_robot(parameter, visual)
    except InputError as error:
        raise RefusedError("NO_INPUT", str(error)) from None
    if model is None:
        name = rospy.resolve_name(parameter)
        raise RefusedError("NO_INPUT", f"there is no parameter {name} with the URDF")
    if not model.movable:
        raise RefusedError("NO_INPUT", f"parameter {parameter}: {model.name} has no joint")
    return model
