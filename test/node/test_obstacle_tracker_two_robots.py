#!/usr/bin/env python3
"""Two robots on one master: each tracks its own obstacles, in its own frames."""

import math
import sys
import threading
import unittest

import numpy as np
import rosgraph
import rospy
import rostest
from node_testing import Diagnostics, wait_until
from safe_passage.msg import TrackedObstacleArray
from tracker_world import SENSORS, World

ROBOTS = ("robot1", "robot2")
SHARED = ("/diagnostics", "/rosout")  # topics that are everybody's
RADIUS, SPEED = 2.0, 1.0  # [m], [m/s] of a walk around a robot
BEARINGS = {"robot1": -1.2, "robot2": -2.6}  # [rad] where the walks begin, frame odom
TURNED = {"robot1": 0.0, "robot2": 2.0}  # [rad] how the robots stand in their odom
WALK = 2.4  # [s]
NEAR = 0.35  # [m] from a person to the track that is it
MISTAKEN = 0.6  # [m] from where the other robot sees somebody


class TwoRobotsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.news = threading.Condition()
        cls.tracks = {robot: [] for robot in ROBOTS}
        cls.worlds = {robot: World(robot) for robot in ROBOTS}
        cls.diagnostics = {r: Diagnostics(f"{r}/obstacle_tracker", cls.news) for r in ROBOTS}
        for robot in ROBOTS:
            topic = f"/{robot}/tracks"
            rospy.Subscriber(topic, TrackedObstacleArray, cls.on_tracks, callback_args=robot)

    @classmethod
    def on_tracks(cls, array, robot):
        with cls.news:
            cls.tracks[robot].append(array)
            cls.news.notify_all()

    def setUp(self):
        for robot, world in self.worlds.items():
            world.begin()
            world.pose_after = lambda age, yaw=TURNED[robot]: (0.0, 0.0, yaw)

    def see(self, seeing=ROBOTS):
        """A step of both worlds, and what those that see anything answer."""
        sent = []

        def step():
            for robot, world in self.worlds.items():
                stamp = world.tick()
                if robot in seeing:
                    world.measure(stamp)
            sent.append(stamp)

        def answers():
            return [
                next((one for one in self.tracks[r] if one.header.stamp in sent), None)
                for r in seeing
            ]

        step()
        self.wait(lambda: all(answers()), f"tracks of {seeing}", step)
        return dict(zip(seeing, answers()))

    def wait(self, reached, what, step):
        wait_until(self.news, reached, lambda: f"{what}; {self.diagnostics['robot1']}", step)

    def place_in_base(self, robot, age):
        """Of who walks around the robot."""
        bearing = BEARINGS[robot] + age * SPEED / RADIUS - TURNED[robot]
        return RADIUS * np.array([math.cos(bearing), math.sin(bearing)])

    def test_1_each_tracks_its_own(self):
        for robot, world in self.worlds.items():
            turn = TURNED[robot]
            world.people_after = lambda age, robot=robot, yaw=turn: [
                turned(self.place_in_base(robot, age), yaw)
            ]
        while self.worlds["robot1"].age < WALK:
            arrays = self.see()
        for robot, other in (ROBOTS, ROBOTS[::-1]):
            array = arrays[robot]
            age = self.worlds[robot].since(array.header.stamp)
            self.assertEqual(array.header.frame_id, f"{robot}/base_link")
            moving = [o for o in array.obstacles if o.moving and o.observed]
            self.assertEqual(len(moving), 1, f"{robot}: {[o.position for o in moving]}")
            (walker,) = moving
            self.assertLess(distance(walker, self.place_in_base(robot, age)), NEAR)
            elsewhere = self.place_in_base(other, age)
            mistaken = [o.id for o in array.obstacles if distance(o, elsewhere) < MISTAKEN]
            self.assertEqual(mistaken, [], f"{robot} has obstacles of {other}")

    def test_2_one_goes_on_when_the_other_is_silent(self):
        self.see()
        with self.news:
            before = len(self.tracks["robot2"])
            last = self.tracks["robot2"][-1].header.stamp
        silent = [f"silent: /robot2/{topic}" for topic in SENSORS]

        def known():
            return all(text in self.diagnostics["robot2"].message() for text in silent)

        self.wait(known, silent, lambda: self.see(seeing=("robot1",)))
        self.assertEqual(self.diagnostics["robot2"].level(), 2)
        self.assertEqual(self.diagnostics["robot1"].level(), 0)
        self.assertLessEqual(len(self.tracks["robot2"]), before + 1, "one may have been under way")
        self.assertGreater(self.tracks["robot1"][-1].header.stamp, last)

    def test_3_nothing_is_published_outside_of_the_namespaces(self):
        published, _, _ = rosgraph.Master(rospy.get_name()).getSystemState()
        for robot in ROBOTS:
            own = [topic for topic, nodes in published if f"/{robot}/obstacle_tracker" in nodes]
            self.assertIn(f"/{robot}/tracks", own)
            outside = [t for t in own if not t.startswith(f"/{robot}/") and t not in SHARED]
            self.assertEqual(outside, [])


def turned(place, yaw):
    """From base to odom."""
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([c * place[0] - s * place[1], s * place[0] + c * place[1]])


def distance(obstacle, place):
    return math.hypot(obstacle.position.x - place[0], obstacle.position.y - place[1])


if __name__ == "__main__":
    rospy.init_node("test_obstacle_tracker_two_robots", disable_rostime=True)
    rostest.rosrun("safe_passage", "test_obstacle_tracker_two_robots", TwoRobotsTest, sys.argv)
