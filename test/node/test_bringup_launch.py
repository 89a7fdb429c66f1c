#!/usr/bin/env python3
"""bringup.launch, as roslaunch reads it: which nodes, with which parameters."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import roslaunch
import rospkg
import rostest
import yaml
from safe_passage.simulation.robot_files import NODES

PACKAGE = Path(rospkg.RosPack().get_path("safe_passage"))
BRINGUP = str(PACKAGE / "launch/bringup.launch")
MONITORING = {"obstacle_tracker", "separation_monitor"}
HUMAN_SAFETY = {"person_detector", "safety_area_merger", "local_costmap"}
OMNIROB = MONITORING | HUMAN_SAFETY | {"depth_self_filter", "safety_area_merger_rear"}
SEGMENTATION = {"scan_assembler", "scan_segmentation_server"}
BY_DEFAULT = {
    "summit_xl": MONITORING | HUMAN_SAFETY,
    "omnirob": OMNIROB,
    "lmf": SEGMENTATION,
}
OWN_FOOTPRINT = [[0.2, 0.2], [-0.2, 0.2], [-0.2, -0.2], [0.2, -0.2]]


def load(*arguments, file=BRINGUP):
    """The launch file, as roslaunch reads it; fails where roslaunch would."""
    return roslaunch.config.load_config_default([(file, list(arguments))], None, verbose=False)


def names(config, namespace="/"):
    return {node.name for node in config.nodes if node.namespace == namespace}


def parameter(config, name):
    return config.params[name].value


class LaunchTest(unittest.TestCase):
    def test_robots_have_the_nodes_that_suit_them(self):
        for robot, nodes in BY_DEFAULT.items():
            config = load(f"robot:={robot}")
            self.assertEqual(names(config), nodes, robot)
            self.assertEqual(told_to_run(config), nodes, robot)
            self.assertEqual(config.config_errors, [], robot)

    def test_every_node_can_be_left_out(self):
        for node in OMNIROB:
            self.assertEqual(names(load("robot:=omnirob", f"{node}:=false")), OMNIROB - {node})
        self.assertEqual(
            names(load("robot:=lmf", "scan_assembler:=false")), {"scan_segmentation_server"}
        )
        self.assertEqual(names(load("robot:=lmf", "scan_segmentation:=false")), set())

    def test_what_is_on_demand_comes_on_demand(self):
        config = load("scan_segmentation:=true", "navigation:=true", "simulate:=true", "rviz:=true")
        self.assertEqual(
            names(config),
            (
                BY_DEFAULT["summit_xl"]
                | SEGMENTATION
                | {"move_base", "warehouse_sim", "overview_rviz"}
            )
            - {"local_costmap"},
        )
        (planner,) = (node for node in config.nodes if node.name == "move_base")
        self.assertEqual(dict(planner.remap_args)["cmd_vel"], "cmd_vel_raw")

    def test_files_speak_of_the_nodes_that_there_are(self):
        started = set()
        for robot in BY_DEFAULT:
            started |= names(load(f"robot:={robot}", "navigation:=true", "scan_segmentation:=true"))
            started |= names(load(f"robot:={robot}"))
        self.assertEqual(started, set(NODES))

    def test_the_robots_yaml_wins(self):
        config = load("robot:=summit_xl")
        self.assertEqual(parameter(config, "/person_detector/input"), "depth")  # launch file: cloud
        self.assertEqual(parameter(config, "/obstacle_tracker/resolution"), 0.08)  # yaml: 0.12
        (source,) = parameter(config, "/obstacle_tracker/sources")  # a list is replaced
        self.assertEqual(source["name"], "laser")
        self.assertEqual(parameter(config, "/obstacle_tracker/radius"), 12.0)  # not touched
        self.assertEqual(parameter(config, "/robot/name"), "summit_xl")

    def test_segmentation_knows_no_other_robots_configurations(self):
        config = load("robot:=summit_xl", "scan_segmentation:=true")
        prefix = "/scan_segmentation_server/robots/"
        known = {
            key[len(prefix) :].split("/")[0] for key in config.params if key.startswith(prefix)
        }
        self.assertEqual(known, {"summit_xl"})

    def test_without_self_filter_the_tracker_reads_the_camera_itself(self):
        (tracker,) = (n for n in load("robot:=omnirob").nodes if n.name == "obstacle_tracker")
        self.assertNotIn("depth_filtered/points", dict(tracker.remap_args))
        config = load("robot:=omnirob", "depth_self_filter:=false")
        (tracker,) = (node for node in config.nodes if node.name == "obstacle_tracker")
        self.assertEqual(
            dict(tracker.remap_args)["depth_filtered/points"], "depth_registered/points"
        )

    def test_a_robot_may_be_a_path(self):
        with tempfile.TemporaryDirectory() as folder:
            path = own_robot(folder)
            config = load(f"robot:={path}")
            self.assertEqual(parameter(config, "/separation_monitor/footprint"), OWN_FOOTPRINT)
            self.assertEqual(parameter(config, "/bringup/robot_file"), str(path))

    def test_what_cannot_be_started_is_refused_before(self):
        with tempfile.TemporaryDirectory() as folder:
            for change, said in (
                ({"obstacle_traker": {"rate": 1.0}}, "obstacle_traker is no node"),
                ({"separation_monitor": {"reaction_time": 0.3}}, "separation_monitor/footprint"),
                ({"robot": {"name": "x"}}, "footprint is missing"),
            ):
                self.assertIn(said, output_of_roslaunch(own_robot(folder, **change)))
            self.assertIn("none.yaml", output_of_roslaunch(Path(folder) / "none.yaml"))

    def test_two_robots_on_one_master(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "two.launch"
            file.write_text(TWO_ROBOTS)
            config = load(file=str(file))
        self.assertEqual(config.config_errors, [])
        self.assertEqual(names(config, "/robot1/"), BY_DEFAULT["summit_xl"])
        self.assertEqual(names(config, "/robot2/"), OMNIROB)
        self.assertEqual(names(config), set())
        outside = [key for key in config.params if not key.startswith(("/robot1/", "/robot2/"))]
        self.assertEqual([key for key in outside if not key.startswith(("/ros", "/run"))], [])
        for i, robot in ((1, "summit_xl"), (2, "omnirob")):
            self.assertEqual(parameter(config, f"/robot{i}/robot/name"), robot)
            for name in ("obstacle_tracker/base_frame", "separation_monitor/base_frame"):
                self.assertEqual(parameter(config, f"/robot{i}/{name}"), f"robot{i}/base_footprint")
            self.assertEqual(
                parameter(config, f"/robot{i}/local_costmap/global_frame"), f"robot{i}/odom"
            )
            for node in config.nodes:
                absolute = [pair for pair in node.remap_args if pair[1].startswith("/")]
                self.assertEqual(absolute, [], node.name)

    def test_two_hosts(self):
        file = str(PACKAGE / "launch/examples/two_hosts.launch")
        for robot, there in (
            ("summit_xl", {"person_detector"}),
            ("omnirob", {"person_detector", "depth_self_filter"}),
        ):
            config = roslaunch.config.load_config_default(
                [(file, [f"robot:={robot}", "camera_host:=camera"])],
                None,
                verbose=False,
                assign_machines=False,  # there is no such host
            )
            self.assertEqual(config.config_errors, [])
            self.assertEqual(names(config), BY_DEFAULT[robot])
            away = {node.name for node in config.nodes if node.machine_name == "camera_host"}
            self.assertEqual(away, there)
            self.assertEqual(told_to_run(config), BY_DEFAULT[robot])
            (tracker,) = (node for node in config.nodes if node.name == "obstacle_tracker")
            remapped = dict(tracker.remap_args).get("depth_filtered/points")
            self.assertEqual(remapped, "depth_filtered/points")


def told_to_run(config):
    """The nodes of which tools are told that they should run."""
    prefix = "/bringup/nodes/"
    return {key[len(prefix) :] for key in config.params if key.startswith(prefix)}


TWO_ROBOTS = """<launch>
  <group ns="robot1">
    <include file="$(find safe_passage)/launch/bringup.launch">
      <arg name="robot" value="summit_xl"/> <arg name="frame_prefix" value="robot1/"/>
    </include>
  </group>
  <group ns="robot2">
    <include file="$(find safe_passage)/launch/bringup.launch">
      <arg name="robot" value="omnirob"/> <arg name="frame_prefix" value="robot2/"/>
    </include>
  </group>
</launch>"""


def own_robot(folder, **change):
    """A robot's file, changed in these keys."""
    footprint = {"footprint": OWN_FOOTPRINT}
    values = {
        "robot": {"name": "own", "height": 1.0, **footprint},
        "obstacle_tracker": {**footprint, "sources": [{"name": "laser", "topic": "scan"}]},
        "separation_monitor": {**footprint, "reaction_time": 0.4, "deceleration": 0.5},
        "local_costmap": footprint,
        **change,
    }
    path = Path(folder) / "own.yaml"
    path.write_text(yaml.safe_dump(values))
    return path


def output_of_roslaunch(robot):
    """What is said where bringup.launch is refused."""
    done = subprocess.run(
        ["roslaunch", "--nodes", BRINGUP, f"robot:={robot}"],
        capture_output=True,
        text=True,
        timeout=20.0,
    )
    if done.returncode == 0:
        raise AssertionError(f"not refused: {done.stdout}")
    return done.stdout + done.stderr


if __name__ == "__main__":
    rostest.rosrun("safe_passage", "test_bringup_launch", LaunchTest, sys.argv)
