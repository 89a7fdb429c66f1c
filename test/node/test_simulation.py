#!/usr/bin/env python3
"""Nodes warehouse_sim and simple_navigator: a robot that senses, obeys, drives and stops."""

import math
import sys
import threading
import unittest
from pathlib import Path

import actionlib
import numpy as np
import rospkg
import rospy
import rostest
import tf2_ros
import yaml
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped, Twist
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from nav_msgs.msg import OccupancyGrid, Odometry
from node_testing import folder_for, launch_for, output_of_refusal, wait_until
from rosgraph_msgs.msg import Clock
from safe_passage.msg import PersonArray
from sensor_msgs.msg import CameraInfo, Image, LaserScan
from std_srvs.srv import Empty

WORLD = {
    "name": "test hall",
    "size": [9.0, 6.0],
    "start": [-3.0, 0.0, 0.0],
    "pallets": [{"x": 3.4, "y": 0.0, "goods": 0.8}],
    "people": [{"waypoints": [[0.5, 2.0]], "yaw": -1.6}],
}
LATE = 0.2  # s, a fault of the camera
PALLET_FACE = 3.4 - 0.6  # m, x
FRONT = 0.36  # m, of the robot
PACKAGE = Path(rospkg.RosPack().get_path("safe_passage"))
LATEST = {  # topic -> type
    "clock": Clock,
    "scan": LaserScan,
    "odom": Odometry,
    "map": OccupancyGrid,
    "rgb/camera_info": CameraInfo,
    "rgb/image_rect_color": Image,
    "depth_registered/image_rect": Image,
    "warehouse_sim/persons": PersonArray,
}


class SimulationTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.news = threading.Condition()
        cls.latest, cls.went_back = {}, 0
        cls.tf = tf2_ros.Buffer()
        cls.listener = tf2_ros.TransformListener(cls.tf)
        for topic, kind in LATEST.items():
            rospy.Subscriber(topic, kind, cls.receive, callback_args=topic)
        cls.command_pub = rospy.Publisher("cmd_vel", Twist, queue_size=1)
        cls.goal_pub = rospy.Publisher("move_base_simple/goal", PoseStamped, queue_size=1)
        world = cls.world = folder_for(cls) / "hall.yaml"
        world.write_text(yaml.safe_dump(WORLD))
        rospy.set_param(  # beside what the launch file sets
            "warehouse_sim/faults", [{"kind": "latency", "target": "camera", "value": LATE}]
        )
        launch_for(
            cls,
            (str(PACKAGE / "launch/warehouse_sim.launch"), [f"world:={world}"]),
            (str(PACKAGE / "launch/navigation.launch"), ["scan_human_aware:=scan"]),
        )
        cls.client = actionlib.SimpleActionClient("move_base", MoveBaseAction)

    @classmethod
    def receive(cls, message, topic):
        with cls.news:
            before = cls.latest.get(topic)
            if topic == "clock" and before and message.clock < before.clock:
                cls.went_back += 1
            cls.latest[topic] = message
            cls.news.notify_all()

    def wait(self, reached, what, step=None):
        wait_until(self.news, reached, what, step)

    def position(self):
        pose = self.latest["odom"].pose.pose.position
        return np.array([pose.x - 3.0, pose.y])

    def speed(self):
        twist = self.latest["odom"].twist.twist
        return max(abs(twist.linear.x), abs(twist.angular.z))

    def drive(self, forward):
        command = Twist()
        command.linear.x = forward
        self.command_pub.publish(command)

    def goal(self, x, y=0.0, frame="map"):
        goal = MoveBaseGoal()
        goal.target_pose.header.frame_id = frame
        goal.target_pose.pose.position.x, goal.target_pose.pose.position.y = x, y
        goal.target_pose.pose.orientation.w = 1.0
        return goal

    def test_1_all_sensors_speak_with_the_conventions_of_ros(self):
        self.wait(lambda: set(LATEST) <= set(self.latest), lambda: set(LATEST) - set(self.latest))
        scan, info = self.latest["scan"], self.latest["rgb/camera_info"]
        self.assertEqual((len(scan.ranges), scan.header.frame_id), (1081, "laser"))
        self.assertAlmostEqual(scan.angle_increment, math.radians(0.25), places=6)
        self.assertAlmostEqual(scan.ranges[540], PALLET_FACE + 2.7, delta=0.1)  # from x = -2.7
        self.assertEqual((info.width, info.height, info.K[0]), (640, 480, 525.0))
        self.assertEqual(info.header.frame_id, "camera_rgb_optical_frame")
        depth = self.latest["depth_registered/image_rect"]
        self.assertEqual((depth.encoding, depth.height, depth.width), ("32FC1", 480, 640))
        self.assertEqual(self.latest["map"].header.frame_id, "map")
        person = self.latest["warehouse_sim/persons"].persons[0]
        self.assertEqual((person.position.x, person.position.y), (0.5, 2.0))

    def test_1_every_frame_hangs_on_the_map(self):
        for frame in ("laser", "camera_rgb_optical_frame", "base_link"):
            self.wait(
                lambda frame=frame: self.tf.can_transform("map", frame, rospy.Time()),
                f"tf map -> {frame}",
            )
        camera = self.tf.lookup_transform("map", "camera_rgb_optical_frame", rospy.Time())
        self.assertAlmostEqual(camera.transform.translation.z, 1.63, places=3)

    def test_1_a_fault_of_the_camera_makes_its_pictures_late(self):
        def late_by():
            return (
                self.latest["clock"].clock - self.latest["rgb/camera_info"].header.stamp
            ).to_sec()

        self.wait(lambda: "rgb/camera_info" in self.latest and late_by() >= LATE, "a late picture")

    def test_2_it_obeys_and_stops_when_nobody_commands(self):
        self.wait(lambda: self.speed() > 0.1, "motion", lambda: self.drive(0.3))
        self.wait(lambda: self.speed() == 0.0, "the stop after the last command")
        self.assertGreater(self.position()[0], -3.0)

    def test_2_a_command_that_is_no_number_stops_it(self):
        self.wait(lambda: self.speed() > 0.1, "motion", lambda: self.drive(0.2))
        self.wait(lambda: self.speed() == 0.0, "the stop", lambda: self.drive(math.nan))

    def test_3_it_drives_to_a_pallet_and_stops_before_it(self):
        self.assertTrue(self.client.wait_for_server(rospy.Duration(20)))
        self.client.send_goal(self.goal(PALLET_FACE - 0.10 - FRONT))
        self.wait(self.is_done, self.client.get_goal_status_text, lambda: None)
        self.assertEqual(self.client.get_state(), GoalStatus.SUCCEEDED)
        gap = PALLET_FACE - FRONT - self.position()[0]
        self.assertGreater(gap, 0.0)
        self.assertLess(gap, 0.15 + 0.05)  # odometry drifts

    def test_4_a_goal_from_rviz_is_driven_to_and_a_new_one_takes_its_place(self):
        start = self.position()
        message = self.goal(-2.0, -1.5).target_pose
        moved = lambda: np.hypot(*(self.position() - start)) > 0.3  # noqa: E731
        self.goal_pub.publish(message)
        self.wait(moved, "motion to rviz's goal")
        self.client.send_goal(self.goal(0.0, -1.5))
        self.wait(self.is_done, "the new goal", lambda: None)
        self.assertEqual(self.client.get_state(), GoalStatus.SUCCEEDED)

    def test_5_a_goal_taken_back_stops_the_robot(self):
        self.wait(lambda: self.speed() == 0.0, "the end of the last goal's motion")
        self.client.send_goal(self.goal(-3.0, 1.5))
        self.wait(lambda: self.speed() > 0.1, "motion")
        self.client.cancel_goal()
        self.wait(lambda: self.speed() == 0.0, "the stop")
        self.wait(self.is_done, "the end of the goal", lambda: None)
        self.assertEqual(self.client.get_state(), GoalStatus.PREEMPTED)

    def test_6_goals_that_are_none_are_refused_with_a_reason(self):
        for goal, reason in (
            (self.goal(0.0, frame="moon"), "moon"),
            (self.goal(math.nan), "finite"),
        ):
            self.client.send_goal(goal)
            self.wait(self.is_done, "refusal", lambda: None)
            self.assertEqual(self.client.get_state(), GoalStatus.ABORTED)
            self.assertIn(reason, self.client.get_goal_status_text())

    def test_7_started_anew_its_clock_goes_back_and_it_stands_at_its_start(self):
        rospy.ServiceProxy("warehouse_sim/reset", Empty)()
        self.wait(lambda: self.went_back == 1, "the clock's jump back")
        self.wait(lambda: np.allclose(self.position(), (-3.0, 0.0)), "the start")
        self.wait(lambda: self.latest["clock"].clock.to_sec() > 2.0, "all to have noticed")
        self.client.send_goal(self.goal(-2.0))
        self.wait(self.is_done, "a goal after the jump", lambda: None)
        self.assertEqual(self.client.get_state(), GoalStatus.SUCCEEDED)

    def test_8_wrong_parameters_are_refused(self):
        robot = str(PACKAGE / "config/robots/summit_xl.yaml")
        for i, (arguments, said) in enumerate(
            (
                (["_robot:=" + robot], "/world is '', must be a non-empty string"),
                (["_robot:=" + robot, "_world:=/no/such.yaml"], "/no/such.yaml"),
                (["_robot:=" + robot, "_world:=x", "_seed:=-1"], "/seed is -1"),
                (
                    ["_robot:=" + robot, f"_world:={self.world}", "_faults:=[{kind: thirst}]"],
                    "kind is 'thirst'",
                ),
                (["_robot:=" + robot, "_world:=x", "_speed:=2"], "/speed is not known"),
            )
        ):
            self.assertIn(said, output_of_refusal("warehouse_sim", *arguments, f"__name:=no_{i}"))

    def is_done(self):
        return self.client.get_state() not in (GoalStatus.PENDING, GoalStatus.ACTIVE)


if __name__ == "__main__":
    rospy.init_node("test_simulation")
    rostest.rosrun("safe_passage", "test_simulation", SimulationTest, sys.argv)
