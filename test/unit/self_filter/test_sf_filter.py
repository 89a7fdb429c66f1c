"""A robot of two bars before a wall: which pixels go, which stay."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from safe_passage.core.depth_image import metres, without
from safe_passage.core.errors import InputError, ParameterError
from safe_passage.robot_model import DepthRenderer, JointHistory, PinholeCamera, load_robot_model
from safe_passage.robot_model.surfaces import box
from safe_passage.self_filter import SelfFilter, SelfFilterParameters

CAMERA = PinholeCamera(160, 120, 130.0, 130.0, 79.5, 59.5)
BAR = """<robot name="bar">
  <link name="post"><visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual></link>
  <link name="bar">
    <visual><origin xyz="0.25 0 0"/><geometry><box size="0.5 0.06 0.06"/></geometry></visual>
  </link>
  <joint name="turn" type="continuous">
    <parent link="post"/><child link="bar"/><axis xyz="0 0 1"/>
  </joint>
</robot>"""
MODEL = load_robot_model(BAR, {})
T_CAMERA_ROOT = np.eye(4)  # the bar turns in the picture's plane, a metre away
T_CAMERA_ROOT[2, 3] = 1.0
WALL = 2.0  # [m]


def still(angle: float = 0.0, rate: float = 0.0, until: float = 0.1) -> JointHistory:
    joints = JointHistory(tolerance=0.05)
    for stamp in np.arange(-0.1, until + 1e-9, 0.01):
        joints.add(float(stamp), ["turn"], [angle + rate * float(stamp)])
    return joints


def seen(angle: float, things: dict[tuple[float, ...], np.ndarray] | None = None) -> np.ndarray:
    """The true depth image with a wall, and boxes by size at places."""
    poses = MODEL.poses({"turn": angle})
    surfaces, places = list(MODEL.links.values()), [T_CAMERA_ROOT @ T for T in poses.values()]
    for size, place in (things or {}).items():
        surfaces.append(box(np.array(size)))
        T = np.eye(4)
        T[:3, 3] = place
        places.append(T)
    front, _ = DepthRenderer(surfaces, CAMERA).depths(np.stack(places)[None])
    return np.minimum(front, np.float32(WALL))


def make(**parameters: object) -> SelfFilter:
    return SelfFilter(MODEL, CAMERA, SelfFilterParameters(**parameters))  # type: ignore[arg-type]


@settings(max_examples=15, deadline=None)
@given(st.floats(-math.pi, math.pi))
def test_the_robot_goes_and_the_wall_stays(angle: float) -> None:
    depth = seen(angle)
    filtered = make().filter(depth, 0.0, still(angle), T_CAMERA_ROOT)
    assert filtered.removed[depth < WALL].all()
    assert filtered.removed[depth == WALL].sum() <= 3  # in notches, like mixed pixels
    assert np.isnan(filtered.depth[depth < WALL]).all()
    np.testing.assert_array_equal(filtered.cloud()[:, 2], WALL)


def test_both_encodings_say_no_depth_in_their_own_way() -> None:
    depth = seen(0.3)
    depth[0, :5] = np.nan
    millimetres = np.nan_to_num(1000.0 * depth).astype(np.uint16)
    whole = make().filter(depth, 0.0, still(0.3), T_CAMERA_ROOT)
    short = make().filter(millimetres, 0.0, still(0.3), T_CAMERA_ROOT)
    assert whole.image.dtype == np.float32
    assert short.image.dtype == np.uint16
    np.testing.assert_array_equal(np.isnan(whole.image), short.image == 0)
    assert not whole.removed[0, :5].any()
    assert not np.isnan(depth[60, 90])  # what came is left as it was


@pytest.mark.parametrize("gap", [0.08, 0.3])
def test_a_hand_before_the_arm_stays_and_so_does_a_person_behind_it(gap: float) -> None:
    hand = {(0.1, 0.05, 0.02): np.array([0.25, 0.0, 1.0 - 0.03 - gap])}
    person = {(1.0, 1.0, 0.02): np.array([0.0, 0.0, 1.0 + 0.05 + gap])}
    for things in (hand, person):
        depth = seen(0.0, things)
        mine = seen(0.0)
        theirs = (depth < mine) & (depth < WALL)
        filtered = make().filter(depth, 0.0, still(), T_CAMERA_ROOT)
        assert theirs.sum() > 50
        assert not filtered.removed[theirs].any()


@settings(max_examples=15, deadline=None)
@given(st.floats(-1.0, 1.0), st.floats(-0.015, 0.015))
def test_a_moving_arm_goes_wherever_it_was_within_the_time_uncertainty(
    rate: float, late: float
) -> None:
    depth = seen(rate * late)
    filtered = make(time_uncertainty=0.015).filter(depth, 0.0, still(0.0, rate), T_CAMERA_ROOT)
    assert filtered.removed[depth < WALL].all()


def test_a_fast_arm_leaves_no_gap_on_its_way() -> None:
    filtered = make(time_uncertainty=0.05, padding=0.0, edge=0)
    for late in np.linspace(-0.05, 0.05, 9):
        depth = seen(8.0 * late)
        joints = still(0.0, 8.0)
        assert (
            filtered.filter(depth, 0.0, joints, T_CAMERA_ROOT).removed[depth < WALL].mean() > 0.99
        )


def test_joint_states_that_end_at_the_stamp_go_on_as_they_went() -> None:
    depth = seen(0.015)  # the arm 15 ms later
    thin = make(padding=0.0, edge=0, mesh_resolution=0.0)
    known = thin.filter(depth, 0.0, still(0.0, 1.0, until=0.1), T_CAMERA_ROOT)
    mirrored = thin.filter(depth, 0.0, still(0.0, 1.0, until=0.0), T_CAMERA_ROOT)
    np.testing.assert_array_equal(known.removed, mirrored.removed)


def test_mixed_pixels_at_the_rim_go_and_a_finger_before_the_arm_stays() -> None:
    depth = seen(0.0)
    rim = 60 + round(0.03 / 0.97 * 130) + 2
    for i, column in enumerate(range(95, 130, 2)):  # between the bar, 0.97 m, and the wall, 2 m
        depth[rim, column] = 1.3 + 0.15 * (i % 4)
    finger = seen(0.0)
    finger[rim, 95:130:2] = 0.6
    removed = make().filter(depth, 0.0, still(), T_CAMERA_ROOT).removed
    unasked = make(sliver_support=0).filter(depth, 0.0, still(), T_CAMERA_ROOT).removed
    assert removed[rim, 95:130:2].all()
    assert not unasked[rim, 95:130:2].any()
    assert not make().filter(finger, 0.0, still(), T_CAMERA_ROOT).removed[rim, 95:130:2].any()


def test_links_may_be_left_in_or_padded_more() -> None:
    depth = seen(0.0)
    depth[depth >= WALL] = 1.0  # a sheet through the robot's middle
    plain = make(edge=0).filter(depth, 0.0, still(), T_CAMERA_ROOT).removed
    more = (
        make(edge=0, link_padding={"bar": 0.1}).filter(depth, 0.0, still(), T_CAMERA_ROOT).removed
    )
    none = make(edge=0, excluded_links=("bar",)).filter(depth, 0.0, still(), T_CAMERA_ROOT).removed
    assert (more[:, 110].sum() - plain[:, 110].sum()) / 130.0 == pytest.approx(0.16, abs=0.03)
    assert plain[60, 130] and not none[60, 130] and none[60, 80]


def test_wrong_names_and_values_are_named() -> None:
    with pytest.raises(ParameterError, match="link gripper"):
        make(excluded_links=("gripper",))
    with pytest.raises(ParameterError, match="link gripper"):
        make(link_padding={"gripper": 0.1})
    with pytest.raises(InputError, match="no link is left"):
        make(excluded_links=("post", "bar"))
    for bad in (
        {"padding": -1.0},
        {"edge": 99},
        {"link_padding": {"bar": math.nan}},
        {"time_uncertainty": 0.4, "joint_tolerance": 0.1},
    ):
        with pytest.raises(ParameterError):
            make(**bad)


def test_nothing_passes_where_something_is_not_known() -> None:
    depth, plain = seen(0.0), make()
    with pytest.raises(InputError, match="joint turn: no state"):
        plain.filter(depth, 0.0, plain.joint_history(), T_CAMERA_ROOT)
    with pytest.raises(InputError, match="before the stamp"):
        plain.filter(depth, 5.0, still(), T_CAMERA_ROOT)
    with pytest.raises(InputError, match="depth image 80 x 60"):
        plain.filter(depth[::2, ::2], 0.0, still(), T_CAMERA_ROOT)
    with pytest.raises(InputError, match="not finite"):
        plain.filter(depth, 0.0, still(), np.full((4, 4), np.nan))
    with pytest.raises(InputError, match="16UC1 or 32FC1"):
        plain.filter(depth.astype(np.float64), 0.0, still(), T_CAMERA_ROOT)


def test_depths_that_are_none_are_nan_in_metres() -> None:
    image = np.array([[0, 1500]], np.uint16)
    np.testing.assert_allclose(metres(image), [[np.nan, 1.5]])
    odd = np.array([[np.inf, -np.inf, np.nan, 0.0, -1.0, 2.0]], np.float32)
    np.testing.assert_allclose(metres(odd), [[np.nan] * 5 + [2.0]])
    np.testing.assert_array_equal(without(image, image > 0), [[0, 0]])
