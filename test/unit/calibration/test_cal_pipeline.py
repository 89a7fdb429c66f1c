"""A small robot of boxes before a camera without noise: the camera's pose is found, or refused."""

from __future__ import annotations

import numpy as np
import pytest
from box_arm import ARM, CAMERA, POSES, off
from box_arm import T_ROOT_CAMERA as T_TRUE
from safe_passage.calibration import (
    ArmCalibrator,
    ArmView,
    CalibrationParameters,
    Verdict,
    pipeline,
)
from safe_passage.calibration.arm_surface import ArmSurface
from safe_passage.calibration.registration import register
from safe_passage.robot_model import RobotModel, load_robot_model
from scipy.spatial.transform import Rotation

POLE = """<robot name="pole">
  <link name="foot"/>
  <link name="pole">
    <visual><geometry><cylinder radius="0.1" length="0.8"/></geometry></visual>
  </link>
  <joint name="a" type="continuous">
    <parent link="foot"/><child link="pole"/><axis xyz="0 0 1"/></joint>
</robot>"""


def views(model: RobotModel, joints: list[dict[str, float]]) -> list[ArmView]:
    """The arm before a wall far behind."""
    surface = ArmSurface(model, CAMERA)
    depths = [surface.depth(q, T_TRUE) for q in joints]
    return [ArmView(np.minimum(d, np.float32(3.0)), q) for d, q in zip(depths, joints)]


JOINTS = [{"a": a, "b": b} for a, b in POSES[:3]]


def test_the_cameras_pose_is_found_from_a_bad_guess() -> None:
    model = load_robot_model(ARM, {})
    calibrator = ArmCalibrator(model, CAMERA, CalibrationParameters())
    result = calibrator.calibrate(views(model, JOINTS), off(T_TRUE, 0.08, 8.0))
    assert result.verdict is Verdict.OK, result.why
    np.testing.assert_allclose(result.T_root_camera[:3, 3], T_TRUE[:3, 3], atol=2e-3)
    turn = Rotation.from_matrix(T_TRUE[:3, :3].T @ result.T_root_camera[:3, :3]).magnitude()
    assert turn < np.radians(0.2)
    np.testing.assert_allclose(result.T_align @ result.T_initial, result.T_root_camera, atol=1e-9)
    assert len(result.residuals) == 3
    assert max(one.rms for one in result.residuals) < 4e-3
    assert result.inliers > 0.95
    held_out = calibrator.evaluate(views(model, [{"a": 0.9, "b": 0.1}]), result.T_root_camera)
    assert held_out[0].rms < 4e-3


def test_a_round_pole_leaves_its_axis_undetermined() -> None:
    model = load_robot_model(POLE, {})
    result = ArmCalibrator(model, CAMERA, CalibrationParameters()).calibrate(
        views(model, [{"a": 0.0}]), off(T_TRUE, 0.01, 1.0)
    )
    assert result.verdict in (Verdict.UNOBSERVABLE, Verdict.NOT_CONVERGED)
    assert result.observability is not None
    assert "turn about z" in result.observability.weakest
    assert "shift in z" not in result.observability.weakest


def test_an_arm_that_is_elsewhere_is_no_result() -> None:
    """The joints are not those that the picture was taken with."""
    model = load_robot_model(ARM, {})
    seen = views(model, JOINTS)
    wrong = [ArmView(view.depth, q) for view, q in zip(seen, JOINTS[1:] + JOINTS[:1])]
    result = ArmCalibrator(model, CAMERA, CalibrationParameters()).calibrate(
        wrong, off(T_TRUE, 0.02, 2.0)
    )
    assert result.verdict is not Verdict.OK
    assert result.verdict.value in result.why


@pytest.mark.parametrize("depth", [np.nan, 3.0, 0.0])
def test_an_arm_that_is_not_seen_is_no_result(depth: float) -> None:
    model = load_robot_model(ARM, {})
    nothing = [ArmView(np.full((240, 320), depth, np.float32), q) for q in JOINTS]
    result = ArmCalibrator(model, CAMERA, CalibrationParameters()).calibrate(nothing, T_TRUE)
    assert result.verdict is Verdict.NOT_SEEN
    assert "points" in result.why


def test_a_guess_that_looks_away_is_no_result() -> None:
    model = load_robot_model(ARM, {})
    away = T_TRUE @ np.diag([-1.0, 1.0, -1.0, 1.0])
    result = ArmCalibrator(model, CAMERA, CalibrationParameters()).calibrate(
        views(model, JOINTS), away
    )
    assert result.verdict is not Verdict.OK


def test_it_can_be_given_up_between_registrations(monkeypatch: pytest.MonkeyPatch) -> None:
    class GivenUpError(Exception):
        """By who asked for it."""

    model, registrations, asked = load_robot_model(ARM, {}), [], []
    monkeypatch.setattr(
        pipeline, "register", lambda *given: (registrations.append(given), register(*given))[1]
    )

    def check() -> None:
        asked.append(len(registrations))
        if len(asked) == 5:
            raise GivenUpError

    calibrator = ArmCalibrator(model, CAMERA, CalibrationParameters())
    with pytest.raises(GivenUpError):
        calibrator.calibrate(views(model, JOINTS), off(T_TRUE, 0.05, 5.0), check)
    assert asked == [0, 1, 2, 3, 4]  # once for each registration
    assert len(registrations) == 4


def test_poses_that_disagree_are_no_result() -> None:
    """An encoder that is off by two degrees in one pose: points still lie near the model."""
    model = load_robot_model(ARM, {})
    joints = [{"a": a, "b": b} for a, b in POSES[:4]]
    seen = views(model, joints)
    calibrator = ArmCalibrator(model, CAMERA, CalibrationParameters())
    right = calibrator.calibrate(seen, off(T_TRUE, 0.02, 2.0))
    assert right.verdict is Verdict.OK, right.why
    assert right.uncertainty is not None
    assert right.uncertainty.translation < 0.001
    seen[2] = ArmView(seen[2].depth, {**joints[2], "a": joints[2]["a"] + np.radians(2.0)})
    wrong = calibrator.calibrate(seen, off(T_TRUE, 0.02, 2.0))
    assert wrong.verdict is Verdict.UNCERTAIN, wrong.why
    assert "allowed" in wrong.why
    assert "shift in" in wrong.why
    loose = ArmCalibrator(
        model, CAMERA, CalibrationParameters(most_translation=1.0, most_rotation=1.0)
    )
    assert loose.calibrate(seen, off(T_TRUE, 0.02, 2.0)).verdict is Verdict.OK


def test_one_pose_has_nothing_that_could_disagree() -> None:
    model = load_robot_model(ARM, {})
    calibrator = ArmCalibrator(model, CAMERA, CalibrationParameters())
    result = calibrator.calibrate(views(model, JOINTS[1:2]), off(T_TRUE, 0.02, 2.0))
    assert result.uncertainty is None
    assert "unknown" in result.why
