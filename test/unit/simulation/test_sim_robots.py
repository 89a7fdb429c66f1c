"""Robots of yaml, where their sensors sit, and what is said of a wrong key."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from safe_passage.core.errors import ParameterError
from safe_passage.core.geometry import matrix
from safe_passage.simulation.robots import Robot, load_robot, make_robot
from safe_passage.simulation.scene import Scene
from sim_hall import make_cart, make_hall

ROBOTS = Path(__file__).resolve().parents[3] / "config/robots"


def omnirob() -> Robot:
    return load_robot(ROBOTS / "omnirob.yaml")


def test_summit_xl_is_that_of_the_paper():
    robot = load_robot(ROBOTS / "summit_xl.yaml")
    lidar, camera = robot.lidars[0], robot.cameras[0]
    assert (lidar.beams, lidar.z, lidar.range_max, lidar.rate) == (1081, 0.12, 20.0, 40.0)
    assert np.diff(lidar.angles()) == pytest.approx(math.radians(0.25))
    assert (camera.width, camera.height, camera.z) == (640, 480, 1.63)
    assert not robot.drive.omni and robot.arm is None


def test_omnirob_has_two_lidars_two_cameras_an_arm_and_drives_sideways():
    robot = omnirob()
    assert robot.drive.omni and len(robot.cameras) == 2 and len(robot.arm.joints) == 7
    for lidar in robot.lidars:
        assert np.diff(lidar.angles()) == pytest.approx(math.radians(0.5))
        assert len(lidar.angles()) == 541
    assert robot.without_arm().arm is None and robot.without_arm().lidars == robot.lidars


def test_the_omnirobs_lidars_together_see_all_around_and_not_itself():
    robot = omnirob().without_arm()
    scene = Scene(make_hall(), robot, [])
    scene.settle()
    seen = []
    for lidar in robot.lidars:
        ranges = scene.scan(lidar, np.eye(4)).distances
        T = matrix((lidar.x, lidar.y, lidar.yaw))
        rays = np.stack([np.cos(lidar.angles()), np.sin(lidar.angles())], axis=1)
        seen.append(ranges[:, None] * rays @ T[:2, :2].T + T[:2, 3])
        near = 0.5 * rays @ T[:2, :2].T + T[:2, 3]  # no beam crosses the platform
        assert not (np.abs(near) < (0.6 - 1e-6, 0.36 - 1e-6)).all(axis=1).any()
    scene.close()
    points = np.concatenate(seen)
    bearings = np.sort(np.arctan2(points[:, 1], points[:, 0]))
    gaps = np.diff(np.append(bearings, bearings[0] + 2 * math.pi))
    assert np.degrees(gaps.max()) < 1.0


WRONG = [
    ({"wheels": 4}, "robot/wheels is not known"),
    ({"height": 9.0}, "robot/height is 9.0"),
    ({"footprint": [[0, 0], [1, 0]]}, "footprint: three or more"),
    ({"footprint": [[0, 0], [1, 0], [1]]}, r"footprint\[2\] is \[1\], must hold 2 values"),
    ({"drive": {"omni": 1}}, "robot/drive/omni is 1, must be true or false"),
    ({"drive": {"max_speed": "fast"}}, "robot/drive/max_speed is 'fast', must be a number"),
    ({"lidars": [{"beams": 541.5}]}, r"lidars\[0\]/beams is 541.5, must be a whole number"),
    ({"lidars": [{"range_min": 30.0}]}, r"lidars\[0\]/range_min"),
    ({"lidars": [{}, {}]}, "lidars: two of the same name among laser, laser"),
    ({"cameras": [{"name": "a"}, {"focl": 1}]}, r"cameras\[1\]/focl is not known"),
    ({"cameras": [{"colour_noise": -1}]}, r"cameras\[0\]/colour_noise"),
    ({"cameras": [{}, {}]}, "cameras: two of the same name"),
    ({"parts": [{"colour": [2, 0, 0]}]}, r"parts\[0\]/colour is 2.0"),
    ({"parts": {"x": 0}}, "robot/parts is .*, must be a list"),
    ({"arm": {"x": 0.1}}, "robot/arm: urdf is missing"),
    ({"arm": {"urdf": "a/b", "joints": "all"}}, "robot/arm/joints is 'all', must be a list"),
]


@pytest.mark.parametrize("values, message", WRONG, ids=[str(values) for values, _ in WRONG])
def test_what_is_wrong_is_named(values, message):
    with pytest.raises(ParameterError, match=message):
        make_cart(**values)


@pytest.mark.parametrize("key", ["name", "footprint", "height"])
def test_what_is_missing_is_named(key):
    values = {"name": "a", "footprint": [[1, 0], [0, 1], [-1, 0]], "height": 1.0}
    del values[key]
    with pytest.raises(ParameterError, match=f"robot: {key} is missing"):
        make_robot(values)
