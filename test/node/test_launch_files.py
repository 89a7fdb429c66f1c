#!/usr/bin/env python3
"""Every launch file loads, its switches on or off, and its nodes accept their yaml."""

import itertools
import sys
import tempfile
import threading
import unittest
from pathlib import Path

import rosgraph
import roslaunch
import roslaunch.arg_dump
import roslaunch.rlutil
import rospkg
import rospy
import rostest
from leg_models import make_leg_model
from node_testing import wait_until
from roslib.packages import find_node
from safe_passage.costmap import load_costmap_parameters

PACKAGE = Path(rospkg.RosPack().get_path("safe_passage"))
LAUNCH_FILES = sorted(PACKAGE.glob("launch/*.launch"))
OWN_PACKAGES = {"safe_passage", "rviz"}
NOT_OUTPUT = {"/rosout", "/rosout_agg", "/diagnostics"}
VARIANTS = [  # with which arguments each file is started; by default as it is, without rviz
    ("person_detector", ["method:=yolo", "input:=depth"]),
    ("human_safety", ["tracker:=true"]),
    *(
        ("obstacle_tracker", [f"config:={PACKAGE}/config/obstacle_tracker_{robot}.yaml"])
        for robot in ("single_lidar", "lidar3d")
    ),
    *((path.stem, []) for path in LAUNCH_FILES),
]


def arguments_of(path):
    """Name -> (doc, default) of a launch file's arguments."""
    return roslaunch.arg_dump.get_args([str(path)])


def load(path, arguments=()):
    """The launch file, as roslaunch reads it; fails where roslaunch would."""
    return roslaunch.config.load_config_default([(str(path), list(arguments))], None, verbose=False)


def parameters_under(config, namespace):
    """A nested dictionary of the parameters that a launch file sets below `namespace`."""
    found = {}
    for name, parameter in config.params.items():
        if not name.startswith(namespace + "/"):
            continue
        *path, last = name[len(namespace) + 1 :].split("/")
        place = found
        for step in path:
            place = place.setdefault(step, {})
        place[last] = parameter.value
    return found


def problem_with(node):
    """What keeps a node from starting; empty: nothing."""
    if node.package not in OWN_PACKAGES:
        return f"package {node.package} is not of this package's set-up"
    if not find_node(node.package, node.type):
        return f"no program {node.type} in {node.package}"
    words = node.args.split()
    views = [words[i + 1] for i, word in enumerate(words) if word == "-d"]
    return ", ".join(f"{view} does not exist" for view in views if not Path(view).is_file())


class LaunchFilesTest(unittest.TestCase):
    """Without subTest: rosunit counts what fails in one, but does not say what."""

    def test_1_there_are_launch_files(self):
        self.assertGreater(len(LAUNCH_FILES), 0, PACKAGE)

    def test_2_roslaunch_check_finds_nothing(self):
        for path in LAUNCH_FILES:
            self.assertIsNone(roslaunch.rlutil.check_roslaunch(str(path)), path)

    def test_2_every_argument_is_explained_and_names_files_that_exist(self):
        for path in LAUNCH_FILES:
            for name, (doc, default) in arguments_of(path).items():
                self.assertTrue(doc, f"{path}: {name}")
                if default and default.startswith("/"):
                    self.assertTrue(Path(default).exists(), f"{path}: {name} = {default}")

    def test_2_every_switch_on_and_off(self):
        for path in LAUNCH_FILES:
            switches = [
                name
                for name, (_, default) in arguments_of(path).items()
                if default in ("true", "false")
            ]
            for values in itertools.product(("true", "false"), repeat=len(switches)):
                arguments = [f"{name}:={value}" for name, value in zip(switches, values)]
                config = load(path, arguments)
                problems = config.config_errors + [problem_with(node) for node in config.nodes]
                self.assertFalse(any(problems), f"{path} {arguments}: {problems}")

    def test_3_costmaps_know_every_key(self):
        costmaps = {
            "local_costmap": ["/local_costmap"],
            "human_safety": ["/local_costmap"],
            "navigation": ["/move_base/local_costmap", "/move_base/global_costmap"],
        }
        for stem, namespaces in costmaps.items():
            config = load(PACKAGE / "launch" / f"{stem}.launch")
            for namespace in namespaces:
                parameters = parameters_under(config, namespace)
                self.assertIn("obstacle_layer", parameters)
                warnings = load_costmap_parameters(parameters).warnings
                # The map's layer is for the real move_base alone.
                strange = [w for w in warnings if "costmap_2d::StaticLayer" not in w]
                self.assertEqual(strange, [], f"{stem}: {namespace}")

    def test_4_nodes_start_with_their_yaml(self):
        with tempfile.TemporaryDirectory() as folder:
            needed = {"leg_detector": [f"model:={make_leg_model(folder)}"]}  # none is shipped
            for stem, extra in VARIANTS:
                path = PACKAGE / "launch" / f"{stem}.launch"
                off = ["rviz:=false"] if "rviz" in arguments_of(path) else []
                self.start_and_stop(path, [*extra, *needed.get(stem, []), *off])

    def start_and_stop(self, path, arguments):
        nodes = [node.namespace + node.name for node in load(path, arguments).nodes]
        self.assertGreater(len(nodes), 0)
        died = []
        listener = Listener(died)
        launched = roslaunch.parent.ROSLaunchParent(
            rospy.get_param("/run_id"),
            [(str(path), arguments)],
            is_core=False,
            process_listeners=[listener],
        )
        launched.start(auto_terminate=False)
        try:
            wait_until(
                listener.news,
                lambda: died or all(map(has_output, nodes)),
                f"the outputs of {nodes} of {path}",
                lambda: None,
            )
            self.assertEqual(died, [], path)
        finally:
            launched.shutdown()
        for node in nodes:
            if rospy.has_param(node):
                rospy.delete_param(node)


class Listener(roslaunch.pmon.ProcessListener):
    """Notes the processes that end."""

    def __init__(self, died):
        self.news = threading.Condition()
        self._died = died

    def process_died(self, process_name, exit_code):
        with self.news:
            self._died.append((process_name, exit_code))
            self.news.notify_all()


def has_output(node):
    """Nodes advertise what they publish once their parameters are accepted."""
    publishers, _, _ = rosgraph.Master(rospy.get_name()).getSystemState()
    return any(node in nodes and topic not in NOT_OUTPUT for topic, nodes in publishers)


if __name__ == "__main__":
    rospy.init_node("test_launch_files")
    rostest.rosrun("safe_passage", "test_launch_files", LaunchFilesTest, sys.argv)
