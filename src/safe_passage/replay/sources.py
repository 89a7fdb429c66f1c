"""Where replayed frames come from: an analytic scene, a PCD file, a folder of RGB + depth."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import cv2
import numpy as np

import safe_passage._person_detection as detection
from safe_passage.core.errors import InputError
from safe_passage.core.reading import read_picture, read_yaml
from safe_passage.replay.virtual_scan import virtual_scan
from safe_passage.simulation.analytic_scene import AnalyticScene

DEFAULT_INTRINSICS = (525.0, 525.0, 319.5, 239.5)  # [px] of the Kinect and its likes
SCAN_BAND = 0.25  # [m] over the lidar's height: what of a cloud counts as met by it


@dataclass(frozen=True)
class Frame:
    """One RGB-D frame and the camera's place over the ground."""

    name: str
    xyz: np.ndarray  # (H, W, 3) float32 [m], optical frame, NaN = no return
    bgr: np.ndarray  # (H, W, 3) uint8
    intrinsics: tuple[float, float, float, float]  # fx, fy, cx, cy [px]
    R_base_camera: np.ndarray  # (3, 3)
    p_base_camera: np.ndarray  # (3,) [m]

    def points_base(self) -> np.ndarray:
        """All points (H * W, 3) [m], x forward, z over the ground."""
        return self.xyz.reshape(-1, 3) @ self.R_base_camera.T + self.p_base_camera

    def half_view(self) -> float:
        """Half of the camera's horizontal field of view [rad], to its narrower side."""
        fx, _, cx, _ = self.intrinsics
        return math.atan(min(cx, self.bgr.shape[1] - 1 - cx) / fx)


@dataclass(frozen=True)
class Lidar:
    """A level scanner looking forward."""

    angles: np.ndarray  # (N,) [rad] of the beams, ascending and evenly spaced
    x: float  # [m] before the base
    z: float  # [m] over the ground
    max_range: float  # [m]


class FrameSource(Protocol):
    """Frames and scans by time [s] since the start."""

    def frame(self, time: float) -> Frame:
        """What the camera sees."""

    def scan(self, lidar: Lidar, frame: Frame, time: float) -> np.ndarray:
        """Ranges (N,) [m] of the lidar's beams; inf = no return, NaN = unknown."""


class SceneSource:
    """The analytic aisle."""

    def __init__(self, scene: AnalyticScene | None = None) -> None:
        self.scene = scene or AnalyticScene()
        camera = self.scene.camera
        self._intrinsics = (
            camera.focal,
            camera.focal,
            (camera.width - 1) / 2,
            (camera.height - 1) / 2,
        )

    def frame(self, time: float) -> Frame:
        depth, bgr = self.scene.render(time)
        camera = self.scene.camera
        place = np.array([0.0, 0.0, camera.z])
        xyz = _from_depth(depth, bgr, self._intrinsics)
        return Frame(f"{time:.1f} s", xyz, bgr, self._intrinsics, camera.rotation(), place)

    def scan(self, lidar: Lidar, frame: Frame, time: float) -> np.ndarray:
        return self.scene.scan(time, lidar.angles, lidar.z, lidar.x, lidar.max_range)


class FileSource:
    """A PCD file, or a folder: `NAME_rgb.png` beside `NAME_depth.png`, one after the other.

    Depth images are 16-bit [mm], or 8-bit with `NAME_depth_params.yaml` (metres = (value - beta) /
    alpha). The folder's `intrinsics.yaml` holds fx, fy, cx, cy [px]; without it: a Kinect's.

    Args:
        path: file or folder.
        seconds_per_frame: [s] how long each frame of a folder is shown.

    Raises:
        InputError: naming the file that cannot be used.
    """

    def __init__(self, path: Path, seconds_per_frame: float = 2.0) -> None:
        self._seconds_per_frame = seconds_per_frame
        if path.is_dir():
            self.files = sorted(path.glob("*_rgb.png"))
            self._intrinsics = _read_intrinsics(path / "intrinsics.yaml")
            if not self.files:
                raise InputError(f"{path}: no *_rgb.png in this folder")
        elif path.is_file():
            self.files = [path]
        else:
            raise InputError(f"{path}: no such file or folder")
        self._index = -1
        self._frame: Frame | None = None

    def frame(self, time: float) -> Frame:
        index = int(time / self._seconds_per_frame) % len(self.files)
        if self._frame is None or index != self._index:
            self._frame = self._load(self.files[index])
            self._index = index
        return self._frame

    def scan(self, lidar: Lidar, frame: Frame, time: float) -> np.ndarray:
        points = frame.points_base() - np.array([lidar.x, 0.0, 0.0])
        return virtual_scan(points, lidar.angles, lidar.z, lidar.z + SCAN_BAND, lidar.max_range)

    def _load(self, file: Path) -> Frame:
        try:
            if file.suffix == ".pcd":
                rgbd = detection.load_pcd(str(file))
            else:
                rgbd = _load_pair(file, self._intrinsics)
        except RuntimeError as error:
            raise InputError(str(error)) from None
        ground = detection.find_ground(rgbd)
        if ground is None:
            raise InputError(f"{file}: no ground plane found")
        camera = rgbd.camera
        intrinsics = (camera.fx, camera.fy, camera.cx, camera.cy)
        place = np.array([0.0, 0.0, ground.offset])
        return Frame(file.stem, rgbd.xyz, rgbd.bgr, intrinsics, _rotation(ground.normal), place)


def _rotation(up: np.ndarray) -> np.ndarray:
    """R_base_camera of a level base frame under the camera, its x along the optical axis."""
    forward = np.array([0.0, 0.0, 1.0])
    x = forward - up * (up @ forward)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(up, x), up])


def _from_depth(
    depth: np.ndarray, bgr: np.ndarray, intrinsics: tuple[float, float, float, float]
) -> np.ndarray:
    return detection.from_depth(depth, bgr, detection.Intrinsics(*intrinsics)).xyz


def _read_intrinsics(file: Path) -> tuple[float, float, float, float]:
    if not file.exists():
        return DEFAULT_INTRINSICS
    values = read_yaml(file)
    try:
        fx, fy, cx, cy = (float(values[name]) for name in ("fx", "fy", "cx", "cy"))
    except (KeyError, OverflowError, TypeError, ValueError):
        raise InputError(f"{file}: needs numbers fx, fy, cx, cy [px]") from None
    if not (np.isfinite([fx, fy, cx, cy]).all() and min(fx, fy) > 0.0):
        raise InputError(f"{file}: fx, fy must be above 0, all finite")
    return fx, fy, cx, cy


def _load_pair(
    rgb_file: Path, intrinsics: tuple[float, float, float, float]
) -> detection.RgbdFrame:
    stem = str(rgb_file)[: -len("_rgb.png")]
    bgr = read_picture(rgb_file, cv2.IMREAD_COLOR)
    raw = read_picture(Path(stem + "_depth.png"))
    if raw.ndim != 2:
        raise InputError(f"{stem}_depth.png: has colours")
    if raw.dtype == np.uint16:
        depth = raw.astype(np.float32) * 1e-3
    else:
        alpha, beta = _read_depth_params(Path(stem + "_depth_params.yaml"))
        depth = (raw.astype(np.float32) - beta) / alpha
    depth[raw == 0] = np.nan
    return detection.from_depth(depth, bgr, detection.Intrinsics(*intrinsics))


def _read_depth_params(file: Path) -> tuple[float, float]:
    if not file.exists():
        raise InputError(f"{file}: missing, so the 8-bit depth image beside it has no scale")
    # OpenCV's yaml dialect, which yaml parsers refuse
    found = dict(re.findall(r"(alpha|beta)\s*:\s*(\S+)", file.read_text(errors="replace")))
    try:
        alpha, beta = float(found["alpha"]), float(found["beta"])
    except (KeyError, ValueError):
        raise InputError(f"{file}: needs numbers alpha and beta") from None
    if not (math.isfinite(alpha) and math.isfinite(beta) and alpha != 0.0):
        raise InputError(f"{file}: alpha must not be 0, both finite")
    return alpha, beta
