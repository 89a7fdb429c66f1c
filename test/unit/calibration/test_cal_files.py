"""Recordings in folders and streams, results as files."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.calibration import Calibration, Verdict
from safe_passage.calibration.quality import Observability, Residual
from safe_passage.calibration.recording import read_folder, standstills
from safe_passage.calibration.writers import (
    T_BODY_OPTICAL,
    folder_for,
    launch,
    origin,
    pose_of,
    write,
)
from safe_passage.core.errors import InputError
from safe_passage.robot_model import JointHistory
from scipy.spatial.transform import Rotation

INFO = "width: 4\nheight: 3\nk: [100.0, 0.0, 1.5, 0.0, 110.0, 1.0, 0.0, 0.0, 1.0]\n"
ANGLES = st.floats(-1.5, 1.5)


def folder_of(tmp_path: Path) -> Path:
    depth = np.full((3, 4), 1.5, np.float32)
    depth[0, 0] = 0.0
    np.save(tmp_path / "depth_0.npy", depth)
    np.save(tmp_path / "joint_states_0.npy", [0.1, 0.2])
    for image, shift in enumerate((0, 2, 100)):
        millimetres = np.full((3, 4), 1500 + shift, np.uint16)
        cv2.imwrite(str(tmp_path / f"depth_1_{image}.png"), millimetres)
    (tmp_path / "joint_states_1.yaml").write_text("b: 0.4\na: 0.3\n")
    (tmp_path / "left_camera_info.yaml").write_text(INFO)
    return tmp_path


def test_a_folder_is_read(tmp_path: Path) -> None:
    recording = read_folder(folder_of(tmp_path), ("a", "b"), 0.5)
    assert (recording.camera.fx, recording.camera.fy, recording.camera.cx) == (100.0, 110.0, 1.5)
    one, two = recording.views
    assert np.isnan(one.depth[0, 0]) and one.depth[1, 1] == 1.5
    assert one.positions == {"a": 0.1, "b": 0.2}
    np.testing.assert_allclose(two.depth, 1.502)  # the median of three images
    assert two.positions == {"a": 0.3, "b": 0.4}


@pytest.mark.parametrize(
    ("file", "content", "says"),
    [
        ("left_camera_info.yaml", None, "one .*camera_info"),
        ("left_camera_info.yaml", "width: 4\nheight: 3\n", "no camera_info"),
        ("left_camera_info.yaml", INFO.replace("4", "5"), "depth images"),
        ("joint_states_0.npy", None, "joint_states_0.npy"),
        ("joint_states_0.npy", "nonsense", "joint_states_0.npy"),
        ("joint_states_1.yaml", "a: high\n", "joint_states_1.yaml.*high"),
        ("depth_1_0.png", "nonsense", "depth_1_0.png"),
    ],
)
def test_what_is_wrong_in_a_folder_is_named(
    tmp_path: Path, file: str, content: str | None, says: str
) -> None:
    folder = folder_of(tmp_path)
    (folder / file).unlink()
    if content is not None:
        (folder / file).write_text(content)
    with pytest.raises(InputError, match=says):
        read_folder(folder, ("a", "b"), 0.5)


def test_an_empty_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no depth_0\.npy"):
        read_folder(tmp_path, ("a",), 0.5)


def test_a_stream_is_cut_into_the_times_that_the_arm_stood() -> None:
    def angle(stamp: float) -> float:  # stands, moves, stands, moves for good
        return float(np.interp(stamp, [0.0, 2.0, 3.0, 5.0, 6.0], [0.0, 0.0, 0.5, 0.5, 1.5]))

    joints = JointHistory(length=100.0)
    for stamp in np.arange(0.0, 6.0, 0.02):
        joints.add(float(stamp), ["a"], [angle(float(stamp))])
    stamps = [float(stamp) for stamp in np.arange(0.05, 7.0, 0.1)]
    depths = [np.full((2, 2), 1.0 + angle(stamp), np.float32) for stamp in stamps]
    found = standstills(stamps, depths, joints, ["a"], 0.5)
    assert [view.positions["a"] for view in found] == pytest.approx([0.0, 0.5])
    assert [float(view.depth[0, 0]) for view in found] == pytest.approx([1.0, 1.5])
    assert standstills(stamps, depths, JointHistory(), ["a"], 0.5) == ()


@given(st.tuples(ANGLES, ANGLES, ANGLES), st.tuples(ANGLES, ANGLES, ANGLES))
def test_the_urdfs_line_and_the_launch_file_say_the_same_pose(
    xyz: tuple[float, ...], rpy: tuple[float, ...]
) -> None:
    T = pose_of([*xyz, *rpy])
    line = ElementTree.fromstring(origin(T))
    again = [float(value) for key in ("xyz", "rpy") for value in line.attrib[key].split()]
    np.testing.assert_allclose(pose_of(again), T, atol=5e-6)
    node = ElementTree.fromstring(launch(T, "base", "camera"))[0]
    *numbers, parent, child = node.attrib["args"].split()
    values = np.array(numbers, float)
    np.testing.assert_allclose(values[:3], T[:3, 3], atol=1e-7)
    np.testing.assert_allclose(Rotation.from_quat(values[3:]).as_matrix(), T[:3, :3], atol=1e-6)
    assert (node.attrib["pkg"], parent, child) == ("tf2_ros", "base", "camera")


def result(verdict: Verdict) -> Calibration:
    held = Observability(np.full(6, 1 / 6), np.eye(6))
    T = pose_of([1.0, 2.0, 0.5, 0.0, 0.3, 1.0]) @ T_BODY_OPTICAL
    pose = Residual(0.004, 0.003, 0.98, 1000)
    return Calibration(verdict, verdict.value, T, np.eye(4), 0.004, 0.98, (pose,), held)


def test_files_are_of_the_cameras_body_or_of_its_optical_frame(tmp_path: Path) -> None:
    write(result(Verdict.OK), tmp_path / "body", "base", "camera_link", False)
    values = yaml.safe_load((tmp_path / "body" / "camera.yaml").read_text())
    assert values["parent_frame"] == "base"
    assert values["translation"] == {"x": 1.0, "y": 2.0, "z": 0.5}
    assert values["rms_mm"] == 4.0
    assert 'rpy="0.000000 0.300000 1.000000"' in (tmp_path / "body" / "camera.urdf.xml").read_text()
    write(result(Verdict.OK), tmp_path / "optical", "base", "optical", True)
    turn = yaml.safe_load((tmp_path / "optical" / "camera.yaml").read_text())["rotation"]
    R = Rotation.from_quat([turn[axis] for axis in "xyzw"]).as_matrix()
    np.testing.assert_allclose(R, result(Verdict.OK).T_root_camera[:3, :3], atol=1e-6)


@pytest.mark.parametrize("verdict", [one for one in Verdict if one is not Verdict.OK])
def test_what_is_no_result_is_not_written(tmp_path: Path, verdict: Verdict) -> None:
    with pytest.raises(InputError, match="nothing is written"):
        write(result(verdict), tmp_path / "out", "base", "camera", True)
    assert not (tmp_path / "out").exists()


def test_a_disk_that_is_full_leaves_no_half_of_a_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written = []

    def write_text(path: Path, text: str) -> None:
        if written:
            raise OSError(28, "No space left on device")
        written.append(path)
        path.write_bytes(text.encode())

    monkeypatch.setattr(Path, "write_text", write_text)
    with pytest.raises(OSError, match="No space"):
        write(result(Verdict.OK), tmp_path / "out", "base", "camera", True)
    assert written
    assert list((tmp_path / "out").iterdir()) == []


def test_a_folder_that_cannot_be_is_named(tmp_path: Path) -> None:
    assert folder_for(str(tmp_path / "a" / "b")).is_dir()
    (tmp_path / "file").write_text("")
    for text, why in (("here", "absolute"), (str(tmp_path / "file"), "file"), ("/proc", "/proc")):
        with pytest.raises(InputError, match=why):
            folder_for(text)
