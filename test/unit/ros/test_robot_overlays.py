"""The nodes' parameters in config/robots, over those of config/, as bringup.launch joins them."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Callable, Mapping

import pytest
import yaml
from safe_passage.core.errors import ParameterError
from safe_passage.core.reading import build
from safe_passage.costmap import load_costmap_parameters
from safe_passage.evaluation.human_safety_chain import CLEARANCE
from safe_passage.ros.depth_self_filter_node import SelfFilterNodeParameters
from safe_passage.ros.separation_parameters import make_separation_parameters
from safe_passage.ros.tracker_parameters import make_tracker_parameters
from safe_passage.scan_segmentation.configuration import configuration
from safe_passage.simulation.robot_files import load_robot_file

CONFIG = Path(__file__).parents[3] / "config"
ROBOTS = sorted(path.stem for path in (CONFIG / "robots").glob("*.yaml"))


def overlaid(under: Any, over: Any) -> Any:
    """As roslaunch does it: mappings are merged, all else is replaced."""
    if not isinstance(under, Mapping) or not isinstance(over, Mapping):
        return over
    return {**under, **{key: overlaid(under.get(key), value) for key, value in over.items()}}


def default(stem: str) -> dict[str, Any]:
    return yaml.safe_load((CONFIG / f"{stem}.yaml").read_text())


def overlay(robot: str, node: str) -> Mapping[str, Any]:
    return load_robot_file(CONFIG / f"robots/{robot}.yaml").overlays[node]


def costmap(values: Mapping[str, Any], where: str) -> Any:
    loaded = load_costmap_parameters(values)
    if loaded.warnings:
        raise ParameterError(f"{where}: {loaded.warnings}")
    return loaded.parameters


BUILDERS: dict[str, Callable[[Mapping[str, Any], str], Any]] = {
    "obstacle_tracker": make_tracker_parameters,
    "separation_monitor": make_separation_parameters,
    "depth_self_filter": lambda values, where: build(SelfFilterNodeParameters, values, where),
    "local_costmap": costmap,
}
OTHERS = ("person_detector", "safety_area_merger", "scan_assembler")  # read in C++, or flat


def each(*nodes: str) -> Any:
    """Every robot with each of the nodes of which its file speaks."""
    files = {robot: default(f"robots/{robot}") for robot in ROBOTS}
    pairs = [(robot, node) for robot in ROBOTS for node in nodes if node in files[robot]]
    return pytest.mark.parametrize(("robot", "node"), pairs)


@each("safety_area_merger", "safety_area_merger_rear")
def test_areas_end_at_the_robots_own_outline(robot, node):
    """A strip of cells stays free around it: less could trap it, more it would push along."""
    found = load_robot_file(CONFIG / f"robots/{robot}.yaml")
    told = found.overlays[node]
    assert told["footprint"] == [list(corner) for corner in found.robot.footprint]
    cell = default("local_costmap")["resolution"]
    assert cell <= told["clearance"] < 2 * cell
    assert told["clearance"] == CLEARANCE  # the closed loop judges what ships
    drive = found.robot.drive
    assert told["max_robot_speed"] == drive.max_speed
    assert told["max_robot_turn_rate"] == drive.max_turn_rate


@each(*BUILDERS)
def test_nodes_accept_them(robot, node):
    BUILDERS[node](overlaid(default(node), overlay(robot, node)), f"/{node}")


def test_a_round_robot_says_that_it_has_no_other_footprint():
    told = {"footprint": [], "robot_radius": 0.4}
    values = overlaid(default("separation_monitor"), told)
    assert make_separation_parameters(values, "").robot_radius == 0.4
    with pytest.raises(ParameterError, match="one of the two"):
        make_separation_parameters(
            overlaid(default("separation_monitor"), {"robot_radius": 0.4}), ""
        )


@pytest.mark.parametrize("node", BUILDERS)
def test_a_wrong_key_is_refused_by_its_node(node):
    values = overlaid(default(node), {"footprnt": [[0.0, 1.0]]})
    with pytest.raises(ParameterError, match="footprnt"):
        BUILDERS[node](values, f"/{node}")


@each(*OTHERS)
def test_other_nodes_know_their_keys(robot, node):
    assert set(overlay(robot, node)) <= set(default(node))


@pytest.mark.parametrize("robot", ROBOTS)
def test_segmentation_knows_its_robots(robot):
    values = dict(overlay(robot, "scan_segmentation_server"))
    chosen = values.pop("server", {}).get("robot")
    robots, _ = configuration(values)
    assert chosen is None or chosen in robots
    model = load_robot_file(CONFIG / f"robots/{robot}.yaml").robot
    box = robots[chosen or robot]
    xs, ys = zip(*model.footprint)
    assert max(xs) - min(xs) == pytest.approx(box.length)
    assert max(ys) - min(ys) == pytest.approx(box.width)
    assert box.height == model.height


@pytest.mark.parametrize("robot", ROBOTS)
def test_every_node_has_the_robots_own_footprint_and_sensors(robot):
    found = load_robot_file(CONFIG / f"robots/{robot}.yaml")
    footprint = [list(point) for point in found.robot.footprint]
    for node in ("obstacle_tracker", "separation_monitor", "local_costmap"):
        if node in found.overlays:
            assert found.overlays[node]["footprint"] == footprint, node
    sources = found.overlays.get("obstacle_tracker", {}).get("sources", ())
    sensors = {sensor.name: sensor for sensor in (*found.robot.lidars, *found.robot.cameras)}
    for source in sources:
        sensor = sensors[source["name"]]
        topic = sensor.topic if source["type"] == "LaserScan" else sensor.points
        assert source["topic"] in (topic, "depth_filtered/points"), source["name"]
        assert source["range_max"] <= sensor.range_max


def test_the_summits_tracker_is_that_of_its_own_yaml():
    """obstacle_tracker_single_lidar.yaml is for who runs the tracker alone."""
    told = overlaid(default("obstacle_tracker"), overlay("summit_xl", "obstacle_tracker"))
    alone = default("obstacle_tracker_single_lidar")
    assert make_tracker_parameters(told, "") == make_tracker_parameters(alone, "")


def test_the_lmf_is_that_of_the_segmentations_own_yaml():
    robots, _ = configuration(overlay("lmf", "scan_segmentation_server"))
    assert robots == configuration(default("scan_segmentation"))[0]
