"""An arm on a robot: found, moved, seen by cameras and not by lidars."""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path

import numpy as np
import pytest
from safe_passage.core.errors import InputError, ParameterError
from safe_passage.simulation.arms import find_urdf, read_description
from safe_passage.simulation.robots import ArmModel, load_robot
from safe_passage.simulation.simulator import Simulator
from sim_hall import make_cart, make_hall

LINK = """<link name="{0}"><inertial><mass value="0"/>
<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial><collision>
<origin xyz="{1} 0 0"/><geometry><box size="{2} 0.1 0.1"/></geometry></collision></link>"""
JOINT = """<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/>
<origin xyz="{3} 0 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/>
</joint>"""
URDF = (
    '<robot name="two">'
    + LINK.format("root", 0.0, 0.1)
    + LINK.format("upper", 0.25, 0.5)
    + LINK.format("fore", 0.2, 0.4)
    + JOINT.format("shoulder", "root", "upper", 0.0)
    + JOINT.format("elbow", "upper", "fore", 0.5)
    + "</robot>"
)


@pytest.fixture()
def urdf(tmp_path) -> str:
    path = tmp_path / "two.urdf"
    path.write_text(URDF)
    return str(path)


def with_arm(urdf: str, **values):
    """A cart with an arm over its deck, and a camera that looks straight down on it."""
    camera = {"z": 2.6, "pitch": 0.5 * math.pi, "focal": 100.0, "width": 160, "height": 120}
    arm = {"urdf": urdf, "z": 0.7, **values}
    robot = make_cart(cameras=[camera], arm=arm)
    return Simulator(make_hall(), robot, people=())


def hand(sim: Simulator) -> np.ndarray:
    """Where the camera sees the arm's tip, (2,) [m] in base_footprint."""
    camera = sim.robot.cameras[0]
    depth = sim.frame(camera).exact
    v, u = np.nonzero(depth < 2.2)
    z = depth[v, u]
    fx, fy, cx, cy = camera.intrinsics
    x, y = -(v - cy) / fy * z, -(u - cx) / fx * z  # up in the picture is ahead
    far = np.argmax(np.hypot(x, y))
    return np.array([x[far], y[far]])


def test_joints_start_where_told_and_move(urdf):
    sim = with_arm(urdf, positions=[0.5 * math.pi, 0.0])
    assert sim.joint_names == ("shoulder", "elbow")
    assert sim.arm_positions == pytest.approx([0.5 * math.pi, 0.0])
    assert hand(sim) == pytest.approx([0.0, 0.9], abs=0.08)
    sim.arm_positions = [0.0, 0.0]
    assert hand(sim) == pytest.approx([0.9, 0.0], abs=0.08)
    sim.arm_positions = [0.0, 0.5 * math.pi]
    assert hand(sim) == pytest.approx([0.5, 0.4], abs=0.09)
    sim.restart()
    assert sim.arm_positions == pytest.approx([0.5 * math.pi, 0.0])
    sim.close()


def test_the_arm_goes_with_the_robot_and_its_place_on_it(urdf):
    sim = with_arm(urdf, x=-0.1, yaw=0.5 * math.pi)
    assert hand(sim) == pytest.approx([-0.1, 0.9], abs=0.08)
    sim.base.pose = (2.0, 1.0, 0.4)
    sim.step()
    assert hand(sim) == pytest.approx([-0.1, 0.9], abs=0.08)
    sim.close()


def test_joints_are_in_the_order_of_the_yaml(urdf):
    sim = with_arm(urdf, joints=["elbow", "shoulder"])
    sim.arm_positions = [0.0, 0.5 * math.pi]
    assert sim.joint_names == ("elbow", "shoulder")
    assert hand(sim) == pytest.approx([0.0, 0.9], abs=0.08)
    sim.close()


def test_lidars_do_not_see_the_arm(urdf):
    low_arm = with_arm(urdf, z=0.2)
    bare = Simulator(make_hall(), make_cart(), people=())
    lidar = low_arm.robot.lidars[0]
    assert np.array_equal(low_arm.scan(lidar).exact, bare.scan(lidar).exact)
    low_arm.close()
    bare.close()


@pytest.mark.parametrize("wrong", [[0.0], [0.0, math.nan], 0.0, [[0.0, 0.0]]])
def test_positions_that_do_not_fit_are_refused(urdf, wrong):
    sim = with_arm(urdf)
    with pytest.raises(ValueError, match="must be 2 finite angles"):
        sim.arm_positions = wrong
    sim.close()


def test_without_an_arm_there_are_no_joints():
    sim = Simulator(make_hall(), make_cart(), people=())
    assert sim.joint_names == () and sim.arm_positions.shape == (0,)
    sim.close()


def test_a_joint_that_the_urdf_has_not_is_named(urdf):
    with pytest.raises(ParameterError, match="arm/joints: wrist is not one of shoulder, elbow"):
        with_arm(urdf, joints=["wrist"])
    with pytest.raises(ParameterError, match="arm/positions: 1 for 2 joints"):
        with_arm(urdf, positions=[0.0])


def test_a_missing_package_is_named_with_the_parameter_and_the_remedy():
    with pytest.raises(InputError, match="arm/urdf is 'no_such/a.urdf'.*no Python package"):
        find_urdf("no_such/a.urdf")
    with pytest.raises(InputError, match="arm/urdf is 'safe_passage/no.urdf'.*no file"):
        find_urdf("safe_passage/no.urdf")
    with pytest.raises(InputError, match="arm/urdf is '/no/such.urdf'.*no file"):
        find_urdf("/no/such.urdf")


def test_a_package_is_found_and_not_imported(tmp_path, monkeypatch):
    (tmp_path / "arm_data/kuka").mkdir(parents=True)
    (tmp_path / "arm_data/__init__.py").write_text("raise RuntimeError('imported')")
    (tmp_path / "arm_data/kuka/model.urdf").write_text(URDF)
    monkeypatch.syspath_prepend(tmp_path)
    assert find_urdf("arm_data/kuka/model.urdf") == tmp_path / "arm_data/kuka/model.urdf"


@pytest.mark.parametrize("content", ["", "<robot", "<mujoco><worldbody/></mujoco>"])
def test_a_file_that_is_no_arm_is_named(tmp_path, content):
    path = tmp_path / "broken.urdf"
    path.write_text(content)
    with pytest.raises(InputError, match=r"broken\.urdf"):
        with_arm(str(path))


@pytest.mark.skipif(not importlib.util.find_spec("pybullet_data"), reason="pybullet is not here")
def test_the_iiwa_of_the_omnirob_reaches_up_and_is_seen_by_the_front_camera():
    robot = load_robot(Path(__file__).resolve().parents[3] / "config/robots/omnirob.yaml")
    sim = Simulator(make_hall(), robot, people=())
    bare = Simulator(make_hall(), robot.without_arm(), people=())
    assert len(sim.joint_names) == 7
    front = robot.cameras[0]
    nearer = sim.frame(front).exact < bare.frame(front).exact - 0.1
    assert 0.05 < nearer.mean() < 0.5
    sim.arm_positions = np.zeros(7)  # upright: 1.27 m from its root to the flange's axis
    sim.scan(robot.lidars[0])
    tip = sim.scene.data.body("arm/lbr_iiwa_link_7").xpos
    assert tip == pytest.approx([0.28, 0.0, 0.70 + 1.261], abs=0.02)
    sim.close()
    bare.close()


def test_a_description_says_where_its_meshes_are_and_what_carries_it(tmp_path):
    box = '<geometry><box size="0.4 0.1 0.1"/></geometry>'
    mesh = '<geometry><mesh filename="fore.obj"/></geometry>'
    path = tmp_path / "two.urdf"
    path.write_text(URDF.replace(box, mesh))
    found = read_description(ArmModel(str(path)))
    assert found.root == "root"
    assert f'filename="file://{tmp_path}/fore.obj"' in found.urdf


@pytest.mark.parametrize("text", ["<robot", "<robot name='none'/>", URDF.replace("joint", "j")])
def test_a_description_that_is_no_tree_is_refused(tmp_path, text):
    path = tmp_path / "broken.urdf"
    path.write_text(text.replace("<child", "<infant"))
    with pytest.raises(InputError, match="broken.urdf"):
        read_description(ArmModel(str(path)))
