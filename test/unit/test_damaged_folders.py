"""Recordings of several files, one of them damaged: a result, or an error of ours that names it."""

from __future__ import annotations

import dataclasses
import io
import json
import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from damage import FEW, damaged
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.calibration.recording import read_folder
from safe_passage.core.errors import InputError, SafePassageError
from safe_passage.core.reading import read_yaml
from safe_passage.evaluation.dataset import FORMAT, Dataset
from safe_passage.replay.sources import FileSource
from safe_passage.simulation.robots import CameraModel, LidarModel


def png(image: np.ndarray) -> bytes:
    return cv2.imencode(".png", image)[1].tobytes()


def npy(array: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def npz(**arrays: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def replayed(folder: Path):
    return FileSource(folder).frame(0.0)


def floor() -> np.ndarray:
    """Depth (60, 80) [m] of a floor 1 m below a camera that looks 15 degrees down; 0: too far."""
    rows = (np.arange(60.0) - 29.5) / 60.0
    down = np.cos(np.radians(15.0)) * rows + np.sin(np.radians(15.0))
    return np.repeat(np.where(down > 0.2, 1.0 / np.maximum(down, 0.2), 0.0)[:, None], 80, axis=1)


DEPTH = np.full((3, 4), 1500, np.uint16)
INFO = b"width: 4\nheight: 3\nk: [100.0, 0.0, 1.5, 0.0, 110.0, 1.0, 0.0, 0.0, 1.0]\n"
PERSON = {
    "id": 1, "body": "tall_man", "position": [1.0, 0.0], "velocity": [0.0, 0.0], "distance": 1.0,
    "box": [0.0, 0.0, 1.0, 1.0], "visible": 1.0,
}  # fmt: skip
VIEW = {
    "name": "0",
    "robot": [0.0, 0.0, 0.0],
    "T_map_camera": np.eye(4).tolist(),
    "persons": [PERSON],
}
ABOUT = {
    "format": FORMAT,
    "camera": dataclasses.asdict(CameraModel()),
    "lidar": dataclasses.asdict(LidarModel()),
}
FOLDERS = {
    "arm": (
        lambda folder: read_folder(folder, ("a", "b"), 0.5),
        {
            "depth_0.npy": npy(DEPTH.astype(np.float32) * np.float32(1e-3)),
            "depth_1_0.png": png(DEPTH),
            "joint_states_0.npy": npy(np.array([0.1, 0.2])),
            "joint_states_1.yaml": b"b: 0.4\na: 0.3\n",
            "left_camera_info.yaml": INFO,
        },
    ),
    "replay": (
        replayed,
        {
            "a_rgb.png": png(np.full((60, 80, 3), 90, np.uint8)),
            "a_depth.png": png(np.rint(floor() * 40.0).astype(np.uint8)),
            "a_depth_params.yaml": b"%YAML:1.0\nalpha: 4.0e+01\nbeta: 0.\n",
            "intrinsics.yaml": b"{fx: 60.0, fy: 60, cx: 39.5, cy: 29.5}",
        },
    ),
    "views": (
        lambda folder: list(Dataset(folder)),
        {
            "dataset.yaml": yaml.safe_dump(ABOUT).encode(),
            "truth.json": json.dumps([VIEW]).encode(),
            "0_rgb.png": png(np.zeros((3, 4, 3), np.uint8)),
            "0_depth.png": png(DEPTH),
            "0_scan.npz": npz(ranges=np.ones(5), persons=np.zeros(5, int)),
        },
    ),
}


def write(folder: Path, kind: str) -> Path:
    for name, content in FOLDERS[kind][1].items():
        (folder / name).write_bytes(content)
    return folder


@pytest.mark.parametrize("kind", sorted(FOLDERS))
def test_what_is_whole_is_read(tmp_path, kind):
    assert FOLDERS[kind][0](write(tmp_path, kind))


@pytest.mark.parametrize("kind", sorted(FOLDERS))
@FEW
@given(data=st.data())
def test_one_file_is_damaged(tmp_path, kind, data):
    load, files = FOLDERS[kind]
    name = data.draw(st.sampled_from(sorted(files)))
    (write(tmp_path, kind) / name).write_bytes(damaged(data, files[name]))
    try:
        load(tmp_path)
    except SafePassageError as error:
        assert str(tmp_path) in str(error)


def header(shape: str, kind: str = "<f4") -> bytes:
    """Of an .npy file, as numpy writes it."""
    said = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(said)) + said


@pytest.mark.parametrize(
    "content",
    [
        header("(3, 4"),  # python's tokenizer gives up on it
        header("(99999999999, 99999)"),
        header("(3, 4)", "<c8") + bytes(96),
        header("(3, 4)", "<U1") + bytes(48),
        npz(depth=np.ones((3, 4))),  # np.load looks into a file for what it is
    ],
)
@pytest.mark.parametrize("file", ["depth_0.npy", "joint_states_0.npy"])
def test_arrays_that_are_none_are_named(tmp_path, file, content):
    (write(tmp_path, "arm") / file).write_bytes(content)
    with pytest.raises(InputError, match=file):
        read_folder(tmp_path, ("a", "b"), 0.5)


def test_pictures_of_more_pixels_than_opencv_reads_are_named(tmp_path):
    """It throws, where it says nothing of other damage."""

    def chunk(kind: bytes, body: bytes) -> bytes:
        crc = zlib.crc32(kind + body)
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", crc)

    head = chunk(b"IHDR", struct.pack(">2I5B", 10**6, 10**6, 16, 0, 0, 0, 0))
    huge = b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")
    for kind, file in (("arm", "depth_1_0.png"), ("replay", "a_depth.png"), ("views", "0_rgb.png")):
        folder = tmp_path / kind
        folder.mkdir()
        (write(folder, kind) / file).write_bytes(huge)
        with pytest.raises(InputError, match=file):
            FOLDERS[kind][0](folder)


@pytest.mark.parametrize(
    "file, content",
    [
        ("intrinsics.yaml", b"{fx: 1, "),
        ("intrinsics.yaml", b"\xff\xfe\xfa"),
        ("intrinsics.yaml", b"{fx: .nan, fy: 60, cx: 39.5, cy: 29.5}"),
        ("intrinsics.yaml", b"{fx: 0.0, fy: 60, cx: 39.5, cy: 29.5}"),
        ("a_depth_params.yaml", b"alpha: 4.0.0\nbeta: 35."),
        ("a_depth_params.yaml", b"alpha: 0.0\nbeta: 35."),
        ("a_depth_params.yaml", b"alpha: 1.0\nbeta: \xff"),
        ("a_depth.png", png(np.zeros((60, 80, 3), np.uint8))),
    ],
)
def test_a_camera_that_is_none_is_named(tmp_path, file, content):
    (write(tmp_path, "replay") / file).write_bytes(content)
    with pytest.raises(InputError, match=file):
        replayed(tmp_path)


@pytest.mark.parametrize(
    "text", ["a: 2001-99-99", "a: !!int ''", "a: !!timestamp x", "a: !!bool x", "[" * 5000]
)
def test_yaml_that_python_cannot_make_is_named(tmp_path, text):
    """PyYAML passes on what python's constructors raise, and its own recursion."""
    (tmp_path / "some.yaml").write_text(text)
    with pytest.raises(InputError, match="some.yaml"):
        read_yaml(tmp_path / "some.yaml")
