"""launch/examples/two_hosts.launch over two addresses, and what clocks that differ do to it.

The camera's computer: a camera, a second lidar, person_detector. All else is on the other one.
"""

from __future__ import annotations

import json
import math
import re
import subprocess
import threading
from pathlib import Path

import numpy as np
import pytest
import rosgraph
import rospy
import yaml
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from node_testing import TIMEOUT, CostmapView, Diagnostics, wait_until
from roslib.packages import find_node
from safe_passage.doctor.checks import Severity
from safe_passage.msg import PersonArray, SeparationState
from sensor_msgs.msg import LaserScan
from two_hosts import HERE, THERE, NoNamespacesError, TwoHosts

EXAMPLE = Path(__file__).parents[2] / "launch/examples/two_hosts.launch"
SKEW = 3.0  # [s] more than any node forgives
STANDING, LASER = np.array([3.2, 0.95]), np.array([0.2, 0.0])  # [m] of the aisle, of the robot
RADIUS = 1.2  # [m] config/safety_area_merger.yaml
TO_STANDING = STANDING - LASER
DISTANCE = np.linalg.norm(TO_STANDING)
NEAR_POINT = LASER + TO_STANDING * (1.0 - RADIUS / DISTANCE)  # of the circle
SPEED = 0.1  # [m/s] that is wanted
FOOTPRINT = [[0.3, 0.25], [-0.3, 0.25], [-0.3, -0.25], [0.3, -0.25]]
SCANS = {"there/scan": "laser_there", "scan": "laser_here"}
ROBOT = {
    "robot": {
        "name": "two computers",
        "footprint": FOOTPRINT,
        "height": 1.7,
        "lidars": [
            {"name": name, "frame": "laser", "topic": topic, "x": 0.2, "rate": 10.0}
            for topic, name in SCANS.items()
        ],
        "cameras": [{"name": "camera", "pitch": 0.17, "rate": 4.0}],
    },
    "obstacle_tracker": {
        "footprint": FOOTPRINT,
        "sources": [
            {"name": name, "topic": topic, "range_min": 0.1, "timeout": 1.0}
            for topic, name in SCANS.items()
        ],
    },
    "separation_monitor": {"footprint": FOOTPRINT, "reaction_time": 0.5, "deceleration": 0.6},
    "person_detector": {"input": "depth"},
    "local_costmap": {"footprint": FOOTPRINT},
}
LAUNCH = f"""<launch>
  <node pkg="safe_passage" type="replay_camera" name="base_driver">
    <param name="scan_rate" value="10"/> <param name="rate" value="0.1"/>
    <remap from="rgb/image_rect_color" to="unused/image"/>
    <remap from="rgb/camera_info" to="unused/camera_info"/>
    <remap from="depth_registered/image_rect" to="unused/depth"/>
  </node>
  <include file="{EXAMPLE}">
    <arg name="robot" value="$(arg robot)"/> <arg name="env_loader" value="$(arg env_loader)"/>
    <arg name="camera_host" value="{THERE}"/> <arg name="camera_user" value="root"/>
  </include>
  <node pkg="safe_passage" type="replay_camera" name="camera_driver" machine="camera_host">
    <param name="scan_rate" value="10"/> <param name="rate" value="4"/>
    <remap from="scan" to="there/scan"/> <remap from="/tf" to="there/tf"/>
  </node>
  <arg name="robot"/> <arg name="env_loader"/>
</launch>"""


class Robot:
    """What is seen and said on the first host; drives, as a planner and a base would."""

    def __init__(self) -> None:
        self.news, self.latest = threading.Condition(), {}
        self.said = {
            name: Diagnostics(name, self.news)
            for name in ("safety_area_merger", "obstacle_tracker", "person_detector")
        }
        self.costmap = CostmapView("local_costmap/costmap", self.news)
        for topic, kind in (
            ("persons", PersonArray),
            ("scan_human_aware", LaserScan),
            ("separation_monitor/state", SeparationState),
            ("cmd_vel", Twist),
        ):
            rospy.Subscriber(topic, kind, self._receive, callback_args=topic)
        self._odom = rospy.Publisher("odom", Odometry, queue_size=1)
        self._command = rospy.Publisher("cmd_vel_raw", Twist, queue_size=1)
        rospy.Timer(rospy.Duration.from_sec(0.05), self._drive, reset=True)

    def _receive(self, message, topic: str) -> None:
        with self.news:
            self.latest[topic] = message
            self.news.notify_all()

    def _drive(self, _) -> None:
        odometry, command = Odometry(child_frame_id="base_footprint"), Twist()
        odometry.header.frame_id, odometry.header.stamp = "odom", rospy.Time.now()
        odometry.pose.pose.orientation.w = 1.0
        command.linear.x = SPEED
        self._odom.publish(odometry)
        self._command.publish(command)

    def wait(self, reached, what: str) -> None:
        wait_until(self.news, reached, lambda: f"{what}; {self}")

    def __str__(self) -> str:
        state = self.latest.get("separation_monitor/state")
        said = {name: str(one) for name, one in self.said.items()}
        return f"topics {sorted(self.latest)}, monitor '{state.text if state else ''}', {said}"

    def has_area(self) -> bool:
        """Is there a circle around the one who stands, in the scan?"""
        scan = self.latest.get("scan_human_aware")
        if scan is None:
            return False
        bearing = math.atan2(TO_STANDING[1], TO_STANDING[0])
        met = scan.ranges[round((bearing - scan.angle_min) / scan.angle_increment)]
        return abs(met - (DISTANCE - RADIUS)) < 0.2

    def has_area_in_costmap(self) -> bool:
        distances = np.linalg.norm(self.costmap.lethal() - NEAR_POINT, axis=1)
        return bool(len(distances)) and distances.min() < 0.15

    def may_drive(self) -> bool:
        state = self.latest.get("separation_monitor/state")
        return bool(state) and state.level != state.STOP and self.latest["cmd_vel"].linear.x > 0.0

    def works(self) -> None:
        """Waits until persons of one host are in scan and map of the other, and it may drive."""
        self.wait(self.has_area, "an area in the scan")
        self.wait(self.has_area_in_costmap, "the area in the costmap")
        self.wait(self.may_drive, "leave to drive")
        for name, one in self.said.items():
            self.wait(lambda one=one: one.level() == 0, f"{name} is content")


@pytest.fixture(scope="module")
def hosts(tmp_path_factory):
    try:
        made = TwoHosts(tmp_path_factory.mktemp("hosts"))
    except NoNamespacesError as error:
        pytest.skip(f"no network namespaces here: {error}")
    yield made
    made.end()


@pytest.fixture(scope="module")
def robot(hosts, tmp_path_factory):
    folder = tmp_path_factory.mktemp("launch")
    (folder / "robot.yaml").write_text(yaml.safe_dump(ROBOT))
    (folder / "all.launch").write_text(LAUNCH)
    launched = hosts.launch(
        folder / "all.launch", f"robot:={folder}/robot.yaml", f"env_loader:={hosts.env_loader}"
    )
    wait_until(threading.Condition(), rosgraph.is_master_online, "the master", lambda: None)
    rospy.init_node("test_two_hosts", disable_signals=True)
    seen = Robot()
    seen.works()
    yield seen
    rospy.signal_shutdown("done")
    launched.terminate()
    launched.wait(30.0)


@pytest.fixture
def skewed(hosts, robot):
    """Sets the other host's clock; afterwards it is right again, and all must be well by itself."""
    yield hosts.set_clock
    hosts.set_clock(0.0)
    robot.works()


def doctor_says(folder: Path) -> list[dict]:
    """What is at fault with stamps."""
    doctor, *_ = find_node("safe_passage", "doctor")
    file = folder / "doctor.json"
    command = [doctor, "--seconds", "3", "--json", str(file)]
    subprocess.run(command, capture_output=True, timeout=TIMEOUT)
    found = json.loads(file.read_text())
    print(*found, sep="\n")
    faults = [one for one in found if one["severity"] == Severity.FAULT.name]
    return [one for one in faults if " s old" in one["what"] or "future" in one["what"]]


def test_each_half_runs_at_its_own_address(robot):
    master = rosgraph.Master("/test_two_hosts")
    for node, address in (
        ("person_detector", THERE),
        ("camera_driver", THERE),
        ("safety_area_merger", HERE),
        ("obstacle_tracker", HERE),
        ("separation_monitor", HERE),
        ("local_costmap", HERE),
    ):
        assert f"//{address}:" in master.lookupNode(f"/{node}")


def test_doctor_finds_no_fault_with_the_clocks(robot, tmp_path):
    assert doctor_says(tmp_path) == []


@pytest.mark.parametrize(
    ("ahead", "reason", "told", "doctor"),
    [
        (SKEW, "FUTURE", "s ahead", "in the future"),
        (-SKEW, "STALE", "s old", "s old"),
    ],
)
def test_a_clock_that_differs(skewed, robot, tmp_path, ahead, reason, told, doctor):
    skewed(ahead)
    tracker, merger = robot.said["obstacle_tracker"], robot.said["safety_area_merger"]

    # who hangs on the other clock is not trusted: no area in the wrong place, the robot stands
    silent = "SENSOR_SILENT: laser_there"
    robot.wait(lambda: robot.latest["separation_monitor/state"].text == silent, silent)
    robot.wait(lambda: robot.latest["cmd_vel"].linear.x == 0.0, "a robot that stands")
    robot.wait(lambda: not robot.has_area(), "a scan without the circle")

    # and both say why, and by how much
    for one, topic in ((tracker, "/there/scan"), (merger, "persons")):
        said = re.compile(
            rf"{topic}: only dropped messages, last reason {reason}, [2-9]\.\d+ {told}"
        )
        robot.wait(lambda one=one, said=said: said.search(one.message()), said.pattern)
    found = doctor_says(tmp_path)
    for topic in ("/there/scan", "/persons"):
        (one,) = (one for one in found if one["subject"] == topic)
        assert doctor in one["what"] and "clock" in one["cause"]
