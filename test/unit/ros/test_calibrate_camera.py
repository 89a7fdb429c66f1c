"""calibrate_camera: a folder in, files out; or a verdict, a picture, and exit status 1."""

import sys

import numpy as np
import pytest
import yaml
from box_arm import ARM, CAMERA, POSES, T_ROOT_CAMERA
from safe_passage.calibration.arm_surface import ArmSurface
from safe_passage.core.errors import InputError
from safe_passage.robot_model import load_robot_model
from safe_passage.ros.calibrate_camera import main
from scipy.spatial.transform import Rotation

INFO = {"width": 320, "height": 240, "k": [260.0, 0, 159.5, 0, 260.0, 119.5, 0, 0, 1]}


@pytest.fixture
def recording(tmp_path):
    """Three poses of the arm, without noise."""
    (tmp_path / "arm.urdf").write_text(ARM)
    surface = ArmSurface(load_robot_model(ARM, {}), CAMERA)
    for pose, (a, b) in enumerate(POSES[:3]):
        depth = surface.depth({"a": a, "b": b}, T_ROOT_CAMERA)
        np.save(tmp_path / f"depth_{pose}.npy", np.minimum(depth, np.float32(3.0)))
        np.save(tmp_path / f"joint_states_{pose}.npy", [a, b])
    (tmp_path / "camera_info.yaml").write_text(yaml.safe_dump(INFO))
    return tmp_path


def calibrate(monkeypatch, folder, guess, *more):
    numbers = [str(value) for value in guess]
    arguments = [str(folder), "--urdf", str(folder / "arm.urdf"), "--output", str(folder / "out")]
    monkeypatch.setattr(sys, "argv", ["calibrate_camera", *arguments, "--guess", *numbers, *more])
    main()


def test_the_cameras_pose_is_written(monkeypatch, recording):
    rpy = Rotation.from_matrix(T_ROOT_CAMERA[:3, :3]).as_euler("xyz")
    guess = [*(T_ROOT_CAMERA[:3, 3] + [0.05, -0.03, 0.04]), *(rpy + 0.05)]
    calibrate(monkeypatch, recording, guess, "--optical", "--child", "camera_optical")
    written = {path.name for path in (recording / "out").iterdir()}
    assert written == {"camera.yaml", "camera.launch", "camera.urdf.xml", "camera.png"}
    values = yaml.safe_load((recording / "out" / "camera.yaml").read_text())
    assert (values["parent_frame"], values["child_frame"]) == ("foot", "camera_optical")
    place = [values["translation"][axis] for axis in "xyz"]
    np.testing.assert_allclose(place, T_ROOT_CAMERA[:3, 3], atol=3e-3)


def test_a_guess_that_looks_away_leaves_but_a_picture(monkeypatch, recording, capsys):
    with pytest.raises(SystemExit) as end:
        calibrate(monkeypatch, recording, [1.2, 0.5, 0.9, 0.0, 0.0, 0.0])
    assert end.value.code == 1
    assert [path.name for path in (recording / "out").iterdir()] == ["camera.png"]
    assert "no result" in capsys.readouterr().err


def test_what_is_wrong_is_named(monkeypatch, recording):
    with pytest.raises(InputError, match="must be NAME=FOLDER"):
        calibrate(monkeypatch, recording, [0.0] * 6, "--package", "lbr_description")
    (recording / "p.yaml").write_text("methods: GICP\n")
    with pytest.raises(Exception, match="methods is not known"):
        calibrate(monkeypatch, recording, [0.0] * 6, "--parameters", str(recording / "p.yaml"))
    with pytest.raises(InputError, match="no_such"):
        calibrate(monkeypatch, recording / "no_such", [0.0] * 6)
