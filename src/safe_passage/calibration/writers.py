"""A calibration as files: yaml, a launch file with a static transform, a line for the URDF."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import yaml
from scipy.spatial.transform import Rotation

from safe_passage.calibration.pipeline import Calibration, Verdict
from safe_passage.core.errors import InputError

# Optical frame (x right, y down, z forward) in a camera's body frame (x forward): REP 103.
T_BODY_OPTICAL = np.array(
    [[0.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
)


def pose_of(values: list[float]) -> np.ndarray:
    """(4, 4) of x, y, z [m], roll, pitch, yaw [rad], as a URDF's origin has them."""
    if len(values) != 6 or not np.isfinite(values).all():
        raise InputError(f"pose {values}: must be x y z roll pitch yaw")
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("xyz", values[3:]).as_matrix()
    T[:3, 3] = values[:3]
    return T


def origin(T: np.ndarray) -> str:
    """The URDF's line of T (4, 4)."""
    xyz = " ".join(f"{value:.6f}" for value in T[:3, 3])
    turn = Rotation.from_matrix(T[:3, :3]).as_euler("xyz")
    return f'<origin xyz="{xyz}" rpy="{" ".join(f"{value:.6f}" for value in turn)}"/>'


def launch(T: np.ndarray, parent: str, child: str) -> str:
    """A launch file that publishes T (4, 4), the frame `child` in `parent`, as static transform."""
    numbers = (*T[:3, 3], *Rotation.from_matrix(T[:3, :3]).as_quat())
    args = " ".join(f"{value:.8f}" for value in numbers)
    return (
        "<launch>\n"
        '  <node pkg="tf2_ros" type="static_transform_publisher" name="camera_calibration"\n'
        f"        args={quoteattr(f'{args} {parent} {child}')}/>\n"
        "</launch>\n"
    )


def as_yaml(result: Calibration, T: np.ndarray, parent: str, child: str) -> str:
    """The transform with what speaks for it."""
    quaternion = Rotation.from_matrix(T[:3, :3]).as_quat()
    held = result.observability
    values = {
        "parent_frame": parent,
        "child_frame": child,
        "translation": {axis: round(float(v), 6) for axis, v in zip("xyz", T[:3, 3])},
        "rotation": {axis: round(float(v), 8) for axis, v in zip("xyzw", quaternion)},
        "rms_mm": round(1e3 * result.rms, 3),
        "inlier_ratio": round(result.inliers, 4),
        "pose_rms_mm": [round(1e3 * one.rms, 3) for one in result.residuals],
        "pose_inlier_ratio": [round(one.inliers, 4) for one in result.residuals],
    }
    spread = result.uncertainty
    if spread is not None:
        values["standard_deviation"] = {
            "translation_mm": round(1e3 * spread.translation, 3),
            "rotation_deg": round(float(np.degrees(spread.rotation)), 4),
            "direction": spread.direction,
        }
    if held is not None:
        values["observability"] = {
            "eigenvalues": [round(float(value), 5) for value in held.eigenvalues],
            "weakest": held.weakest,
        }
    return yaml.safe_dump(values, sort_keys=False)


def folder_for(text: str) -> Path:
    """A folder, made now, that files can be made in.

    Raises:
        InputError: the path is not absolute, or no file can be made there.
    """
    folder = Path(text)
    if not folder.is_absolute():
        raise InputError(f"{text}: must be absolute")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(f"{text}: {error}") from None
    return folder


def write(
    result: Calibration, folder: Path, parent: str, child: str, child_is_optical: bool
) -> list[Path]:
    """camera.yaml, camera.launch and camera.urdf.xml in `folder`.

    Args:
        parent: the robot's root frame.
        child: the camera's frame: the optical one, or the body's (x forward) with the usual turn.

    Raises:
        InputError: there is no result to be written.
        OSError: it cannot be written; then nothing is.
    """
    if result.verdict is not Verdict.OK:
        raise InputError(f"nothing is written: {result.why}")
    T = result.T_root_camera
    T = T if child_is_optical else T @ np.linalg.inv(T_BODY_OPTICAL)
    contents = {
        "camera.yaml": as_yaml(result, T, parent, child),
        "camera.launch": launch(T, parent, child),
        "camera.urdf.xml": origin(T) + "\n",
    }
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder) as made:  # a full disk leaves all or nothing
        for name, text in contents.items():
            Path(made, name).write_text(text)
        for name in contents:
            os.replace(Path(made, name), folder / name)
    return [folder / name for name in contents]
