"""Files of config/robots: what the robot is, and what its nodes are told."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from safe_passage.core.errors import InputError, ParameterError
from safe_passage.simulation.robot_files import NODES, RobotFile, load_robot_file, main
from safe_passage.simulation.robots import load_robot
from safe_passage.simulation.simulator import Simulator
from sim_hall import make_hall

ROBOTS = sorted((Path(__file__).resolve().parents[3] / "config/robots").glob("*.yaml"))
SQUARE = [[0.3, 0.3], [-0.3, 0.3], [-0.3, -0.3], [0.3, -0.3]]
ROBOT = {"name": "cart", "footprint": SQUARE, "height": 1.0}
TOLD = {
    "obstacle_tracker": {"footprint": SQUARE, "sources": [{"name": "laser"}]},
    "separation_monitor": {"footprint": SQUARE, "reaction_time": 0.3, "deceleration": 0.5},
}


def write(folder: Path, **keys) -> Path:
    path = folder / "cart.yaml"
    path.write_text(yaml.safe_dump({"robot": ROBOT, **keys}))
    return path


def read(path: Path) -> RobotFile:
    return load_robot_file(path)


@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.stem)
def test_shipped_files_are_of_the_robot_they_are_called_after(path):
    assert read(path).robot.name == path.stem
    assert load_robot(path) == read(path).robot


def test_overlays_come_by_node(tmp_path):
    found = read(write(tmp_path, **TOLD))
    assert found.overlays == TOLD
    assert found.robot.name == "cart" and found.robot.lidars == ()


WRONG = [
    ({"obstacle_traker": {"rate": 1.0}}, "cart.yaml: obstacle_traker is no node of bringup.launch"),
    ({"footprint": SQUARE}, "footprint is no node"),
    ({"local_costmap": None}, "local_costmap is None, must be a mapping"),
    ({"local_costmap": {}}, "local_costmap is {}, must be a mapping"),
    ({"local_costmap": [1]}, "local_costmap is .*, must be a mapping"),
    ({"robot": {**ROBOT, "wheels": 4}}, "cart.yaml: robot/wheels is not known"),
    ({"robot": None}, "cart.yaml: robot is None, must be a mapping"),
    ({"robot": {**ROBOT, "scanners": [{"rate": 0}]}}, r"scanners\[0\]/rate is 0"),
    ({"robot": {**ROBOT, "scanners": [{}, {}]}}, "scanners: two of the same name"),
]


@pytest.mark.parametrize("keys, message", WRONG, ids=[str(keys) for keys, _ in WRONG])
def test_what_is_wrong_is_named(tmp_path, keys, message):
    with pytest.raises(ParameterError, match=message):
        read(write(tmp_path, **keys))


def test_a_file_of_the_robot_alone_says_where_the_robot_belongs(tmp_path):
    path = tmp_path / "old.yaml"
    path.write_text(yaml.safe_dump(ROBOT))
    with pytest.raises(ParameterError, match="old.yaml: robot is missing"):
        load_robot(path)


def test_what_another_robot_would_lend_is_missed(tmp_path):
    found = read(write(tmp_path, **TOLD))
    assert found.lacks(["obstacle_tracker", "separation_monitor", "person_detector"]) == []
    assert found.lacks(["local_costmap"]) == ["local_costmap/footprint"]
    without = read(write(tmp_path, obstacle_tracker={"rate": 10.0}))
    assert without.lacks(["obstacle_tracker"]) == [
        "obstacle_tracker/footprint",
        "obstacle_tracker/sources",
    ]


@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.stem)
def test_shipped_files_lack_nothing_that_they_speak_of(path):
    found = read(path)
    assert found.lacks(list(found.overlays)) == []


def test_check_robot_says_what_is_missing_for_what_runs(tmp_path, capsys):
    path = str(write(tmp_path, **TOLD))
    assert main([path]) == 0 and "cart: all well" in capsys.readouterr().out
    assert main([path, "obstacle_tracker:=True", "local_costmap:=False"]) == 0
    assert main([path, "local_costmap:=true", "obstacle_tracker:=1"]) == 1
    said = capsys.readouterr().err
    assert "local_costmap/footprint must be said" in said and "obstacle_tracker" not in said
    assert main([str(tmp_path / "none.yaml")]) == 1 and "none.yaml" in capsys.readouterr().err


def test_check_robot_says_which_nodes_would_have_nothing_to_do(tmp_path, capsys):
    path = str(write(tmp_path, robot={**ROBOT, "lidars": [{}]}))
    switches = ["safety_area_merger:=true", "person_detector:=true", "depth_self_filter:=false"]
    assert main([path, *switches]) == 0
    said = capsys.readouterr().err
    assert "no cameras in its key robot: person_detector:=false leaves" in said
    assert "safety_area_merger" not in said and "depth_self_filter" not in said


@pytest.mark.parametrize("arguments", [[], ["a.yaml", "wheels:=true"], ["a.yaml", "move_base"]])
def test_check_robot_explains_itself(arguments, capsys):
    assert main(arguments) == 2
    said = capsys.readouterr().err
    assert all(node in said for node in NODES)


def test_topics_are_the_usual_ones_unless_told(tmp_path):
    sensors = {
        "lidars": [{"name": "a"}, {"name": "b"}, {"name": "c", "topic": "other"}],
        "cameras": [{"name": "d"}, {"name": "e", "points": "cloud"}],
    }
    robot = read(write(tmp_path, robot={**ROBOT, **sensors})).robot
    assert [lidar.topic for lidar in robot.lidars] == ["scan", "b/scan", "other"]
    assert robot.cameras[0].points == "depth_registered/points"
    assert robot.cameras[1].points == "cloud"
    assert robot.cameras[1].camera_info == "e/rgb/camera_info"


def test_a_turning_scanner_is_not_simulated_and_it_says_what_is():
    robot = load_robot(next(path for path in ROBOTS if path.stem == "lmf"))
    with pytest.raises(InputError, match=r"lmf: turning scanners \(rosi\) .* replay_scan"):
        Simulator(make_hall(), robot, people=())
