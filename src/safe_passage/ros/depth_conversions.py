"""Depth images and their camera to arrays, or the reason why that is not possible; and back."""

from __future__ import annotations

import numpy as np
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField
from std_msgs.msg import Header

from safe_passage.core.errors import SafePassageError
from safe_passage.robot_model import PinholeCamera
from safe_passage.ros.diagnostics import Outcome
from safe_passage.ros.sensor_conversions import UnusableMessageError

PIXELS = {"16UC1": "u2", "mono16": "u2", "32FC1": "f4"}


def from_depth_image(message: Image) -> np.ndarray:
    """(H, W) uint16 [mm] or float32 [m], native byte order; raises UnusableMessageError."""
    if message.encoding not in PIXELS:
        raise UnusableMessageError(
            Outcome.BAD_FIELDS, f"encoding {message.encoding!r}: must be 16UC1 or 32FC1"
        )
    kind = np.dtype(PIXELS[message.encoding]).newbyteorder(">" if message.is_bigendian else "<")
    height, width, step = message.height, message.width, message.step
    if 0 in (height, width):
        raise UnusableMessageError(Outcome.EMPTY, "no pixels")
    if step < width * kind.itemsize or len(message.data) < step * height:
        raise UnusableMessageError(
            Outcome.BAD_FIELDS, f"{len(message.data)} bytes for {width} x {height}, step {step}"
        )
    rows = np.frombuffer(message.data, np.uint8, step * height).reshape(height, step)
    pixels = np.ascontiguousarray(rows[:, : width * kind.itemsize]).view(kind)
    return pixels.astype(kind.newbyteorder("="))


def to_same_image(message: Image, pixels: np.ndarray) -> Image:
    """`pixels` (H, W) with the message's header and encoding."""
    height, width = pixels.shape
    little = pixels.astype(pixels.dtype.newbyteorder("<"), copy=False)
    step = width * little.itemsize
    return Image(message.header, height, width, message.encoding, 0, step, little.tobytes())


def from_camera_info(message: CameraInfo) -> PinholeCamera:
    """The rectified camera; raises UnusableMessageError."""
    try:
        matrix = np.reshape(message.P, (3, 4))
        return PinholeCamera.of_matrix(matrix, message.width, message.height)
    except (SafePassageError, ValueError) as error:
        raise UnusableMessageError(Outcome.BAD_FIELDS, f"P: {error}") from None


def to_points(header: Header, depth: np.ndarray, camera: PinholeCamera) -> PointCloud2:
    """Organised cloud of depth (H, W) [m], NaN = none."""
    height, width = depth.shape
    u, v = np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32)
    xyz = np.empty((height, width, 3), "<f4")
    xyz[..., 0] = (u - np.float32(camera.cx)) / np.float32(camera.fx) * depth
    xyz[..., 1] = ((v - np.float32(camera.cy)) / np.float32(camera.fy))[:, None] * depth
    xyz[..., 2] = depth
    fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate("xyz")]
    return PointCloud2(header, height, width, fields, False, 12, 12 * width, xyz.tobytes(), False)
