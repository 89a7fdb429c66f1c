"""Views with their truth as files, and back.

A folder of `NAME_rgb.png`, `NAME_depth.png` (16-bit [mm], 0: no return), `NAME_scan.npz` and, when
wanted, `NAME_cloud.pcd`; `intrinsics.yaml` (fx, fy, cx, cy [px]); `truth.json`: who is where in
each view; `dataset.yaml`: what made it. Any program that reads RGB + depth folders can replay it.
"""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator

import cv2
import numpy as np
import yaml

from safe_passage.core.errors import InputError
from safe_passage.core.reading import build, build_list, read_picture, read_yaml
from safe_passage.evaluation.parallel import Workers, batches, run_jobs
from safe_passage.evaluation.report import plain
from safe_passage.evaluation.setting import Setting
from safe_passage.evaluation.views import View, ViewSampler
from safe_passage.simulation.robots import CameraModel, LidarModel
from safe_passage.simulation.truth import PersonTruth

FORMAT = "safe_passage views 1"


@dataclass(frozen=True)
class Batch:
    """Views to be drawn and written."""

    setting: Setting
    numbers: range
    folder: Path
    clouds: bool


class Dataset:
    """A folder of views, read as they are asked for.

    Raises:
        InputError: naming the file that is missing or damaged.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        file = folder / "dataset.yaml"
        self.about = read_yaml(file)
        if self.about.get("format") != FORMAT:
            raise InputError(f"{file}: its format is not {FORMAT!r}")
        self.camera = build(CameraModel, self.about.get("camera"), f"{file}: camera")
        self.lidar = build(LidarModel, self.about.get("lidar"), f"{file}: lidar")
        self._truth = _read_truth(folder / "truth.json")

    def __len__(self) -> int:
        return len(self._truth)

    def __iter__(self) -> Iterator[View]:
        return (self[i] for i in range(len(self)))

    def __getitem__(self, index: int) -> View:
        truth = self._truth[index]
        stem = str(self.folder / truth.name)
        bgr = read_picture(Path(stem + "_rgb.png"), cv2.IMREAD_COLOR)
        millimetres = read_picture(Path(stem + "_depth.png"))
        if millimetres.dtype != np.uint16 or millimetres.ndim != 2:
            raise InputError(f"{stem}_depth.png: must have 16 bits [mm]")
        depth = millimetres.astype(np.float32) * 1e-3
        depth[millimetres == 0] = np.nan
        ranges, persons = _read_scan(Path(stem + "_scan.npz"))
        pose = np.array(truth.T_map_camera)
        return View(bgr, depth, ranges, persons, truth.persons, truth.robot, pose)


@dataclass(frozen=True)
class _Truth:
    """Of one view."""

    name: str  # of its files
    robot: tuple[float, float, float]  # [m], [rad]
    T_map_camera: np.ndarray  # (4, 4)
    persons: tuple[PersonTruth, ...]


def write_dataset(
    folder: Path, setting: Setting, first: int, count: int, clouds: bool, workers: Workers
) -> None:
    """Draw the views `first` to `first + count - 1` into `folder`, which must be new or empty.

    Raises:
        InputError: the folder holds something, or cannot be written.
    """
    world, robot = setting.load()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise InputError(f"{folder}: is not empty")
        camera, lidar = robot.cameras[0], robot.lidars[0]
        intrinsics = dict(zip(("fx", "fy", "cx", "cy"), map(float, camera.intrinsics)))
        (folder / "intrinsics.yaml").write_text(yaml.safe_dump(intrinsics, sort_keys=False))
        jobs = [Batch(setting, part, folder, clouds) for part in batches(first, count)]
        truth = [entry for part in run_jobs(_write_batch, jobs, workers, "views") for entry in part]
        (folder / "truth.json").write_text(json.dumps(plain(truth)) + "\n")
        about = {
            "format": FORMAT,
            "world": world.name,
            "robot": robot.name,
            "first": first,
            "count": count,
            "camera": dataclasses.asdict(camera),
            "lidar": dataclasses.asdict(lidar),
        }
        (folder / "dataset.yaml").write_text(yaml.safe_dump(about, sort_keys=False))
    except OSError as error:
        raise InputError(f"{folder}: {error}") from None


def _write_batch(batch: Batch) -> list[dict[str, Any]]:
    sampler = ViewSampler(*batch.setting.load())
    try:
        return [_write(sampler.draw(n), f"{n:07d}", sampler.camera, batch) for n in batch.numbers]
    finally:
        sampler.close()


def _write(view: View, name: str, camera: CameraModel, batch: Batch) -> dict[str, Any]:
    """One view's files; returns its truth."""
    stem = str(batch.folder / name)
    millimetres = np.rint(np.nan_to_num(view.depth, nan=0.0) * 1e3).astype(np.uint16)
    written = cv2.imwrite(stem + "_rgb.png", view.bgr)
    written &= cv2.imwrite(stem + "_depth.png", millimetres)
    if not written:
        raise InputError(f"{stem}: cannot be written")
    np.savez_compressed(stem + "_scan.npz", ranges=view.ranges, persons=view.beam_persons)
    if batch.clouds:
        write_pcd(Path(stem + "_cloud.pcd"), view, camera)
    return {
        "name": name,
        "robot": view.pose,
        "T_map_camera": view.T_map_camera,
        "persons": [dataclasses.asdict(person) for person in view.persons],
    }


def write_pcd(file: Path, view: View, camera: CameraModel) -> None:
    """An organised cloud in the optical frame, x, y, z [m] and packed rgb; PCD 0.7, binary."""
    height, width = view.depth.shape
    fx, fy, cx, cy = camera.intrinsics
    columns, rows = np.arange(width) - cx, np.arange(height)[:, None] - cy
    cloud = np.empty((height, width), [("xyz", "<f4", 3), ("rgb", "<u4")])
    cloud["xyz"] = np.stack([view.depth * columns / fx, view.depth * rows / fy, view.depth], -1)
    blue, green, red = np.moveaxis(view.bgr.astype(np.uint32), -1, 0)
    cloud["rgb"] = red << 16 | green << 8 | blue
    header = (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb\n"
        "SIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\n"
        f"WIDTH {width}\nHEIGHT {height}\nVIEWPOINT 0 0 0 1 0 0 0\n"
        f"POINTS {width * height}\nDATA binary\n"
    )
    file.write_bytes(header.encode() + cloud.tobytes())


def _read_truth(file: Path) -> list[_Truth]:
    try:
        entries = json.loads(file.read_text())
        return [_to_truth(entry, f"{file}: view {i}") for i, entry in enumerate(entries)]
    except OSError as error:
        raise InputError(f"{file}: {error.strerror}") from None
    except (KeyError, OverflowError, RecursionError, TypeError, ValueError) as error:
        raise InputError(f"{file}: no truth of views ({error or type(error).__name__})") from None


def _to_truth(entry: dict[str, Any], where: str) -> _Truth:
    x, y, yaw = map(float, entry["robot"])
    pose = np.array(entry["T_map_camera"], float).reshape(4, 4)
    persons = build_list(PersonTruth, entry["persons"], where)
    return _Truth(str(entry["name"]), (x, y, yaw), pose, persons)


def _read_scan(file: Path) -> tuple[np.ndarray, np.ndarray]:
    try:
        with np.load(file) as scan:
            return scan["ranges"], scan["persons"]
    except Exception as error:  # what zipfile, zlib and python's parser raise, numpy passes on
        raise InputError(f"{file}: no scan ({error})") from None
