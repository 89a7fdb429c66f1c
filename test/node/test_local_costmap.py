#!/usr/bin/env python3
"""Node local_costmap: a circle comes and goes, and nothing false is published on bad input."""

import math
import sys
import threading
import time
import unittest

import numpy as np
import rospkg
import rospy
import rostest
from geometry_msgs.msg import PolygonStamped
from map_msgs.msg import OccupancyGridUpdate
from nav_msgs.msg import OccupancyGrid
from node_testing import LETHAL, TIMEOUT, CostmapView, Diagnostics, transform
from rosgraph_msgs.msg import Clock
from sensor_msgs import point_cloud2
from sensor_msgs.msg import LaserScan, PointCloud2
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

TICK = 0.05  # s of simulated time
BEAMS, ANGLE_MIN, INCREMENT = 541, -math.radians(135), math.radians(0.5)
OPEN = np.full(BEAMS, np.inf)
ODOM, BASE, LASER = "robot1/odom", "robot1/base_link", "robot1/laser"


def circle_ahead(distance=2.5, radius=1.2):
    angles = ANGLE_MIN + np.arange(BEAMS) * INCREMENT
    offset = distance * np.sin(angles)
    seen = (np.abs(offset) < radius) & (np.cos(angles) > 0)
    near = distance * np.cos(angles) - np.sqrt(np.where(seen, radius**2 - offset**2, 0.0))
    return np.where(seen, near, OPEN)


def make_scan(ranges, frame, stamp):
    return LaserScan(
        header=Header(frame_id=frame, stamp=stamp), angle_min=ANGLE_MIN, angle_max=-ANGLE_MIN,
        angle_increment=INCREMENT, range_min=0.05, range_max=20.0, ranges=list(ranges),
    )  # fmt: skip


class LocalCostmapTest(unittest.TestCase):
    now = 100.0  # s, simulated

    @classmethod
    def setUpClass(cls):
        cls.news = threading.Condition()
        cls.footprint = None
        cls.map = CostmapView("local_costmap/costmap", cls.news)
        cls.diagnostics = Diagnostics("robot1/local_costmap", cls.news)
        cls.clock_pub = rospy.Publisher("/clock", Clock, queue_size=10)
        cls.tf_pub = rospy.Publisher("/tf", TFMessage, queue_size=100)
        cls.scan_pub = rospy.Publisher("scan_human_aware", LaserScan, queue_size=100)
        cls.cloud_pub = rospy.Publisher("depth/points", PointCloud2, queue_size=100)
        rospy.Subscriber("local_costmap/footprint", PolygonStamped, cls.on_footprint)

    @classmethod
    def on_footprint(cls, message):
        cls.footprint = message

    def tick(self, ranges=None, tf=True, frame=LASER, age=0.0, robot_x=0.0):
        """One step of the world: clock, pose, scan; then a moment for the node."""
        LocalCostmapTest.now += TICK
        stamp = rospy.Time.from_sec(self.now)
        self.clock_pub.publish(stamp)
        if tf:
            poses = transform(ODOM, BASE, stamp, robot_x), transform(BASE, LASER, stamp, 0.2, 0.3)
            self.tf_pub.publish(poses)
        if ranges is not None:
            self.scan_pub.publish(make_scan(ranges, frame, stamp - rospy.Duration(age)))
        with self.news:
            self.news.wait(0.02)

    def until(self, reached, what, **world):
        """Let the world go on until `reached`."""
        end = time.monotonic() + TIMEOUT
        while not reached():
            self.assertLess(time.monotonic(), end, f"waited in vain for {what}; {self.diagnostics}")
            self.tick(**world)

    def lethal(self):
        return len(self.map.lethal())

    def count(self, outcome, source="/robot1/scan_human_aware"):
        return self.diagnostics.count(f"{source} {outcome}")

    def summary(self):
        return self.diagnostics.message()

    def see_circle(self):
        self.until(lambda: self.lethal() > 20, "the circle", ranges=circle_ahead())

    def see_nothing(self):
        self.until(
            lambda: self.map.grid is not None and not self.lethal(), "no circle", ranges=OPEN
        )

    def test_1_waits_for_its_inputs_and_says_so(self):
        self.until(lambda: "waiting for: robot pose" in self.summary(), "diagnostics", tf=False)
        self.assertIn("waiting for: /robot1/scan_human_aware", self.summary())
        self.assertIsNone(self.map.grid)

    def test_2_circle_comes_and_goes(self):
        self.see_circle()
        self.assertEqual(self.map.header.frame_id, ODOM)
        self.assertEqual(self.map.grid.shape, (160, 160))
        self.assertAlmostEqual(self.map.info.resolution, 0.05)
        nearest = self.map.lethal()[:, 0].min()
        self.assertAlmostEqual(nearest, 0.2 + 2.5 - 1.2, delta=0.06)
        self.see_nothing()

    def test_3_sends_updates_of_a_part_and_the_footprint(self):
        self.see_nothing()
        before = self.map.whole_maps
        many = self.map.maps + 5
        self.until(lambda: self.map.maps >= many, "updates", ranges=OPEN)
        self.assertEqual(self.map.whole_maps, before)
        moved = self.map.whole_maps + 1
        self.until(lambda: self.map.whole_maps >= moved, "a whole map", ranges=OPEN, robot_x=1.0)
        self.assertEqual(self.footprint.header.frame_id, ODOM)
        self.assertAlmostEqual(max(p.x for p in self.footprint.polygon.points), 1.37, places=4)
        self.until(lambda: self.map.info.origin.position.x < -3.5, "the way back", ranges=OPEN)

    def test_4_point_clouds_mark(self):
        self.see_nothing()
        stamp = rospy.Time.from_sec(self.now)
        points = [(1.5, 0.2, 0.5), (1.5, 0.3, 5.0), (math.nan, 0.0, 0.5)]
        cloud = point_cloud2.create_cloud_xyz32(Header(frame_id=BASE, stamp=stamp), points)
        self.cloud_pub.publish(cloud)
        self.until(lambda: self.lethal() == 1, "one lethal cell")
        nothing = point_cloud2.create_cloud_xyz32(cloud.header, [(9.0, 0.0, 0.5)])
        self.cloud_pub.publish(nothing)
        self.see_nothing()
        no_z = PointCloud2(header=cloud.header, fields=cloud.fields[:2], width=1, height=1)
        self.cloud_pub.publish(no_z)
        self.until(lambda: self.count("BAD_FIELDS", "/robot1/depth/points"), "a dropped cloud")

    def test_5_bad_scans_are_dropped_with_a_reason(self):
        self.until(lambda: self.count("NOT_FINITE"), "NOT_FINITE", ranges=np.full(BEAMS, np.nan))
        self.until(lambda: self.count("EMPTY"), "EMPTY", ranges=[])
        self.until(lambda: self.count("NO_TF"), "NO_TF", ranges=OPEN, frame="no_such_frame")
        self.until(lambda: self.count("STALE"), "STALE", ranges=OPEN, age=5.0)
        self.until(lambda: self.count("FUTURE"), "FUTURE", ranges=OPEN, age=-5.0)
        self.until(lambda: self.count("OUT_OF_ORDER"), "OUT_OF_ORDER", **self.swapped())
        self.see_circle()

    def swapped(self):
        self.tick(ranges=OPEN)
        return {"ranges": OPEN, "age": 0.2}

    def test_6_publishes_nothing_while_the_pose_is_unknown(self):
        self.see_circle()
        for _ in range(20):  # past transform_tolerance and whatever was under way
            self.tick(ranges=OPEN, tf=False)
        silent = self.map.maps
        for _ in range(20):
            self.tick(ranges=OPEN, tf=False)
        self.assertEqual(self.map.maps, silent)
        self.assertGreater(self.lethal(), 20)
        self.until(lambda: "silent: robot pose" in self.summary(), "an error", tf=False)
        self.see_nothing()

    def test_7_starts_anew_when_the_clock_goes_back(self):
        self.see_circle()
        LocalCostmapTest.now = 10.0
        self.until(
            lambda: self.map.maps and self.map.header.stamp.to_sec() < 50, "a map of the new time"
        )
        self.assertEqual(self.lethal(), 0)
        self.see_circle()
        self.see_nothing()

    @unittest.skipIf("move_base" in rospkg.RosPack().list(), "the real move_base is installed")
    def test_8_stands_in_for_move_base_of_another_robot(self):
        theirs = []
        topic = "/robot2/move_base/local_costmap/costmap"
        rospy.Subscriber(topic, OccupancyGrid, theirs.append)
        rospy.Subscriber(topic + "_updates", OccupancyGridUpdate, theirs.append)
        scan_pub = rospy.Publisher("/robot2/scan_human_aware", LaserScan, queue_size=1)
        end = time.monotonic() + TIMEOUT
        while not theirs or LETHAL not in theirs[-1].data:
            self.assertLess(time.monotonic(), end, "waited in vain for the second robot")
            self.tick(ranges=OPEN)
            stamp = rospy.Time.from_sec(self.now)
            self.tf_pub.publish([transform("robot2/odom", "robot2/base_link", stamp)])
            scan_pub.publish(make_scan(circle_ahead(), "robot2/base_link", stamp))
        self.assertEqual(theirs[-1].header.frame_id, "robot2/odom")
        self.see_nothing()


if __name__ == "__main__":
    rospy.init_node("test_local_costmap", disable_rostime=True)
    rostest.rosrun("safe_passage", "test_local_costmap", LocalCostmapTest, sys.argv)
