"""Between numpy and ROS messages."""

from __future__ import annotations

import numpy as np
import rospy
from geometry_msgs.msg import Point, Quaternion, Transform, TransformStamped, Vector3
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud2, PointField
from std_msgs.msg import Header

from safe_passage.core.geometry import Pose
from safe_passage.costmap import quaternion_yaw

UNIT = 0.01  # by which a quaternion's squared length may be off 1, as in tf2


def to_header(stamp: rospy.Time, frame_id: str) -> Header:
    """A header without sequence number, which the publisher fills in."""
    return Header(stamp=stamp, frame_id=frame_id)


def to_cloud(header: Header, xyz: np.ndarray, bgr: np.ndarray) -> PointCloud2:
    """Organised XYZRGB cloud from (H, W, 3) float32 [m] and (H, W, 3) uint8."""
    height, width = xyz.shape[:2]
    points = np.zeros((height, width), [("xyz", "<f4", 3), ("bgra", "u1", 4)])
    points["xyz"] = xyz
    points["bgra"][..., :3] = bgr
    fields = [
        PointField(name, 4 * i, PointField.FLOAT32, 1)
        for i, name in enumerate(("x", "y", "z", "rgb"))
    ]
    return PointCloud2(
        header, height, width, fields, False, 16, 16 * width, points.tobytes(), False
    )


def to_image(header: Header, bgr: np.ndarray) -> Image:
    """bgr8 image from (H, W, 3) uint8."""
    height, width = bgr.shape[:2]
    return Image(header, height, width, "bgr8", 0, 3 * width, np.ascontiguousarray(bgr).tobytes())


def to_depth_image(header: Header, depth: np.ndarray) -> Image:
    """32FC1 image from (H, W) [m], NaN = no return (REP 118)."""
    height, width = depth.shape
    data = np.ascontiguousarray(depth, np.float32).tobytes()
    return Image(header, height, width, "32FC1", 0, 4 * width, data)


def to_camera_info(
    header: Header, size: tuple[int, int], intrinsics: tuple[float, float, float, float]
) -> CameraInfo:
    """Rectified camera: `size` (height, width) [px], `intrinsics` fx, fy, cx, cy [px]."""
    fx, fy, cx, cy = intrinsics
    info = CameraInfo(header=header, height=size[0], width=size[1], distortion_model="plumb_bob")
    info.D = [0.0] * 5
    info.K = [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]
    info.R = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    info.P = [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0]
    return info


def to_scan(
    header: Header, angles: np.ndarray, ranges: np.ndarray, limits: tuple[float, float]
) -> LaserScan:
    """Scan from evenly spaced `angles` (N,) [rad] and `ranges` (N,) [m]; `limits`: valid ranges."""
    return LaserScan(
        header=header,
        angle_min=angles[0],
        angle_max=angles[-1],
        angle_increment=(angles[-1] - angles[0]) / (len(angles) - 1),
        range_min=limits[0],
        range_max=limits[1],
        ranges=ranges.tolist(),
    )


def to_transform(
    header: Header, child: str, translation: np.ndarray, rotation: np.ndarray | None = None
) -> TransformStamped:
    """Pose of frame `child` in the header's frame; `rotation` (3, 3), identity without it."""
    message = TransformStamped(header=header, child_frame_id=child)
    place, turn = message.transform.translation, message.transform.rotation
    place.x, place.y, place.z = translation
    turn.x, turn.y, turn.z, turn.w = Rotation.from_matrix(
        np.eye(3) if rotation is None else rotation
    ).as_quat()
    return message


def from_transform(message: TransformStamped) -> np.ndarray:
    """(4, 4) of the child's pose in the header's frame."""
    place, turn = message.transform.translation, message.transform.rotation
    T = np.eye(4)
    T[:3, :3] = Rotation.from_quat((turn.x, turn.y, turn.z, turn.w)).as_matrix()
    T[:3, 3] = place.x, place.y, place.z
    return T


def is_transform(message: Transform) -> bool:
    """Finite, with a quaternion of length 1: of others tf2 takes nothing."""
    place, turn = message.translation, message.rotation
    values = np.array([place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w])
    return bool(np.isfinite(values).all() and abs(values[3:] @ values[3:] - 1.0) <= UNIT)


def planar_pose(place: Point | Vector3, turn: Quaternion) -> Pose:
    """Place and heading as seen from above."""
    return place.x, place.y, quaternion_yaw((turn.x, turn.y, turn.z, turn.w))
