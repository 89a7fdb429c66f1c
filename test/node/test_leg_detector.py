#!/usr/bin/env python3
"""Node leg_detector: persons where legs are; silence, with a reason, on scans that are none."""

import math
import sys
import tempfile
import threading
import unittest

import rospkg
import rospy
import rostest
from leg_models import look, make_leg_model
from node_testing import Diagnostics, folder_for, launch_for, output_of_refusal, wait_until
from rosgraph_msgs.msg import Clock
from safe_passage.msg import Person, PersonArray
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header
from visualization_msgs.msg import Marker, MarkerArray

TICK = 0.1  # s of simulated time
LEGS = [(1.5, -0.15), (1.5, 0.15)]
TOPIC = "/robot1/scan"
ERROR = 2  # diagnostics
LAUNCH = rospkg.RosPack().get_path("safe_passage") + "/launch/leg_detector.launch"


def message(stamp, legs=LEGS):
    scan = look(legs).scan
    return LaserScan(
        header=Header(frame_id="robot1/laser", stamp=stamp), angle_min=scan.angle_min,
        angle_max=-scan.angle_min, angle_increment=scan.angle_increment,
        range_min=scan.range_min, range_max=scan.range_max, ranges=scan.ranges.tolist(),
    )  # fmt: skip


class LegDetectorTest(unittest.TestCase):
    now = 1000.0  # s, simulated

    @classmethod
    def setUpClass(cls):
        cls.news = threading.Condition()
        cls.persons, cls.markers = {}, []
        cls.diagnostics = Diagnostics("robot1/leg_detector", cls.news)
        cls.clock_pub = rospy.Publisher("/clock", Clock, queue_size=10)
        cls.scan_pub = rospy.Publisher("scan", LaserScan, queue_size=10)
        rospy.Subscriber("persons", PersonArray, cls.on_persons)
        rospy.Subscriber("leg_detector/markers", MarkerArray, cls.on_markers)
        cls.model = make_leg_model(folder_for(cls))
        launch_for(cls, (LAUNCH, [f"model:={cls.model}"]))

    @classmethod
    def on_persons(cls, array):
        with cls.news:
            cls.persons[array.header.stamp] = array
            cls.news.notify_all()

    @classmethod
    def on_markers(cls, array):
        with cls.news:
            cls.markers.append(array)
            cls.news.notify_all()

    def tick(self):
        """The world goes on by a step; returns its time."""
        type(self).now += TICK
        stamp = rospy.Time.from_sec(self.now)
        self.clock_pub.publish(stamp)
        return stamp

    def see(self, legs=LEGS):
        """The first answer to a good scan."""
        sent = []

        def step():
            sent.append(self.tick())
            self.scan_pub.publish(message(sent[-1], legs))

        wait_until(
            self.news,
            lambda: any(stamp in self.persons for stamp in sent),
            lambda: f"persons; {self.diagnostics}",
            step,
        )
        return next(self.persons[stamp] for stamp in sent if stamp in self.persons)

    def assert_silent(self, reason, age=0.0, **changes):
        """A scan with `changes` is counted under `reason`; a good one is answered afterwards."""
        key = f"{TOPIC} {reason}"
        before, sent = self.diagnostics.count(key), []

        def step():
            sent.append(self.tick() - rospy.Duration.from_sec(age))
            scan = message(sent[-1])
            for name, value in changes.items():
                setattr(scan, name, value)
            self.scan_pub.publish(scan)

        wait_until(
            self.news,
            lambda: self.diagnostics.count(key) > before,
            lambda: f"{key}; {self.diagnostics}",
            step,
        )
        self.see()
        self.assertFalse([stamp for stamp in sent if stamp in self.persons], reason)

    def test_1_says_what_it_waits_for(self):
        wait_until(
            self.news,
            lambda: f"waiting for: {TOPIC}" in self.diagnostics.message(),
            lambda: f"'waiting for'; {self.diagnostics}",
            self.tick,
        )
        self.assertEqual(self.diagnostics.level(), ERROR)

    def test_2_a_person_between_two_legs(self):
        answer = self.see()
        self.assertEqual(answer.header.frame_id, "robot1/laser")
        (person,) = answer.persons
        self.assertAlmostEqual(person.position.x, 1.5, delta=0.1)
        self.assertAlmostEqual(person.position.y, 0.0, delta=0.05)
        self.assertAlmostEqual(person.position.z, -0.2)
        self.assertEqual(person.method, Person.METHOD_LEGS)
        self.assertGreaterEqual(person.confidence, 0.5)

    def test_3_nobody_is_said_too(self):
        self.assertEqual(self.see(legs=[]).persons, [])

    def test_4_markers_of_legs_and_person(self):
        def newest():
            return [marker.ns for marker in self.markers[-1].markers] if self.markers else []

        wait_until(self.news, lambda: len(newest()) == 4, lambda: f"markers; {newest()}", self.see)
        self.assertEqual(newest(), ["", "persons", "legs", "legs"])
        self.assertEqual(self.markers[-1].markers[0].action, Marker.DELETEALL)

    def test_5_bad_scans(self):
        beams = len(message(rospy.Time()).ranges)
        self.assert_silent("EMPTY", ranges=[])
        self.assert_silent("NOT_FINITE", ranges=[math.nan] * beams)
        self.assert_silent("BAD_FIELDS", header=Header())
        self.assert_silent("BAD_FIELDS", angle_increment=0.0)
        self.assert_silent("BAD_FIELDS", angle_min=math.inf)
        self.assert_silent("STALE", age=5.0)
        self.assert_silent("FUTURE", age=-5.0)
        self.see()
        self.assert_silent("OUT_OF_ORDER", age=0.25)

    def test_6_a_scan_without_returns_is_nobody(self):
        answers = len(self.persons)

        def step():
            scan = message(self.tick())
            scan.ranges = [math.inf, math.nan, 0.0, 1e9] * (len(scan.ranges) // 4)
            self.scan_pub.publish(scan)

        wait_until(self.news, lambda: len(self.persons) > answers, "an answer", step)
        self.assertEqual(self.persons[max(self.persons)].persons, [])

    def test_7_goes_on_after_the_clock_went_back(self):
        self.see()
        type(self).now = 10.0
        self.assertLess(self.see().header.stamp.to_sec(), 500.0)
        self.assertEqual(len(self.see().persons), 1)

    def test_8_wrong_parameters_are_refused(self):
        with tempfile.NamedTemporaryFile(suffix=".model") as broken:
            broken.write(b"no model")
            broken.flush()
            cases = (
                ("model", "", "names no file"),
                ("model", "/no/such/legs.model", "/no/such/legs.model: No such file"),
                ("model", broken.name, "is no leg model"),
                ("leg_threshold", "2.0", "must lie in"),
                ("lone_legs", "7", "must be true or false"),
                ("legs", "2", "is not known"),
            )
            for i, (name, value, said) in enumerate(cases):  # parameters stay: a new name each
                arguments = [f"_model:={self.model}"] if name != "model" else []
                arguments += [f"_{name}:={value}"] if value else []
                output = output_of_refusal("leg_detector", *arguments, f"__name:=refused_{i}")
                self.assertIn(f"parameter /robot1/refused_{i}/{name}", output)
                self.assertIn(said, output)
                if name == "model":
                    self.assertIn("train_leg_detector", output)


if __name__ == "__main__":
    rospy.init_node("test_leg_detector", disable_rostime=True)
    rostest.rosrun("safe_passage", "test_leg_detector", LegDetectorTest, sys.argv)
