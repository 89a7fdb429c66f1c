#!/usr/bin/env python3
"""The chain, camera to costmap: people become circles in the scan and the map, and leave again."""

import os
import signal
import sys
import threading
import unittest
import xmlrpc.client

import numpy as np
import rosgraph
import rospy
import rostest
from node_testing import CostmapView, Diagnostics, wait_until
from safe_passage.msg import PersonArray
from safe_passage.simulation.analytic_scene import Camera
from sensor_msgs.msg import LaserScan
from visualization_msgs.msg import MarkerArray

ROBOTS = "robot1", "robot2"
RADIUS, HOLD_TIME = 1.2, 1.0  # m, s: config/safety_area_merger.yaml
LASER = np.array([0.2, 0.0])  # m, on the robot
STANDING, FAR = np.array([3.2, 0.95]), np.array([5.9, -0.75])  # m, people of the aisle
WALKER_X, WALKER_REACH = 4.6, 1.05  # m, the one who walks to and fro
POSITION_ERROR = 0.15  # m
WARN = 1  # diagnostics

TO_STANDING = STANDING - LASER
DISTANCE = np.linalg.norm(TO_STANDING)
NEAR_POINT = LASER + TO_STANDING * (1.0 - RADIUS / DISTANCE)  # of the circle


class Robot:
    """Everything the chain of one robot publishes."""

    def __init__(self, name, news):
        self.name, self.news = name, news
        self.persons, self.real, self.merged = [], {}, {}
        self.frames = set()
        self.camera = Camera()
        self.costmap = CostmapView(f"/{name}/local_costmap/costmap", news)
        self.merger = Diagnostics(f"{name}/safety_area_merger", news)
        rospy.Subscriber(f"/{name}/persons", PersonArray, self.on_persons)
        rospy.Subscriber(f"/{name}/scan", LaserScan, self.on_scan, callback_args=self.real)
        topic = f"/{name}/scan_human_aware"
        rospy.Subscriber(topic, LaserScan, self.on_scan, callback_args=self.merged)
        for node in ("person_detector", "safety_area_merger"):
            rospy.Subscriber(f"/{name}/{node}/markers", MarkerArray, self.on_markers)

    def on_persons(self, message):
        with self.news:
            self.frames.add(message.header.frame_id)
            self.persons.append(message)
            self.news.notify_all()

    def on_scan(self, message, scans):
        with self.news:
            self.frames.add(message.header.frame_id)
            scans[message.header.stamp] = message
            self.news.notify_all()

    def on_markers(self, message):
        with self.news:
            self.frames.update(marker.header.frame_id for marker in message.markers)

    def places(self):
        """Persons (N, 2) of the newest message, on the ground [m]."""
        points = [(p.position.x, p.position.y, p.position.z) for p in self.persons[-1].persons]
        return (np.reshape(points, (-1, 3)) @ self.camera.rotation().T)[:, :2]

    def sees_all(self):
        """Three persons, each where the scene has one."""
        if not self.persons or len(self.persons[-1].persons) != 3:
            return False
        rest = list(self.places())
        for truth in (STANDING, FAR):
            nearest = min(range(len(rest)), key=lambda i: np.linalg.norm(rest[i] - truth))
            if np.linalg.norm(rest.pop(nearest) - truth) > POSITION_ERROR:
                return False
        x, y = rest[0]
        return abs(x - WALKER_X) < 0.3 and abs(y) < WALKER_REACH + POSITION_ERROR

    def stamps(self):
        """Of the scans that came out, in order."""
        with self.news:
            return sorted(stamp for stamp in self.merged if stamp in self.real)

    def ranges(self, stamp):
        """Of the real scan and of the merged one."""
        return np.array(self.real[stamp].ranges), np.array(self.merged[stamp].ranges)

    def has_circle(self, stamp):
        """Is there, in the scan of that time, a circle around the one who stands?"""
        real, merged = self.ranges(stamp)
        scan = self.merged[stamp]
        bearing = np.arctan2(TO_STANDING[1], TO_STANDING[0])
        beam = round((bearing - scan.angle_min) / scan.angle_increment)
        return abs(merged[beam] - (DISTANCE - RADIUS)) < 0.2 and merged[beam] < real[beam] - 0.5

    def circle_in_scan(self):
        stamps = self.stamps()
        return bool(stamps) and self.has_circle(stamps[-1])

    def circle_in_costmap(self):
        distances = np.linalg.norm(self.costmap.lethal() - NEAR_POINT, axis=1)
        return bool(len(distances)) and distances.min() < POSITION_ERROR

    def person_in_costmap(self):
        """The body itself, which the laser sees."""
        distances = np.linalg.norm(self.costmap.lethal() - STANDING, axis=1)
        return bool(len(distances)) and distances.min() < 0.3


class HumanSafetyChainTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.news = threading.Condition()
        cls.robots = [Robot(name, cls.news) for name in ROBOTS]

    def wait(self, reached, what):
        wait_until(self.news, reached, what)

    def test_1_persons_circles_and_costmap(self):
        for robot in self.robots:
            self.wait(
                robot.sees_all, lambda r=robot: f"3 persons of {r.name}, not {r.persons[-1:]}"
            )
            self.wait(robot.circle_in_scan, f"a circle in the scan of {robot.name}")
            self.wait(robot.circle_in_costmap, f"a circle in the costmap of {robot.name}")
            for real, merged in map(robot.ranges, robot.stamps()):
                known = np.isfinite(real)
                self.assertTrue((merged[known] <= real[known]).all())
                self.assertTrue((merged[:180] == real[:180]).all())  # nobody is to the right rear

    def test_2_frames_are_each_robots_own(self):
        for robot in self.robots:
            self.wait(lambda r=robot: len(r.frames) >= 3, f"frames of {robot.name}")
            frames = {*robot.frames, robot.costmap.header.frame_id}
            names = "camera_rgb_optical_frame", "laser", "odom"
            self.assertEqual(frames - {""}, {f"{robot.name}/{name}" for name in names})

    def test_3_circles_leave_when_the_detector_dies_and_the_other_robot_keeps_its_own(self):
        silenced, other = self.robots
        self.wait(silenced.circle_in_costmap, "a circle")
        kill(f"/{silenced.name}/person_detector")
        self.wait(lambda: not silenced.circle_in_scan(), "a scan without the circle")
        self.wait(lambda: not silenced.circle_in_costmap(), "a costmap without the circle")
        self.wait(silenced.person_in_costmap, "what the laser itself sees of the person")

        last_seen = silenced.persons[-1].header.stamp.to_sec()
        with_circle = [s.to_sec() - last_seen for s in silenced.stamps() if silenced.has_circle(s)]
        self.assertGreater(max(with_circle), 0.0)  # held
        self.assertLess(max(with_circle), HOLD_TIME + 0.01)  # dropped

        self.wait(
            lambda: silenced.merger.message("safety areas") == "persons silent: no safety areas",
            lambda: f"the warning; {silenced.merger}",
        )
        self.assertEqual(silenced.merger.level("safety areas"), WARN)
        self.wait(
            lambda: "silent: persons" in silenced.merger.message(),
            lambda: f"'silent: persons'; {silenced.merger}",
        )
        self.assertTrue(other.circle_in_costmap())
        heard = len(other.persons)
        self.wait(lambda: len(other.persons) > heard, "persons of the other robot")
        self.wait(other.circle_in_scan, "the circle of the other robot")
        self.assertEqual(other.merger.message("safety areas"), "persons arrive")


def kill(node):
    """End a node as a crash would."""
    uri = rosgraph.Master(rospy.get_name()).lookupNode(node)
    _, _, pid = xmlrpc.client.ServerProxy(uri).getPid(rospy.get_name())
    os.kill(pid, signal.SIGKILL)


if __name__ == "__main__":
    rospy.init_node("test_human_safety_chain")
    rostest.rosrun("safe_passage", "test_human_safety_chain", HumanSafetyChainTest, sys.argv)
