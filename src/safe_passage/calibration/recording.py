"""What a calibration needs, from a folder or from streams: poses of the arm, median depths."""

from __future__ import annotations

import re
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Sequence

import numpy as np

from safe_passage.calibration.accumulation import temporal_median
from safe_passage.calibration.pipeline import ArmView
from safe_passage.core.depth_image import metres
from safe_passage.core.errors import InputError, SafePassageError
from safe_passage.core.reading import read_array, read_picture, read_yaml
from safe_passage.robot_model import JointHistory, PinholeCamera
from safe_passage.robot_model.joint_history import moved

DEPTH = re.compile(r"depth_(\d+)(?:_(\d+))?\.(npy|png)")
STILL_TIME = 0.3  # [s] before an image for which the arm must have stood
STILL_ANGLE = 0.002  # [rad or m] by which an arm that stands still moves at most
LEAST_IMAGES = 3  # of a pose in a stream


@dataclass(frozen=True)
class ArmRecording:
    """A camera that has seen the arm in some poses."""

    camera: PinholeCamera
    views: tuple[ArmView, ...]


def read_folder(folder: Path, joints: Sequence[str], least_share: float) -> ArmRecording:
    """A folder of one file per image and pose.

    depth_POSE.npy or depth_POSE_IMAGE.npy (float32 [m]), or .png (16 bit [mm]), 0 or NaN = none;
    joint_states_POSE.npy (in the order of `joints`) or .yaml (name: position);
    a camera_info in one file *camera_info.yaml.

    Args:
        joints: names of the robot's movable joints.
        least_share: of a pose's images in which a pixel must have a depth.

    Raises:
        InputError: names the file that is missing or cannot be used.
    """
    images = defaultdict(list)
    for path in sorted(folder.glob("depth_*")):
        match = DEPTH.fullmatch(path.name)
        if match:
            images[int(match[1])].append(_depth(path))
    if not images:
        raise InputError(f"{folder}: there is no depth_0.npy or depth_0.png in it")
    views = []
    for pose, depths in sorted(images.items()):
        try:
            median = temporal_median(depths, least_share)
        except InputError as error:
            raise InputError(f"{folder}: pose {pose}: {error}") from None
        views.append(ArmView(median, _positions(folder, pose, joints)))
    camera = _camera(folder)
    for view in views:
        if view.depth.shape != (camera.height, camera.width):
            raise InputError(f"{folder}: depth images {view.depth.shape}, the camera's are not")
    return ArmRecording(camera, tuple(views))


def standstills(
    stamps: Sequence[float],
    depths: Sequence[np.ndarray],
    joints: JointHistory,
    names: Sequence[str],
    least_share: float,
) -> tuple[ArmView, ...]:
    """A stream of images -> one view for each time that the arm stood still.

    Args:
        stamps: [s] of the images, ascending.
        depths: (H, W) [m] each, NaN = none.
        joints: their states, of all the time.
        names: of the joints.
    """
    groups: list[tuple[dict[str, float], list[np.ndarray]]] = []
    moving = True
    for stamp, depth in zip(stamps, depths):
        try:
            before, now = joints.at(stamp - STILL_TIME, names), joints.at(stamp, names)
        except InputError:
            moving = True
            continue
        if moved(before, now) > STILL_ANGLE:
            moving = True
        elif moving or moved(groups[-1][0], now) > STILL_ANGLE:
            groups.append((now, [depth]))
            moving = False
        else:
            groups[-1][1].append(depth)
    return tuple(
        ArmView(temporal_median(images, least_share), positions)
        for positions, images in groups
        if len(images) >= LEAST_IMAGES
    )


def _depth(path: Path) -> np.ndarray:
    image = read_array(path) if path.suffix == ".npy" else read_picture(path)
    try:
        return metres(image.astype(np.float32) if image.dtype == np.float64 else image)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _positions(folder: Path, pose: int, joints: Sequence[str]) -> dict[str, float]:
    array, named = (folder / f"joint_states_{pose}.{ending}" for ending in ("npy", "yaml"))
    if named.is_file():
        return {str(name): _number(value, named) for name, value in read_yaml(named).items()}
    values = read_array(array).ravel()
    if len(values) != len(joints):
        raise InputError(f"{array}: {len(values)} positions for the joints {', '.join(joints)}")
    return dict(zip(joints, map(float, values)))


def _number(value: Any, path: Path) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise InputError(f"{path}: {value!r} is not a number")
    return float(value)


def _camera(folder: Path) -> PinholeCamera:
    found = sorted(folder.glob("*camera_info.yaml"))
    if len(found) != 1:
        raise InputError(f"{folder}: there must be one *camera_info.yaml, there are {len(found)}")
    info = read_yaml(found[0])
    matrix = info.get("p") or info.get("P") or info.get("k") or info.get("K")
    try:
        values = np.array(matrix, float).reshape(3, -1)
        return PinholeCamera.of_matrix(values, int(info["width"]), int(info["height"]))
    except (KeyError, OverflowError, TypeError, ValueError, SafePassageError) as error:
        raise InputError(f"{found[0]}: no camera_info ({error})") from None
