"""Bags of a camera that sees the robot's arm -> views for the calibration."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from sensor_msgs.msg import Image

from safe_passage.calibration.recording import ArmRecording, standstills
from safe_passage.core.depth_image import metres
from safe_passage.core.errors import InputError
from safe_passage.robot_model import JointHistory
from safe_passage.ros.bags import read_bag
from safe_passage.ros.depth_conversions import PIXELS, from_camera_info, from_depth_image
from safe_passage.ros.sensor_conversions import UnusableMessageError

KINDS = ("sensor_msgs/Image", "sensor_msgs/CameraInfo", "sensor_msgs/JointState")
FOREVER = 1e9  # [s]


def read_arm_bag(path: Path, joints: tuple[str, ...], least_share: float) -> ArmRecording:
    """A bag with one depth image topic, one camera_info and any JointState topics.

    Raises:
        InputError: names what is missing, there twice, or cannot be used.
    """
    topics, messages = read_bag(path, KINDS)
    depth = [
        name
        for name, kind in topics.items()
        if kind == KINDS[0] and messages[name] and messages[name][0].encoding in PIXELS
    ]
    infos = [name for name, kind in topics.items() if kind == KINDS[1] and messages[name]]
    if len(depth) != 1:
        raise InputError(f"{path}: must have one topic of depth images, has {depth or 'none'}")
    folder = depth[0].rsplit("/", 1)[0]
    beside = [name for name in infos if name.rsplit("/", 1)[0] == folder] or infos
    if len(beside) != 1:
        raise InputError(f"{path}: must have one camera_info of {depth[0]}, has {infos or 'none'}")
    history = JointHistory(length=FOREVER, tolerance=0.05)
    for name, kind in topics.items():
        if kind == KINDS[2]:
            for message in messages[name]:
                history.add(message.header.stamp.to_sec(), message.name, message.position)
    try:
        camera = from_camera_info(messages[beside[0]][0])
    except UnusableMessageError as error:
        raise InputError(f"{path}: {beside[0]}: {error}") from None
    images = messages[depth[0]]
    stamps = [message.header.stamp.to_sec() for message in images]
    views = standstills(stamps, [_depth(one, path) for one in images], history, joints, least_share)
    if not views:
        raise InputError(f"{path}: the arm never stands still with its joints {', '.join(joints)}")
    return ArmRecording(camera, views)


def _depth(message: Image, path: Path) -> np.ndarray:
    """(H, W) float32 [m], NaN = none."""
    try:
        return metres(from_depth_image(message))
    except UnusableMessageError as error:
        raise InputError(f"{path}: a depth image with {error}") from None
