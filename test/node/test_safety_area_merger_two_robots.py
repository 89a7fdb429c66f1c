#!/usr/bin/env python3
"""Two robots on one master: a person seen by one is in the scan of that one only."""

import math
import sys
import threading
import unittest

import rospy
import rostest
from geometry_msgs.msg import Point
from node_testing import transform, wait_until
from rosgraph_msgs.msg import Log
from safe_passage.msg import Person, PersonArray
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

ROBOTS = ("robot1", "robot2")
LASER_X = 0.2  # [m] in base_link
FRONT, CLEARANCE = 0.8, 0.3  # [m] of the footprints; safety_area_merger.yaml
TO_OUTLINE = FRONT + CLEARANCE - LASER_X  # [m] from the laser to an area that is cut back to it
LATE = "robot2/late"  # the frame of robot2's footprint


class TwoRobotsTest(unittest.TestCase):
    def setUp(self):
        self.news = threading.Condition()
        self.answers = {}
        self.tf_pub = rospy.Publisher("/tf", TFMessage, queue_size=10)
        self.persons_pubs = {
            robot: rospy.Publisher(f"/{robot}/persons", PersonArray, queue_size=10)
            for robot in ROBOTS
        }
        self.warnings = []
        rospy.Subscriber("/rosout", Log, self.on_log)
        self.scan_pubs = {
            robot: rospy.Publisher(f"/{robot}/scan", LaserScan, queue_size=10) for robot in ROBOTS
        }
        for robot in ROBOTS:
            topic = f"/{robot}/scan_human_aware"
            rospy.Subscriber(topic, LaserScan, self.on_merged, callback_args=robot)

    def on_merged(self, message, robot):
        with self.news:
            self.answers[robot, message.header.stamp] = message
            self.news.notify_all()

    def on_log(self, log):
        if log.level == Log.WARN:
            with self.news:
                self.warnings.append(log)
                self.news.notify_all()

    def tell(self, stamp, ahead, seen_by, late_known):
        transforms = []
        if late_known:
            transforms.append(transform("robot2/base_link", LATE, stamp))
        for robot in ROBOTS:
            for parent, child, x in (("odom", "base_link", 0.0), ("base_link", "laser", LASER_X)):
                transforms.append(transform(f"{robot}/{parent}", f"{robot}/{child}", stamp, x))
        self.tf_pub.publish(transforms)
        persons = PersonArray(persons=[Person(position=Point(ahead, 0.0, 0.0))])
        persons.header.frame_id, persons.header.stamp = f"{seen_by}/base_link", stamp
        self.persons_pubs[seen_by].publish(persons)

    def range_ahead(self, robot, stamp):
        """None when nothing came back: nobody may be listening yet."""
        scan = LaserScan(angle_min=-math.pi / 2, angle_max=math.pi / 2, ranges=[10.0] * 181)
        scan.angle_increment = math.pi / 180
        scan.range_min, scan.range_max = 0.1, 20.0
        scan.header.frame_id, scan.header.stamp = f"{robot}/laser", stamp
        self.scan_pubs[robot].publish(scan)
        with self.news:
            self.news.wait_for(lambda: (robot, stamp) in self.answers, 0.5)
            answer = self.answers.get((robot, stamp))
        if answer is None:
            return None
        self.assertEqual(answer.header.frame_id, f"{robot}/laser")
        return answer.ranges[90]

    def ranges_with_a_person_at(self, ahead, expected, seen_by="robot1", late_known=False):
        """Of both robots, once the one that sees the person has nearly the range expected."""
        found = {}
        for _ in range(200):
            stamp = rospy.Time.now()
            self.tell(stamp, ahead, seen_by, late_known)
            found = {robot: self.range_ahead(robot, stamp) for robot in ROBOTS}
            if found[seen_by] is not None and abs(found[seen_by] - expected) < 0.1:
                break
        self.assertIsNotNone(found[seen_by])
        self.assertLess(found[seen_by], expected + 0.01)  # a transform may be late: never longer
        return found

    def test_each_robot_has_its_own_persons(self):
        found = self.ranges_with_a_person_at(3.0, 3.0 - LASER_X - 1.2)
        self.assertEqual(found["robot2"], 10.0)

    def test_an_area_is_cut_back_to_the_robots_outline(self):
        """Its front is 0.8 m before base_link: not the clearance before the laser, at 0.5 m."""
        found = self.ranges_with_a_person_at(1.6, TO_OUTLINE)
        self.assertGreater(found["robot1"], TO_OUTLINE - 0.01)

    def test_until_tf_knows_the_outlines_frame(self):
        """Areas stay, up to the laser's clearance, and no scan is lost; a warning says why."""
        self.ranges_with_a_person_at(1.6, CLEARANCE, "robot2")
        scans = 0

        def scan():
            nonlocal scans
            scans += 1
            stamp = rospy.Time.now()
            self.tell(stamp, 1.6, "robot2", late_known=False)
            found = self.range_ahead("robot2", stamp)
            self.assertIsNotNone(found, "a scan is lost")
            self.assertLess(found, CLEARANCE + 0.01)

        for _ in range(100):
            scan()
        wait_until(self.news, lambda: self.warned(LATE), f"a warning that names {LATE}", scan)
        self.assertLess(self.warned(LATE), scans / 10)
        found = self.ranges_with_a_person_at(1.6, TO_OUTLINE, "robot2", late_known=True)
        self.assertGreater(found["robot2"], TO_OUTLINE - 0.01)

    def warned(self, word):
        """How often robot2's node has warned of it."""
        return sum(
            word in log.msg and log.name == "/robot2/safety_area_merger" for log in self.warnings
        )


if __name__ == "__main__":
    rospy.init_node("test_safety_area_merger_two_robots")
    rostest.rosrun("safe_passage", "test_safety_area_merger_two_robots", TwoRobotsTest, sys.argv)
