#!/usr/bin/env python3
"""Node safety_area_merger: a scan comes out for every scan, whatever persons, tf and clock do."""

import math
import sys
import threading
import time
import unittest

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import Point, Vector3
from node_testing import OPTICAL, TIMEOUT, Diagnostics, output_of_refusal, transform
from rosgraph_msgs.msg import Clock
from safe_passage.msg import Person, PersonArray
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

LATE = 0.01  # m that a circle grows at most for the microseconds between a transform and a scan
AHEAD = 90  # beam 0 looks to -90 degrees, one beam a degree
LASER_X, CAMERA_X, CAMERA_Z = 0.2, 0.1, 1.0  # m on the robot


def person_at(x, y=0.0):
    """A person at (x, y) before the robot, told in the camera's optical frame."""
    nan = math.nan
    return Person(position=Point(-y, CAMERA_Z, x - CAMERA_X), velocity=Vector3(nan, nan, nan))


class SafetyAreaMergerTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.news = threading.Condition()
        cls.merged, cls.safety, cls.markers = {}, {}, None
        cls.diagnostics = Diagnostics("safety_area_merger", cls.news)
        cls.clock_pub = rospy.Publisher("/clock", Clock, queue_size=10)
        cls.tf_pub = rospy.Publisher("/tf", TFMessage, queue_size=100)
        cls.static_pub = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        cls.scan_pub = rospy.Publisher("scan", LaserScan, queue_size=1000, tcp_nodelay=True)
        cls.persons_pub = rospy.Publisher("persons", PersonArray, queue_size=100)
        cls.tracked_pub = rospy.Publisher("tracked_persons", PersonArray, queue_size=100)
        rospy.Subscriber("scan_human_aware", LaserScan, cls.on_merged, queue_size=1000)
        rospy.Subscriber("safety_area_merger/safety_scan", LaserScan, cls.on_safety)
        cls.static_pub.publish(
            [
                transform("base_link", "laser", rospy.Time(), LASER_X),
                transform("base_link", "camera", rospy.Time(), CAMERA_X, CAMERA_Z, OPTICAL),
            ]
        )
        cls.now = 1000.0
        cls.stamps = 0

    @classmethod
    def on_merged(cls, message):
        with cls.news:
            cls.merged[message.header.stamp] = message
            cls.news.notify_all()

    @classmethod
    def on_safety(cls, message):
        with cls.news:
            cls.safety[message.header.stamp] = message
            cls.news.notify_all()

    @classmethod
    def on_markers(cls, message):
        with cls.news:
            cls.markers = message
            cls.news.notify_all()

    # A hundred seconds later nothing of the last test is left.
    def setUp(self):
        self.set_clock(self.now + 100.0)

    def set_clock(self, now):
        type(self).now = now
        self.clock_pub.publish(rospy.Time.from_sec(now))

    def send_tf(self, x=0.0, at=None):
        at = rospy.Time.from_sec(self.now if at is None else at)
        self.tf_pub.publish([transform("odom", "base_link", at, x)])

    def send_persons(self, *persons, frame="camera", at=None):
        message = PersonArray(persons=list(persons))
        message.header.frame_id = frame
        message.header.stamp = rospy.Time.from_sec(self.now if at is None else at)
        self.persons_pub.publish(message)

    def make_scan(self, at=None):
        """A scan with a stamp of its own: a microsecond after the last one."""
        type(self).stamps += 1
        scan = LaserScan(range_min=0.1, range_max=20.0, ranges=[10.0] * 181)
        scan.angle_min, scan.angle_max = -math.pi / 2, math.pi / 2
        scan.angle_increment = math.pi / 180
        scan.intensities = [100.0] * 181
        scan.header.frame_id = "laser"
        whole = rospy.Time.from_sec(self.now if at is None else at)
        scan.header.stamp = whole + rospy.Duration(0, 1000 * self.stamps)
        return scan

    def wait(self, condition, what):
        with self.news:
            self.assertTrue(self.news.wait_for(condition, TIMEOUT), f"waited for {what}")

    def merge(self, scan):
        """What the node makes of one scan. The first ones may find nobody listening yet."""
        stamp = scan.header.stamp
        for _ in range(int(TIMEOUT)):
            self.clock_pub.publish(rospy.Time.from_sec(self.now))
            self.scan_pub.publish(scan)
            with self.news:
                if self.news.wait_for(lambda: stamp in self.merged, 1.0):
                    return self.merged[stamp]
        return self.fail("no scan came out")

    def ahead(self, at=None):
        return self.merge(self.make_scan(at)).ranges[AHEAD]

    def until(self, expected, tell, at=None):
        """Repeats `tell` and scans until the range ahead is the expected one."""
        end = time.monotonic() + TIMEOUT
        while time.monotonic() < end:
            tell()
            found = self.ahead(at)
            if abs(found - expected) < LATE:
                return
            with self.news:
                self.news.wait(0.01)
        self.fail(f"range ahead is {found}, not {expected}")

    def see_person(self, x=3.0):
        def tell():
            self.send_tf()
            self.send_persons(person_at(x))

        self.until(x - LASER_X - 1.2, tell)

    def counted(self, key):
        return self.diagnostics.count(key)

    def wait_counted(self, key, more_than):
        self.wait(lambda: self.counted(key) > more_than, f"{key} in the diagnostics")

    def test_every_scan_comes_out_without_persons_and_tf(self):
        self.ahead()
        scans = [self.make_scan() for _ in range(200)]
        for scan in scans:
            self.scan_pub.publish(scan)
        self.wait(lambda: all(s.header.stamp in self.merged for s in scans), "200 scans")
        for scan in scans:
            merged = self.merged[scan.header.stamp]
            self.assertEqual(merged.header.frame_id, "laser")
            self.assertEqual((merged.ranges, merged.intensities), ((10.0,) * 181, (100.0,) * 181))
        self.wait_counted("scan NO_TF", 199)

    def test_person_is_merged_with_safety_scan_and_markers(self):
        self.see_person(3.0)
        scan = self.make_scan()
        merged = self.merge(scan)
        self.assertAlmostEqual(merged.ranges[AHEAD], 1.6, delta=LATE)
        self.assertEqual(merged.intensities[AHEAD], 500.0)
        half = math.degrees(math.asin(1.2 / 2.8))
        for beam, value in enumerate(merged.ranges):
            self.assertEqual(value < 10.0, abs(beam - AHEAD) < half, f"beam {beam}")
        self.wait(lambda: scan.header.stamp in self.safety, "the safety scan")
        self.assertTrue(math.isinf(self.safety[scan.header.stamp].ranges[0]))
        self.assertAlmostEqual(self.safety[scan.header.stamp].ranges[AHEAD], 1.6, delta=LATE)

        subscriber = rospy.Subscriber("safety_area_merger/markers", MarkerArray, self.on_markers)
        for _ in range(100):
            self.ahead()
            with self.news:
                if self.news.wait_for(lambda: self.markers is not None, 0.2):
                    break
        subscriber.unregister()
        self.assertIsNotNone(self.markers, "no markers")
        first, disc, body = self.markers.markers
        self.assertEqual(first.action, Marker.DELETEALL)
        self.assertEqual((disc.header.frame_id, body.header.frame_id), ("laser", "odom"))
        self.assertAlmostEqual(disc.scale.x, 2.4, delta=2 * LATE)
        self.assertAlmostEqual(body.pose.position.x, 3.0, places=3)

    def test_person_stays_in_the_fixed_frame_while_the_robot_drives(self):
        self.see_person(3.0)
        self.set_clock(self.now + 0.5)
        self.until(1.6 - 0.4, lambda: self.send_tf(x=0.4))

    def test_person_is_held_then_dropped(self):
        self.see_person()
        empty = self.counted("persons OK")
        self.set_clock(self.now + 0.9)
        self.send_tf()
        self.send_persons()
        self.wait_counted("persons OK", empty)
        self.until(1.6, self.send_tf)
        self.set_clock(self.now + 0.2)
        self.until(10.0, self.send_tf)

    def send_tracked(self, x, vx, frame="odom", at=None):
        """A person at (x, 0) in odom with the velocity (vx, 0)."""
        tracked = Person(id=7, position=Point(x, 0.0, 0.0), velocity=Vector3(vx, 0.0, 0.0))
        tracked.method = Person.METHOD_TRACK
        message = PersonArray(persons=[tracked])
        message.header.frame_id = frame
        message.header.stamp = rospy.Time.from_sec(self.now if at is None else at)
        self.tracked_pub.publish(message)

    def test_a_tracked_person_is_merged_moved_and_held(self):
        """It walks up at 1 m/s; no detector has seen it."""

        def tell():
            self.send_tf()
            self.send_tracked(4.0, -1.0)

        self.until(4.0 - LASER_X - 1.2, tell)
        self.set_clock(self.now + 0.9)
        self.until(3.1 - LASER_X - 1.2, self.send_tf)
        self.set_clock(self.now + 0.2)
        self.until(10.0, self.send_tf)

    def test_a_tracked_person_whom_the_detector_sees_too_is_one(self):
        """The detection is older, and lies where the person was then."""

        def tell():
            self.send_tf(at=self.now - 0.3)
            self.send_tf()
            self.send_tracked(3.0, 1.0)
            self.send_persons(person_at(2.7), at=self.now - 0.3)

        before = self.counted("persons OUT_OF_ORDER")
        self.until(3.0 - LASER_X - 1.2, tell)
        for _ in range(10):
            tell()
            self.ahead()
        self.assertAlmostEqual(self.ahead(), 3.0 - LASER_X - 1.2, delta=LATE)
        self.assertEqual(self.counted("persons OUT_OF_ORDER"), before)

    def test_bad_tracked_persons_are_counted_by_their_own_topic(self):
        cases = {
            "STALE": lambda: self.send_tracked(3.0, 0.0, at=self.now - 5.0),
            "FUTURE": lambda: self.send_tracked(3.0, 0.0, at=self.now + 5.0),
            "BAD_FIELDS": lambda: self.send_tracked(3.0, 0.0, frame=""),
            "NOT_FINITE": lambda: self.send_tracked(math.nan, 0.0),
        }
        self.send_tf()
        for reason, tell in cases.items():
            key = f"tracked_persons {reason}"
            before = self.counted(key)
            tell()
            self.wait_counted(key, before)
        self.assertEqual(self.ahead(), 10.0)

    def test_bad_persons_are_counted_and_merged_by_nobody(self):
        self.send_tf()
        bad = {
            "STALE": lambda: self.send_persons(person_at(3), at=self.now - 1.5),
            "FUTURE": lambda: self.send_persons(person_at(3), at=self.now + 0.5),
            "BAD_FIELDS": lambda: self.send_persons(person_at(3), frame=""),
            "NOT_FINITE": lambda: self.send_persons(person_at(math.nan)),
        }
        for reason, send in bad.items():
            before = self.counted("persons " + reason)
            self.until(10.0, lambda send=send: [self.send_tf(), send()])
            self.wait_counted("persons " + reason, before)
            self.assertEqual(self.ahead(), 10.0, reason)
        self.until(
            1.6, lambda: [self.send_tf(), self.send_persons(person_at(math.nan), person_at(3))]
        )

    def test_persons_wait_for_the_transform_of_their_stamp(self):
        self.send_tf(at=self.now - 0.05)
        self.ahead()
        self.send_persons(person_at(3))
        self.until(1.6, self.send_tf)

    def test_persons_of_an_unknown_frame_are_counted(self):
        before = self.counted("persons NO_TF")
        self.send_persons(person_at(3), frame="nowhere")
        self.ahead()
        self.set_clock(self.now + 1.1)
        self.wait_counted("persons NO_TF", before)

    def test_late_tf_widens_the_circle_and_a_long_gap_ends_it(self):
        self.see_person(3.0)
        before = self.counted("scan NO_TF")
        # 0.1 s * (1 m/s + 2.8 m * 1 rad/s) = 0.38 m
        self.set_clock(self.now + 0.1)
        self.until(1.6 - 0.38, lambda: None)
        # 1 m at most; then the clearance of 0.3 m counts
        self.set_clock(self.now + 0.5)
        self.until(0.6, lambda: None)
        self.wait_counted("scan NO_TF", before)
        self.set_clock(self.now + 0.5)
        self.until(10.0, lambda: None)

    def test_clock_that_goes_back(self):
        self.see_person()
        self.set_clock(self.now - 50.0)
        self.until(10.0, lambda: None)
        self.see_person(4.0)

    def test_a_small_step_back_forgets_nobody(self):
        self.see_person()
        self.set_clock(self.now - 0.02)
        self.assertLess(self.ahead(), 1.61)

    def test_scans_without_meaning_come_out_as_they_are(self):
        self.see_person()
        before = self.counted("scan BAD_FIELDS"), self.counted("scan EMPTY")
        still = self.make_scan()
        still.angle_increment = 0.0
        self.assertEqual(self.merge(still).ranges, (10.0,) * 181)
        empty = self.make_scan()
        empty.ranges, empty.intensities = [], []
        self.assertEqual(self.merge(empty).ranges, ())
        nowhere = self.make_scan()
        nowhere.header.frame_id = ""
        self.assertEqual(self.merge(nowhere).ranges, (10.0,) * 181)
        holes = self.make_scan()
        holes.ranges = [math.nan] * 181
        ranges = np.array(self.merge(holes).ranges)
        self.assertAlmostEqual(ranges[AHEAD], 1.6, delta=LATE)
        self.assertTrue(math.isnan(ranges[0]))
        self.wait_counted("scan BAD_FIELDS", before[0])
        self.wait_counted("scan EMPTY", before[1])

    def test_scans_of_another_time_still_get_the_persons(self):
        before = self.counted("scan STALE"), self.counted("scan FUTURE")
        self.see_person()
        old, ahead = self.make_scan(at=self.now - 50), self.make_scan(at=self.now + 50)
        never, end = self.make_scan(at=1.0), self.make_scan(at=4e9)
        for scan in (old, ahead, never, end):
            self.assertAlmostEqual(self.merge(scan).ranges[AHEAD], 1.6, delta=LATE)
        self.wait_counted("scan STALE", before[0])
        self.wait_counted("scan FUTURE", before[1])

    def test_silent_detector_is_a_warning(self):
        self.ahead()

        def warned():
            message = self.diagnostics.message("safety areas")
            return self.diagnostics.level("safety areas") == 1 and "persons silent" in message

        self.wait(warned, "the warning")

    def test_unknown_parameter_is_refused_by_name(self):
        for argument in ("_radus:=1.0", "_radius:=-1.0", "_inside_policy:=jump"):
            name = argument[1:].split(":=")[0]
            output = output_of_refusal("safety_area_merger", argument, f"__name:=refused_{name}")
            self.assertIn(f"/refused_{name}/{name}", output)


if __name__ == "__main__":
    rospy.init_node("test_safety_area_merger", disable_rostime=True)
    rostest.rosrun("safe_passage", "test_safety_area_merger", SafetyAreaMergerTest, sys.argv)
