#!/usr/bin/env python3
"""bringup.launch with simulated robots: all comes up and speaks, nothing dies, they may drive."""

import sys
import tempfile
import threading
import unittest
from pathlib import Path

import roslaunch
import rospkg
import rospy
import rostest
import yaml
from geometry_msgs.msg import Twist
from nav_msgs.msg import OccupancyGrid
from node_testing import Diagnostics, wait_until
from rosgraph_msgs.msg import Clock
from safe_passage.msg import PersonArray, SeparationState, TrackedObstacleArray
from sensor_msgs.msg import LaserScan, PointCloud2

BRINGUP = str(Path(rospkg.RosPack().get_path("safe_passage")) / "launch/bringup.launch")
SPEAKS = {  # topic -> type, of every simulated robot
    "tracks": TrackedObstacleArray,
    "tracked_persons": PersonArray,
    "persons": PersonArray,
    "scan_human_aware": LaserScan,
    "local_costmap/costmap": OccupancyGrid,
    "separation_monitor/state": SeparationState,
    "cmd_vel": Twist,
}
OMNIROB_SPEAKS = {"laser_rear/scan_human_aware": LaserScan, "depth_filtered/points": PointCloud2}
HALL = {
    "name": "test hall",
    "size": [9.0, 6.0],
    "start": [-3.0, 0.0, 0.0],
    "people": [{"waypoints": [[0.5, 1.5]], "yaw": -1.6}],
}
SPEED = 0.2  # [m/s] that is wanted


class Died(roslaunch.pmon.ProcessListener):
    """Notes the processes that end."""

    def __init__(self):
        self.names = []

    def process_died(self, process_name, exit_code):
        self.names.append((process_name, exit_code))


class BringupTest(unittest.TestCase):
    def setUp(self):
        self.news, self.latest, self.died = threading.Condition(), {}, Died()
        self.folder = tempfile.TemporaryDirectory()
        world = Path(self.folder.name) / "hall.yaml"
        world.write_text(yaml.safe_dump(HALL))
        self.arguments = ["simulate:=true", f"world:={world}", "real_time_factor:=0.4"]
        self.launched = None

    def tearDown(self):
        if self.launched:
            self.launched.shutdown()
        self.folder.cleanup()

    def receive(self, message, topic):
        with self.news:
            self.latest[topic] = message
            self.news.notify_all()

    def start(self, robot, topics):
        self.topics = {"clock": Clock, **topics}
        subscribers = [
            rospy.Subscriber(topic, kind, self.receive, callback_args=topic)
            for topic, kind in self.topics.items()
        ]
        self.addCleanup(lambda: [subscriber.unregister() for subscriber in subscribers])
        self.command = rospy.Publisher("cmd_vel_raw", Twist, queue_size=1)
        config = roslaunch.config.load_config_default(
            [(BRINGUP, [f"robot:={robot}"])], None, verbose=False
        )
        self.diagnostics = {node.name: Diagnostics(node.name, self.news) for node in config.nodes}
        for node in ("robot", "separation_monitor", "local_costmap"):
            rospy.set_param(f"{node}/left_behind", 1)  # by another robot's yaml
        self.launched = roslaunch.parent.ROSLaunchParent(
            rospy.get_param("/run_id"),
            [(BRINGUP, [f"robot:={robot}", *self.arguments])],
            is_core=False,
            process_listeners=[self.died],
        )
        self.launched.start(auto_terminate=False)

    def wait(self, reached, what):
        def step():
            self.assertEqual(self.died.names, [])
            command = Twist()
            command.linear.x = SPEED
            self.command.publish(command)

        wait_until(self.news, reached, what, step)

    def comes_up(self, robot, topics):
        self.start(robot, topics)
        for node in ("robot", "separation_monitor", "local_costmap"):
            self.assertFalse(rospy.has_param(f"{node}/left_behind"), node)
        self.assertEqual(rospy.get_param("robot/name"), robot)
        missing = lambda: set(self.topics) - set(self.latest)  # noqa: E731
        self.wait(lambda: not missing(), lambda: f"{missing()} of {robot}")
        self.wait(
            lambda: self.latest["cmd_vel"].linear.x > 0.5 * SPEED,
            lambda: f"leave to drive: {self.latest['separation_monitor/state']}",
        )
        self.wait(
            lambda: all(d.level() == 0 for d in self.diagnostics.values()),
            lambda: f"all inputs alive: { {n: str(d) for n, d in self.diagnostics.items()} }",
        )
        self.assertTrue(all(self.latest["tracks"].alive), self.latest["tracks"].sensors)
        self.assertEqual(self.died.names, [])

    def test_summit_xl(self):
        self.comes_up("summit_xl", SPEAKS)
        self.assertEqual(self.latest["scan_human_aware"].header.frame_id, "laser")

    def test_omnirob(self):
        self.comes_up("omnirob", {**SPEAKS, **OMNIROB_SPEAKS})
        self.assertEqual(len(self.latest["tracks"].sensors), 4)


if __name__ == "__main__":
    rospy.init_node("test_bringup", disable_rostime=True)
    rostest.rosrun("safe_passage", "test_bringup", BringupTest, sys.argv)
