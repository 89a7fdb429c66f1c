"""URDF -> links, joints, poses."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rm_robots import TWO_ARMS, iiwa
from safe_passage.core.errors import InputError
from safe_passage.robot_model import load_robot_model
from safe_passage.robot_model.resources import resolve


def test_links_are_where_the_joints_put_them() -> None:
    robot = load_robot_model(TWO_ARMS, {})
    assert robot.root == "base"
    assert robot.movable == ("shoulder", "rail")
    poses = robot.poses({"shoulder": math.pi / 2, "rail": 0.5, "somebody_elses": 1.0})
    np.testing.assert_allclose(poses["slide"][:3, 3], [0.0, 1.5, 1.0], atol=1e-12)
    turn = math.pi + 0.1  # mimic: 2 * shoulder + 0.1 about the slide's y
    finger = poses["slide"][:3, :3].T @ poses["finger"][:3, :3]
    np.testing.assert_allclose(finger[:, 0], [math.cos(turn), 0.0, -math.sin(turn)], atol=1e-12)


@pytest.mark.parametrize("missing", ["shoulder", "rail"])
def test_a_missing_joint_is_named(missing: str) -> None:
    given = {"shoulder": 0.0, "rail": 0.0}
    del given[missing]
    with pytest.raises(InputError, match=f"joint {missing}: its position is missing"):
        load_robot_model(TWO_ARMS, {}).poses(given)


def test_a_position_that_is_no_number_is_refused() -> None:
    with pytest.raises(InputError, match="joint rail"):
        load_robot_model(TWO_ARMS, {}).poses({"shoulder": 0.0, "rail": math.nan})


def test_joints_beyond_their_limits_are_named() -> None:
    robot = load_robot_model(TWO_ARMS, {})
    assert robot.outside_limits({"shoulder": 1.6, "rail": 0.5}) == ("shoulder",)
    assert robot.outside_limits({"shoulder": 1.5, "rail": 0.6}) == ("rail",)


def test_geometry_is_in_the_links_frame_and_collision_stands_in() -> None:
    links = load_robot_model(TWO_ARMS, {}).links
    np.testing.assert_allclose(links["upper"].vertices.max(axis=0), [1.0, 0.05, 0.05])
    assert len(links["slide"].faces) > 100
    height = links["finger"].vertices[:, 2]
    assert (height.min(), height.max()) == pytest.approx((-0.15, 0.15))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "not a URDF"),
        ("<robot", "not a URDF"),
        ("<sdf/>", "not a URDF"),
        ('<robot name="r"/>', "no link"),
        (TWO_ARMS.replace('<child link="upper"/>', '<child link="away"/>'), "no link away"),
        (TWO_ARMS.replace('<child link="slide"/>', '<child link="upper"/>'), "upper.*two parents"),
        (TWO_ARMS.replace('type="prismatic"', 'type="planar"'), "rail.*planar"),
        (TWO_ARMS.replace('<parent link="base"/>', '<parent link="finger"/>'), "root link|loop"),
        (
            TWO_ARMS.replace(
                '<box size="0.4 0.2 0.1"/>', '<mesh filename="package://gone/a.stl"/>'
            ),
            "link base: package://gone/a.stl: there is no package 'gone'",
        ),
    ],
)
def test_what_cannot_be_used_is_named(text: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        load_robot_model(text, {})


def test_uris(tmp_path: Path) -> None:
    mesh = tmp_path / "a mesh.stl"
    mesh.touch()
    quoted = str(mesh).replace(" ", "%20")
    for uri in ("package://mine/a%20mesh.stl", f"file://{quoted}", str(mesh), "a mesh.stl"):
        assert resolve(uri, tmp_path, {"mine": tmp_path}) == mesh
    with pytest.raises(InputError, match="without a folder"):
        resolve("a mesh.stl", None, {})
    with pytest.raises(InputError, match="only package"):
        resolve("http://somewhere/a.stl", None, {})
    with pytest.raises(InputError, match="there is no file"):
        resolve("package://mine/b.stl", None, {"mine": tmp_path})


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(-2.0, 2.0), min_size=7, max_size=7))
def test_the_iiwa_stands_where_mujoco_puts_it(positions: list[float]) -> None:
    robot = load_robot_model(iiwa(), {})
    model = mujoco.MjModel.from_xml_path(str(iiwa()))
    data = mujoco.MjData(model)
    for name, position in zip(robot.movable, positions):
        data.qpos[model.joint(name).qposadr[0]] = position
    mujoco.mj_kinematics(model, data)
    poses = robot.poses(dict(zip(robot.movable, positions)))
    for name in ("lbr_iiwa_link_3", "lbr_iiwa_link_7"):
        np.testing.assert_allclose(poses[name][:3, 3], data.body(name).xpos, atol=1e-6)
        np.testing.assert_allclose(poses[name][:3, :3].ravel(), data.body(name).xmat, atol=1e-6)
