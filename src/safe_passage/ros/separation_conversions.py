"""Between the separation monitor and ROS messages."""

from __future__ import annotations

import math

import numpy as np
from geometry_msgs.msg import Quaternion, Twist
from nav_msgs.msg import Odometry, Path
from std_msgs.msg import Header

from safe_passage.core.geometry import Pose, placed
from safe_passage.msg import SeparationState, TrackedObstacle, TrackedObstacleArray
from safe_passage.ros.conversions import planar_pose
from safe_passage.ros.diagnostics import Outcome
from safe_passage.ros.sensor_conversions import UnusableMessageError
from safe_passage.separation import Assessment, Obstacles
from safe_passage.separation.robot_motion import Velocity

FASTEST = 100.0  # [m/s], [rad/s] what claims to be faster is no velocity
NOT_UNIT = 0.1  # a quaternion whose squared length is off by more is none


def to_obstacles(array: TrackedObstacleArray) -> Obstacles:
    """In the array's frame; an obstacle without cells is one at its position.

    Raises:
        UnusableMessageError: something in it is not finite, or does not fit together.
    """
    if not (math.isfinite(array.resolution) and array.resolution > 0.0):
        raise UnusableMessageError(Outcome.BAD_FIELDS, f"resolution {array.resolution}")
    many = array.obstacles
    if any(len(o.cells_x) != len(o.cells_y) for o in many):
        raise UnusableMessageError(Outcome.BAD_FIELDS, "cells_x and cells_y differ in length")
    obstacles = Obstacles(
        np.array([o.id for o in many], np.int64),
        np.array([(o.position.x, o.position.y) for o in many], float).reshape(-1, 2),
        np.array([(o.velocity.x, o.velocity.y) for o in many], float).reshape(-1, 2),
        np.array([o.covariance for o in many], float).reshape(-1, 4, 4),
        np.array([o.moving for o in many], bool),
        np.array([o.classification == TrackedObstacle.PERSON for o in many], bool),
        [_cells(o) for o in many],
        array.resolution,
    )
    numbers = [obstacles.position, obstacles.velocity, obstacles.covariance, *obstacles.cells]
    if not all(np.isfinite(part).all() for part in numbers):
        raise UnusableMessageError(Outcome.NOT_FINITE, "an obstacle's place or motion")
    return obstacles


def ages_of(array: TrackedObstacleArray) -> np.ndarray:
    """(N,) [s]"""
    return np.array([o.age for o in array.obstacles], float)


def silent_sensors(array: TrackedObstacleArray, optional: tuple[str, ...]) -> list[str]:
    """Names of those that should be alive and are not; UnusableMessageError where one is not told.

    Of a sensor that `alive` does not reach, nobody knows.
    """
    if len(array.sensors) != len(array.alive):
        raise UnusableMessageError(Outcome.BAD_FIELDS, "sensors and alive differ in length")
    pairs = zip(array.sensors, array.alive)
    return [name for name, alive in pairs if not alive and name not in optional]


def to_velocity(odometry: Odometry) -> Velocity:
    """Twist in base; UnusableMessageError if it is not finite."""
    velocity = planar(odometry.twist.twist)
    if not all(map(math.isfinite, velocity)):
        raise UnusableMessageError(Outcome.NOT_FINITE, "the twist")
    return velocity


def planar(twist: Twist) -> Velocity:
    """In the plane; NaN everywhere if any of its parts is not finite, or no robot's."""
    line, turn = twist.linear, twist.angular
    parts = line.x, line.y, line.z, turn.x, turn.y, turn.z
    if all(abs(part) <= FASTEST for part in parts):  # NaN compares false
        return line.x, line.y, turn.z
    return math.nan, math.nan, math.nan


def to_twist(velocity: Velocity) -> Twist:
    """A command."""
    twist = Twist()
    twist.linear.x, twist.linear.y, twist.angular.z = velocity
    return twist


def to_path(message: Path, T_base_path: Pose, oriented: bool) -> np.ndarray:
    """(K, 2) [m] in base; with the robot's heading, (K, 3) [m, rad], if its poses are `oriented`.

    Planners do not agree on what orientations mean; where one is none, all are left out.
    """
    poses = [stamped.pose for stamped in message.poses]
    if oriented and all(_is_turn(pose.orientation) for pose in poses):
        turned = [planar_pose(pose.position, pose.orientation) for pose in poses]
        path = np.array(turned, float).reshape(-1, 3)
        return np.column_stack([placed(path[:, :2], T_base_path), path[:, 2] + T_base_path[2]])
    points = [(pose.position.x, pose.position.y) for pose in poses]
    return placed(np.array(points, float).reshape(-1, 2), T_base_path)


def _is_turn(q: Quaternion) -> bool:
    """Whether it is a unit quaternion."""
    return abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1.0) < NOT_UNIT


def to_state(assessment: Assessment, header: Header, detail: str = "") -> SeparationState:
    """What was assessed; `detail`: what exactly is missing."""
    text = assessment.reason.name + (f": {detail}" if detail else "")
    return SeparationState(
        header=header,
        level=assessment.level,
        reason=assessment.reason,
        text=text,
        scale=assessment.scale,
        time_to_collision=assessment.time_to_collision,
        present_distance=assessment.present_distance,
        predicted_distance=assessment.predicted_distance,
        required_distance=assessment.required_distance,
        obstacle_id=assessment.obstacle_id,
        on_path=assessment.on_path,
    )


def frame_pose(transform) -> Pose:
    """Of a TransformStamped, as seen from above."""
    return planar_pose(transform.transform.translation, transform.transform.rotation)


def _cells(obstacle: TrackedObstacle) -> np.ndarray:
    cells = np.stack([obstacle.cells_x, obstacle.cells_y], axis=1).astype(float).reshape(-1, 2)
    return cells if len(cells) else np.array([[obstacle.position.x, obstacle.position.y]])
