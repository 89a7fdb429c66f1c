"""Bags of a camera that sees the robot's arm -> views for the calibration."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from safe_passage.calibration.recording import ArmRecording, standstills
from safe_passage.core.errors import InputError
from safe_passage.robot_model import JointHistory, PinholeCamera
from safe_passage.ros.bags import read_bag
from safe_passage.self_filter.depth_image import metres

KINDS = ("sensor_msgs/Image", "sensor_msgs/CameraInfo", "sensor_msgs/JointState")
PIXELS = {"16UC1": "u2", "mono16": "u2", "32FC1": "f4"}
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
    info = messages[beside[0]][0]
    camera = PinholeCamera.of_matrix(np.reshape(info.P, (3, 4)), info.width, info.height)
    images = messages[depth[0]]
    stamps = [message.header.stamp.to_sec() for message in images]
    views = standstills(stamps, [to_depth(one) for one in images], history, joints, least_share)
    if not views:
        raise InputError(f"{path}: the arm never stands still with its joints {', '.join(joints)}")
    return ArmRecording(camera, views)


def to_depth(message: object) -> np.ndarray:
    """Depth (H, W) float32 [m], NaN = none, of a sensor_msgs/Image; raises InputError."""
    return metres(to_raw_depth(message))


def to_raw_depth(message) -> np.ndarray:  # type: ignore[no-untyped-def]
    """(H, W) uint16 [mm] or float32 [m], native byte order; raises InputError."""
    if message.encoding not in PIXELS:
        raise InputError(f"depth image of encoding {message.encoding!r}: must be 16UC1 or 32FC1")
    kind = np.dtype(PIXELS[message.encoding]).newbyteorder(">" if message.is_bigendian else "<")
    width = message.width * kind.itemsize
    if message.step < width or len(message.data) < message.step * message.height:
        raise InputError(
            f"depth image {message.width} x {message.height}: {len(message.data)} bytes"
        )
    rows = np.frombuffer(message.data, np.uint8, message.step * message.height)
    rows = rows.reshape(message.height, message.step)[:, :width]
    native = np.ascontiguousarray(rows).view(kind)
    return native.astype(kind.newbyteorder("="))
