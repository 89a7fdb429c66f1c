#!/usr/bin/env python3
"""Two robots on one master: a person seen by one is in the scan of that one only."""

import math
import sys
import threading
import unittest

import rospy
import rostest
from geometry_msgs.msg import Point, TransformStamped
from safe_passage.msg import Person, PersonArray
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

ROBOTS = ("robot1", "robot2")
LASER_X = 0.2  # [m] in base_link
FRONT, CLEARANCE = 0.8, 0.3  # [m] of robot1's footprint; safety_area_merger.yaml


class TwoRobotsTest(unittest.TestCase):
    def setUp(self):
        self.news = threading.Condition()
        self.answers = {}
        self.tf_pub = rospy.Publisher("/tf", TFMessage, queue_size=10)
        self.persons_pub = rospy.Publisher("/robot1/persons", PersonArray, queue_size=10)
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

    def tell(self, stamp, ahead):
        transforms = []
        for robot in ROBOTS:
            for parent, child, x in (("odom", "base_link", 0.0), ("base_link", "laser", LASER_X)):
                message = TransformStamped(child_frame_id=f"{robot}/{child}")
                message.transform.translation.x = x
                message.header.frame_id, message.header.stamp = f"{robot}/{parent}", stamp
                message.transform.rotation.w = 1.0
                transforms.append(message)
        self.tf_pub.publish(transforms)
        persons = PersonArray(persons=[Person(position=Point(ahead, 0.0, 0.0))])
        persons.header.frame_id, persons.header.stamp = "robot1/base_link", stamp
        self.persons_pub.publish(persons)

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

    def ranges_with_a_person_at(self, ahead, expected):
        """Of both robots, once the first one has nearly the range expected."""
        found = {}
        for _ in range(200):
            stamp = rospy.Time.now()
            self.tell(stamp, ahead)
            found = {robot: self.range_ahead(robot, stamp) for robot in ROBOTS}
            if found["robot1"] is not None and abs(found["robot1"] - expected) < 0.1:
                break
        self.assertIsNotNone(found["robot1"])
        self.assertLess(found["robot1"], expected + 0.01)  # a transform may be late: never longer
        return found

    def test_each_robot_has_its_own_persons(self):
        found = self.ranges_with_a_person_at(3.0, 3.0 - LASER_X - 1.2)
        self.assertEqual(found["robot2"], 10.0)

    def test_an_area_is_cut_back_to_the_robots_outline(self):
        """Its front is 0.8 m before base_link: not the clearance before the laser, at 0.5 m."""
        expected = FRONT + CLEARANCE - LASER_X
        found = self.ranges_with_a_person_at(1.6, expected)
        self.assertGreater(found["robot1"], expected - 0.01)


if __name__ == "__main__":
    rospy.init_node("test_safety_area_merger_two_robots")
    rostest.rosrun("safe_passage", "test_safety_area_merger_two_robots", TwoRobotsTest, sys.argv)
