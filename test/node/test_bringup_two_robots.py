#!/usr/bin/env python3
"""Two simulated robots of bringup.launch on one master: both work, neither hears the other."""

import sys
import threading
import unittest
from pathlib import Path

import numpy as np
import rosgraph
import rospkg
import rospy
import rostest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist
from nav_msgs.msg import OccupancyGrid, Odometry
from node_testing import folder_for, launch_for, wait_until
from safe_passage.msg import PersonArray, SeparationState, TrackedObstacleArray
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

PACKAGE = Path(rospkg.RosPack().get_path("safe_passage"))
NODES = {
    "obstacle_tracker",
    "separation_monitor",
    "person_detector",
    "safety_area_merger",
    "local_costmap",
    "warehouse_sim",
}
SHARED = {"/clock", "/tf", "/tf_static", "/rosout", "/diagnostics"}  # their messages say whose
SPEAKS = {  # topic -> type, of each
    "odom": Odometry,
    "scan": LaserScan,
    "scan_human_aware": LaserScan,
    "tracks": TrackedObstacleArray,
    "persons": PersonArray,
    "local_costmap/costmap": OccupancyGrid,
    "separation_monitor/state": SeparationState,
    "cmd_vel": Twist,
}
HALL = {"name": "hall", "size": [9.0, 6.0], "start": [-3.0, 0.0, 0.0]}
WORLDS = {  # somebody stands before the first robot, the second is alone
    "robot1": {**HALL, "people": [{"waypoints": [[0.5, 1.5]], "yaw": -1.6}]},
    "robot2": HALL,
}
ROBOT = """
  <group ns="{name}">
    <include file="$(find safe_passage)/launch/bringup.launch">
      <arg name="robot" value="{folder}/{name}.yaml"/> <arg name="frame_prefix" value="{name}/"/>
      <arg name="simulate" value="true"/> <arg name="world" value="{folder}/{name}_world.yaml"/>
      <arg name="real_time_factor" value="0.2"/> <arg name="follow_clock" value="{follows}"/>
    </include>
  </group>"""
SPEED = 0.3  # [m/s] that is wanted of the first robot


def write(folder):
    """Launch file, robots and worlds."""
    summit = (PACKAGE / "config/robots/summit_xl.yaml").read_text()
    text = ""
    for name, world in WORLDS.items():
        robot = yaml.safe_load(summit)  # docs/new_robot.md: the sensors' frames with the prefix
        for sensor in (*robot["robot"]["lidars"], *robot["robot"]["cameras"]):
            sensor["frame"] = f"{name}/{sensor['frame']}"
        (folder / f"{name}.yaml").write_text(yaml.safe_dump(robot))
        (folder / f"{name}_world.yaml").write_text(yaml.safe_dump(world))
        text += ROBOT.format(name=name, folder=folder, follows=str(name != "robot1").lower())
    file = folder / "two.launch"
    file.write_text(f"<launch>{text}\n</launch>")
    return str(file)


class TwoRobotsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.news, cls.latest = threading.Condition(), {}
        cls.poses, cls.merged, cls.people = {}, dict.fromkeys(WORLDS, 0), dict.fromkeys(WORLDS, 0)
        cls.frames, cls.reports = set(), {}
        for robot in WORLDS:
            for topic, kind in SPEAKS.items():
                rospy.Subscriber(f"/{robot}/{topic}", kind, cls.receive, (robot, topic))
        for topic in ("/tf", "/tf_static"):
            rospy.Subscriber(topic, TFMessage, cls.on_tf)
        rospy.Subscriber("/diagnostics", DiagnosticArray, cls.on_diagnostics)
        cls.command = rospy.Publisher("/robot1/cmd_vel_raw", Twist, queue_size=1)
        launch_for(cls, (write(folder_for(cls)), []))

    @classmethod
    def receive(cls, message, whose):
        robot, topic = whose
        with cls.news:
            if topic == "scan_human_aware":
                cls.merged[robot] += cls.has_area(robot, message)
            if topic == "persons":
                cls.people[robot] += len(message.persons)
            cls.latest[whose] = message
            cls.news.notify_all()

    @classmethod
    def has_area(cls, robot, merged):
        """Is it shorter than the real scan of the same time, where that is known?"""
        real = cls.latest.get((robot, "scan"))
        if real is None or real.header.stamp != merged.header.stamp:
            return 0
        return int((np.array(merged.ranges) < np.array(real.ranges) - 0.01).any())

    @classmethod
    def on_tf(cls, message):
        with cls.news:
            cls.frames |= {(one.header.frame_id, one.child_frame_id) for one in message.transforms}

    @classmethod
    def on_diagnostics(cls, message):
        with cls.news:
            cls.reports.update({status.name.lstrip("/"): status for status in message.status})
            cls.news.notify_all()

    def drive(self):
        """The first robot only."""
        command = Twist()
        command.linear.x = SPEED
        self.command.publish(command)

    def wait(self, reached, what):
        wait_until(self.news, reached, what, self.drive)

    def x(self, robot):
        return self.latest[robot, "odom"].pose.pose.position.x

    def test_1_both_work(self):
        wanted = {(robot, topic) for robot in WORLDS for topic in SPEAKS}
        # nobody wants the second one to drive: it says no command, once it has said 0
        missing = lambda: wanted - set(self.latest) - {("robot2", "cmd_vel")}  # noqa: E731
        self.wait(lambda: not missing(), lambda: f"{missing()}")
        start = self.x("robot1")
        self.wait(lambda: self.x("robot1") > start + 0.1, "the first robot's drive")
        self.wait(lambda: self.merged["robot1"] > 3, lambda: f"areas {self.merged} {self.people}")
        inputs = [
            f"{robot}/{node}: inputs" for robot in WORLDS for node in NODES - {"warehouse_sim"}
        ]

        def ill():
            return {
                name: self.reports[name].message if name in self.reports else "no report"
                for name in inputs
                if name not in self.reports or self.reports[name].level > 0
            }

        may_lack = {"robot2/separation_monitor: inputs"}  # a command
        self.wait(lambda: set(ill()) <= may_lack, lambda: f"content nodes; {ill()}")

    def test_2_neither_hears_the_other(self):
        publishers, subscribers, services = rosgraph.Master(rospy.get_name()).getSystemState()
        for robot in WORLDS:
            own = {f"/{robot}/{node}" for node in NODES}
            seen = set()
            for topic, nodes in (*publishers, *subscribers):
                if own & set(nodes):
                    seen |= own & set(nodes)
                    self.assertTrue(topic in SHARED or topic.startswith(f"/{robot}/"), topic)
            self.assertEqual(seen, own)
            for service, nodes in services:
                if own & set(nodes):
                    self.assertTrue(service.startswith(f"/{robot}/"), service)
        outside = {
            name
            for name in rospy.get_param_names()
            if not name.startswith(("/robot1/", "/robot2/", "/ros", "/run_id", "/use_sim_time"))
        }
        self.assertEqual({name for name in outside if "test_bringup" not in name}, set())

    def test_3_frames_are_each_robots_own(self):
        for (robot, topic), message in self.latest.items():
            if hasattr(message, "header"):
                self.assertTrue(message.header.frame_id.startswith(f"{robot}/"), topic)
        for parent, child in self.frames:
            robot = child.partition("/")[0]
            self.assertIn(robot, WORLDS)
            self.assertTrue(parent == "map" or parent.startswith(f"{robot}/"), f"{parent} {child}")

    def test_4_what_one_sees_and_does_is_nothing_to_the_other(self):
        self.assertGreater(self.people["robot1"], 0)
        self.assertEqual((self.people["robot2"], self.merged["robot2"]), (0, 0))
        self.assertLess(abs(self.x("robot2")), 0.01)
        command = self.latest.get(("robot2", "cmd_vel"), Twist())
        self.assertEqual((command.linear.x, command.angular.z), (0.0, 0.0))
        before = self.latest["robot2", "odom"].header.stamp
        self.wait(lambda: self.latest["robot2", "odom"].header.stamp > before, "its simulator")
        apart = (
            self.latest["robot1", "odom"].header.stamp - self.latest["robot2", "odom"].header.stamp
        )
        self.assertLess(abs(apart.to_sec()), 0.5)  # one clock


if __name__ == "__main__":
    rospy.init_node("test_bringup_two_robots", disable_rostime=True)
    rostest.rosrun("safe_passage", "test_bringup_two_robots", TwoRobotsTest, sys.argv)
