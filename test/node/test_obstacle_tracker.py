#!/usr/bin/env python3
"""Node obstacle_tracker: one identity through all sensors; what is lost or false is told."""

import math
import sys
import threading
import unittest

import numpy as np
import rospy
import rostest
from nav_msgs.msg import OccupancyGrid
from node_testing import Diagnostics, output_of_refusal, wait_until
from rosgraph_msgs.msg import Log
from safe_passage.core.geometry import placed
from safe_passage.msg import TrackedObstacle, TrackedObstacleArray
from sensor_msgs import point_cloud2
from sensor_msgs.msg import PointCloud2
from tracker_world import BASE, BEAMS, ODOM, SENSORS, WALL, World
from visualization_msgs.msg import Marker, MarkerArray

WALK_RADIUS, WALK_SPEED = 2.0, 1.0  # [m], [m/s]
FRONT, REAR, CAMERA = SENSORS
SOURCE = "_sources:=[{name: laser}]"


class ObstacleTrackerTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.news = threading.Condition()
        cls.tracks, cls.order, cls.latest, cls.logs = {}, [], {}, []
        cls.diagnostics = Diagnostics("robot1/obstacle_tracker", cls.news)
        cls.world = World()
        rospy.Subscriber("tracks", TrackedObstacleArray, cls.on_tracks)
        rospy.Subscriber("/rosout", Log, lambda log: cls.logs.append(log.msg))
        pictures = {"grid": OccupancyGrid, "cells": PointCloud2, "markers": MarkerArray}
        for name, kind in pictures.items():
            rospy.Subscriber(f"obstacle_tracker/{name}", kind, cls.keep, callback_args=name)

    @classmethod
    def on_tracks(cls, array):
        with cls.news:
            cls.tracks[array.header.stamp] = array
            cls.order.append(array.header.stamp)
            cls.news.notify_all()

    @classmethod
    def keep(cls, message, name):
        with cls.news:
            cls.latest[name] = message
            cls.news.notify_all()

    def setUp(self):
        self.world.begin()

    def see(self, topics=tuple(SENSORS)):
        """A step of the world, and the tracks that answer it."""
        sent = []

        def step():
            sent.append(self.world.tick())
            self.world.measure(sent[-1], topics)

        step()
        self.wait(lambda: any(stamp in self.tracks for stamp in sent), "tracks", step)
        return next(self.tracks[stamp] for stamp in sent if stamp in self.tracks)

    def wait(self, reached, what, step=None):
        wait_until(self.news, reached, lambda: f"{what}; {self.diagnostics}", step)

    def walk(self, start, end):
        """Somebody goes round the robot from bearing `start` to `end` [rad]; tracks on the way."""

        def place(t):
            bearing = start + t * WALK_SPEED / WALK_RADIUS
            return [WALK_RADIUS * np.array([math.cos(bearing), math.sin(bearing)])]

        self.world.people_after = place
        while self.world.age < (end - start) * WALK_RADIUS / WALK_SPEED:
            yield self.see()

    def assert_dropped(self, reason, topic, spoil, age=0.0):
        """A message of `topic` that is spoilt is counted; the others go on, and so does it then."""
        key, sent = f"/robot1/{topic} {reason}", []
        before = self.diagnostics.count(key)
        others = [other for other in SENSORS if other != topic]

        def step():
            stamp = self.world.tick()
            sent.append(stamp)
            message = self.world.message(topic, stamp - rospy.Duration.from_sec(age))
            spoil(message)
            self.world.publish(topic, message)
            self.world.measure(stamp, others)

        self.wait(lambda: self.diagnostics.count(key) > before, key, step)
        self.assertTrue([stamp for stamp in sent if stamp in self.tracks], "the others go on")
        self.wait_alive()

    def wait_alive(self):
        self.wait(lambda: all(self.newest().alive), "all sensors", self.see)

    def newest(self):
        return self.tracks[self.order[-1]]

    def test_1_waits_for_its_inputs_and_names_them(self):
        def named():
            return all(f"waiting for: /robot1/{t}" in self.diagnostics.message() for t in SENSORS)

        self.wait(named, "'waiting for'", self.world.tick)
        self.assertEqual(self.diagnostics.level(), 2)
        self.assertEqual(self.order, [])

    def test_2_one_identity_through_all_sensors(self):
        ids, sensors, errors = set(), np.zeros(3, bool), []
        for array in self.walk(-1.9, 0.9):
            (place,) = self.world.people_after(self.world.since(array.header.stamp))
            self.assertEqual(array.header.frame_id, BASE)
            self.assertEqual(array.sensors, ["front", "rear", "camera"])
            near = [o for o in array.obstacles if distance(o, place) < 0.35]
            if self.world.since(array.header.stamp) < 1.6:
                continue  # it takes a while to know that somebody walks
            self.assertEqual(len(near), 1, f"at {place}: {[o.id for o in near]}")
            (walker,) = near
            self.assertTrue(walker.observed)
            self.assertEqual(walker.classification, TrackedObstacle.UNKNOWN)
            ids.add((walker.id, walker.moving))
            sensors |= np.array(walker.points) > 0
            ahead = np.array([-place[1], place[0]]) / WALK_RADIUS * WALK_SPEED
            errors.append(np.hypot(walker.velocity.x - ahead[0], walker.velocity.y - ahead[1]))
            self.assertGreater(np.linalg.eigvalsh(np.reshape(walker.covariance, (4, 4))).min(), 0.0)
        self.assertEqual({moving for _, moving in ids}, {True})
        self.assertEqual(len(ids), 1)
        self.assertTrue(sensors.all(), sensors)
        self.assertLess(np.median(errors), 0.25)

    def test_3_a_wall_stands_while_the_robot_drives(self):
        self.world.pose_after = lambda t: (0.5 * t, 0.0, 0.4 * t)
        while self.world.age < 3.0:
            array = self.see()
        # the walker of the test before may still be carried on, unobserved
        self.assertFalse([o.id for o in array.obstacles if o.moving and o.observed])
        wall = max(array.obstacles, key=lambda o: len(o.cells_x))
        in_odom = cells_in_odom(wall, self.world.pose_after(self.world.since(array.header.stamp)))
        self.assertLess(np.abs(in_odom[:, 1] - WALL[0][1]).max(), 0.15)
        self.assertGreaterEqual(len(wall.footprint.points), 4)

    def test_4_every_cell_can_be_looked_at(self):
        known = {o.id for array in self.walk(-0.8, 0.8) for o in array.obstacles}
        seen = {}

        def complete():  # of one cycle
            seen.update(self.latest)
            stamps = {seen[name].header.stamp for name in ("grid", "cells") if name in seen}
            return len(seen) == 3 and len(stamps) == 1

        self.wait(complete, "pictures", self.see)
        grid = seen["grid"]
        self.assertEqual((grid.header.frame_id, grid.info.width), (BASE, grid.info.height))
        self.assertEqual(set(grid.data), {-1, 100})
        cells = list(point_cloud2.read_points(seen["cells"], ("points", "id")))
        self.assertEqual(len(cells), grid.data.count(100))
        self.assertTrue({int(number) for _, number in cells} & known)
        self.assertTrue(all(points > 0 for points, _ in cells))
        markers = seen["markers"].markers
        self.assertEqual(markers[0].action, Marker.DELETEALL)
        names = {marker.ns for marker in markers[1:]}
        self.assertLessEqual({"standing", "moving", "path", "field of view", "robot"}, names)
        self.assertEqual({m.header.frame_id for m in markers if m.ns == "path"}, {ODOM})
        self.assertTrue(all(m.lifetime.to_sec() > 0 for m in markers[1:]))

    def test_5_bad_messages_are_dropped_with_a_reason_and_the_others_go_on(self):
        def no_z(cloud):
            cloud.fields = cloud.fields[:2]

        def truncated(cloud):
            cloud.data = cloud.data[:-1]

        def wrong_frame(scan):
            scan.header.frame_id = "no_such_frame"

        def no_frame(scan):
            scan.header.frame_id = ""

        self.assert_dropped("NOT_FINITE", FRONT, spoilt(ranges=[math.nan] * BEAMS))
        self.assert_dropped("EMPTY", FRONT, spoilt(ranges=[]))
        self.assert_dropped("BAD_FIELDS", FRONT, spoilt(angle_increment=math.nan))
        self.assert_dropped("NO_TF", FRONT, wrong_frame)
        self.assert_dropped("BAD_FIELDS", REAR, no_frame)
        self.assert_dropped("STALE", REAR, spoilt(), age=5.0)
        self.assert_dropped("FUTURE", REAR, spoilt(), age=-5.0)
        self.see()
        self.assert_dropped("OUT_OF_ORDER", REAR, spoilt(), age=0.3)
        self.assert_dropped("EMPTY", CAMERA, spoilt(width=0, row_step=0, data=b""))
        self.assert_dropped("BAD_FIELDS", CAMERA, no_z)
        self.assert_dropped("BAD_FIELDS", CAMERA, truncated)

    def test_5_beams_without_return_are_no_obstacle_and_no_fault(self):
        before = self.see()

        def step():
            stamp = self.world.tick()
            scan = self.world.message(FRONT, stamp)
            scan.ranges = [math.inf, math.nan, 0.0, 1e9, -1.0] * (BEAMS // 5) + [math.inf]
            self.world.publish(FRONT, scan)
            self.world.measure(stamp, [REAR, CAMERA])

        self.wait(lambda: self.order[-1] > before.header.stamp, "tracks", step)
        self.assertTrue(all(self.newest().alive))

    def test_6_a_silent_sensor_is_reported_and_the_others_go_on(self):
        self.wait_alive()
        others = [REAR, CAMERA]
        self.wait(lambda: self.newest().alive == [False, True, True], "a sensor that is not alive",
                  lambda: self.see(topics=others))  # fmt: skip
        silent = f"silent: /robot1/{FRONT}"
        self.wait(
            lambda: silent in self.diagnostics.message(), silent, lambda: self.see(topics=others)
        )
        self.assertEqual(self.diagnostics.level(), 2)
        self.assertNotIn(REAR, self.diagnostics.message())
        self.assertTrue(self.newest().obstacles)
        self.wait(lambda: silent in self.logs, f"log of {silent}", lambda: self.see(topics=others))
        self.wait_alive()
        back = f"/robot1/{FRONT} is back"
        self.wait(lambda: back in self.logs, f"log of {back}", self.see)

    def test_6_nothing_is_published_when_all_are_silent(self):
        self.see()
        last = self.world.measured

        def all_silent():
            return all(f"silent: /robot1/{t}" in self.diagnostics.message() for t in SENSORS)

        self.wait(all_silent, "all silent", self.world.tick)
        self.assertLessEqual(self.order[-1], last)
        self.wait_alive()

    def test_7_nothing_is_published_while_tf_is_missing(self):
        self.see()
        last = self.world.measured
        key = f"/robot1/{FRONT} NO_TF"
        before = self.diagnostics.count(key)

        def step():
            self.world.measure(self.world.tick(tf=False))

        self.wait(lambda: self.diagnostics.count(key) > before, key, step)
        self.assertLessEqual(self.order[-1], last)
        self.see()

    def test_7_late_tf_is_awaited_and_wakes_it(self):
        self.see()
        stamp = self.world.tick(tf=False)
        self.world.measure(stamp)
        self.world.measure(self.world.tick(tf=False), [FRONT])  # has come: so has the one before
        self.world.publish_tf(stamp)
        self.wait(lambda: stamp in self.tracks, "tracks of the late tf")

    def test_8_starts_anew_when_the_clock_goes_back(self):
        known = max(o.id for array in self.walk(-0.5, 0.5) for o in array.obstacles)
        self.world.set_back(10.0)
        array = self.see()
        self.assertLess(array.header.stamp.to_sec(), 50.0)
        self.wait(lambda: self.newest().obstacles, "obstacles of the new time", self.see)
        self.assertFalse([o.id for o in self.newest().obstacles if o.id <= known])

    def test_9_wrong_parameters_are_refused_by_name(self):
        cases = (
            (["_sources:=[]"], "sources is empty"),
            ([SOURCE, "_odd:=1"], "/odd is not known"),
            ([SOURCE, "_rate:=0.0"], "/rate is 0.0, must lie in"),
            (["_sources:=[{name: laser, odd: 1}]"], "/sources[0]/odd is not known"),
        )
        for i, (arguments, said) in enumerate(cases):  # parameters stay: a new name each
            output = output_of_refusal("obstacle_tracker", *arguments, f"__name:=refused_{i}")
            self.assertIn(said, output)
            self.assertIn(f"/robot1/refused_{i}/", output)


def spoilt(**values):
    """What makes a message have these values."""

    def spoil(message):
        for name, value in values.items():
            setattr(message, name, value)

    return spoil


def distance(obstacle, place):
    return math.hypot(obstacle.position.x - place[0], obstacle.position.y - place[1])


def cells_in_odom(obstacle, pose):
    """(N, 2) [m]"""
    return placed(np.stack([obstacle.cells_x, obstacle.cells_y], axis=1), pose)


if __name__ == "__main__":
    rospy.init_node("test_obstacle_tracker", disable_rostime=True)
    rostest.rosrun("safe_passage", "test_obstacle_tracker", ObstacleTrackerTest, sys.argv)
