#!/usr/bin/env python3
"""Parameters changed by dynamic_reconfigure while the nodes run: they count, nothing is lost."""

import sys
import threading
import unittest

import rospy
import rostest
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from node_testing import TIMEOUT, Diagnostics, wait_until
from rosgraph_msgs.msg import Log
from safe_passage.msg import SeparationState, TrackedObstacleArray
from safe_passage.ros.conversions import to_header
from tracker_world import BASE, ODOM, World

AHEAD = 3.0  # [m] from the robot somebody stands


class LiveTuningTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.news = threading.Condition()
        cls.latest, cls.logs = {}, []
        cls.diagnostics = Diagnostics("robot1/separation_monitor", cls.news)
        cls.world = World()
        cls.world.people_after = lambda age: [(AHEAD, 0.0)]
        cls.odom = rospy.Publisher("odom", Odometry, queue_size=10)
        cls.command = rospy.Publisher("cmd_vel_in", Twist, queue_size=10)
        for topic, kind in (
            ("tracks", TrackedObstacleArray),
            ("separation_monitor/state", SeparationState),
        ):
            rospy.Subscriber(topic, kind, cls.keep, callback_args=topic)
        rospy.Subscriber("/rosout", Log, lambda log: cls.logs.append(log.msg))
        cls.clients = {}

    @classmethod
    def keep(cls, message, topic):
        with cls.news:
            cls.latest[topic] = message
            cls.news.notify_all()

    def tick(self):
        """A step of time, at which all speak."""
        stamp = self.world.tick()
        self.world.measure(stamp)
        odometry = Odometry(header=to_header(stamp, ODOM), child_frame_id=BASE)
        self.odom.publish(odometry)
        command = Twist()
        command.linear.x = 0.5
        self.command.publish(command)

    def until(self, reached, what):
        wait_until(
            self.news, reached, lambda: f"{what}; {self.scale()}; {self.diagnostics}", self.tick
        )

    def client(self, node):
        if node not in self.clients:
            self.clients[node] = Client(f"/robot1/{node}", timeout=TIMEOUT)
        return self.clients[node]

    def change(self, node, **changes):
        """What the node tells to be in force then."""
        return self.client(node).update_configuration(changes)

    def scale(self):
        state = self.latest.get("separation_monitor/state")
        return state.scale if state and state.level != SeparationState.STOP else 0.0

    def somebody(self):
        """The track of who stands ahead."""
        array = self.latest.get("tracks")
        for one in array.obstacles if array else ():
            if abs(one.position.x - AHEAD) < 0.4 and abs(one.position.y) < 0.4:
                return one
        return None

    def assert_refused(self, node, changes, because):
        """Nothing changes, the values in force are told back, the log says why."""
        before = self.client(node).get_configuration(timeout=TIMEOUT)
        told = self.change(node, **changes)
        names = [name for name in before if name != "groups"]
        self.assertEqual({n: told[n] for n in names}, {n: before[n] for n in names})
        for name in names:
            self.assertEqual(rospy.get_param(f"/robot1/{node}/{name}"), before[name], name)
        self.until(lambda: any(because in log for log in self.logs), f"'{because}' in the log")

    def test_1_the_monitor_slows_down_by_another_distance(self):
        self.until(lambda: self.somebody() and self.scale() == 1.0, "free")
        told = self.change("separation_monitor", min_distance=2.6)
        self.assertEqual(told["min_distance"], 2.6)
        self.assertEqual(rospy.get_param("/robot1/separation_monitor/min_distance"), 2.6)
        self.until(lambda: self.scale() < 1.0, "slower")
        self.change("separation_monitor", min_distance=0.3)
        self.until(lambda: self.scale() == 1.0, "free again")

    def test_2_what_is_out_of_range_or_does_not_fit_is_refused(self):
        node = "separation_monitor"
        self.assert_refused(node, {"min_distance": -1.0}, "min_distance is -1.0, must lie in")
        self.assert_refused(node, {"horizon": 9.0}, "stop_horizon is 6.0, must lie in [9.0")
        self.assert_refused(node, {"min_distance": 2.6, "sigmas": 99.0}, "sigmas is 99.0")
        for _ in range(10):
            self.tick()
        self.until(lambda: self.scale() == 1.0, "still free")
        told = self.change(node, horizon=9.0, stop_horizon=12.0)  # together they fit
        self.assertEqual((told["horizon"], told["stop_horizon"]), (9.0, 12.0))

    def test_3_tracks_survive(self):
        self.until(self.somebody, "a track")
        number = self.somebody().id
        told = self.change("obstacle_tracker", confirm_cycles=100000)
        self.assertEqual(told["confirm_cycles"], 3)  # out of range
        told = self.change("obstacle_tracker", confirm_cycles=1000)
        self.assertEqual(told["confirm_cycles"], 1000)
        self.until(lambda: not self.somebody(), "no track is confirmed")
        self.change("obstacle_tracker", confirm_cycles=3)
        self.until(self.somebody, "the track again")
        self.assertEqual(self.somebody().id, number)

    def test_4_parts_have_their_names_before_them(self):
        client = self.client("obstacle_tracker")
        told = client.update_configuration({"person_labels/label_gate": 1.0})
        self.assertEqual(told["person_labels/label_gate"], 1.0)
        value = rospy.get_param("/robot1/obstacle_tracker/person_labels/label_gate")
        self.assertEqual(value, 1.0)

    def test_5_clients_are_told_ranges_and_units(self):
        found = self.client("separation_monitor").get_parameter_descriptions(timeout=TIMEOUT)
        release = next(one for one in found if one["name"] == "release_time")
        self.assertEqual((release["min"], release["max"], release["default"]), (0.0, 60.0, 1.0))
        self.assertIn("[s]", release["description"])
        self.assertNotIn("base_frame", [one["name"] for one in found])


if __name__ == "__main__":
    rospy.init_node("test_live_tuning")
    rostest.rosrun("safe_passage", "test_live_tuning", LiveTuningTest, sys.argv)
