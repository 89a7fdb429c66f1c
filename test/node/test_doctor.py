#!/usr/bin/env python3
"""The doctor beside a running tracker: what it says while the world is well, and ill."""

import sys
import threading
import unittest

import rospy
import rostest
from node_testing import Diagnostics, output_of_refusal, wait_until
from safe_passage.doctor.checks import Severity, examine
from safe_passage.msg import TrackedObstacleArray
from safe_passage.ros.doctor_node import Doctor
from tracker_world import TICK, World

SECONDS = 2.0  # of the wall that the doctor listens
NO_ANSWER = 0.5  # [s] after which the tracker is not there yet
TRACKER = "/robot1/obstacle_tracker"


class DoctorTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.world, cls.news = World(), threading.Condition()
        cls.diagnostics = Diagnostics("robot1/obstacle_tracker", cls.news)
        cls.doctor = Doctor("robot1")
        cls.measure, cls.tf = cls.all_speak, True
        cls.ended, cls.answers = threading.Event(), 0
        rospy.Subscriber("tracks", TrackedObstacleArray, cls.on_tracks)
        cls.thread = threading.Thread(target=cls.go_on, daemon=True)
        cls.thread.start()

    @classmethod
    def tearDownClass(cls):
        cls.ended.set()
        cls.thread.join()

    @classmethod
    def on_tracks(cls, _):
        with cls.news:
            cls.answers += 1
            cls.news.notify_all()

    @classmethod
    def go_on(cls):
        """The world's time goes as the wall's does: the doctor listens for some of it.

        But not ahead of the tracker, whose answer to the last tick is awaited where there is one.
        """
        while not (cls.ended.wait(TICK) or rospy.is_shutdown()):
            before = cls.answers
            cls.measure(cls.world.tick(cls.tf))
            with cls.news:
                cls.news.wait_for(lambda known=before: cls.answers > known, NO_ANSWER)

    @classmethod
    def all_speak(cls, stamp):
        cls.world.measure(stamp)

    def setUp(self):
        type(self).measure, type(self).tf = self.all_speak, True
        wait_until(self.news, lambda: self.diagnostics.level() == 0, lambda: self.diagnostics)

    def findings(self):
        return examine(self.doctor.observe(SECONDS))

    def changed(self, **changes):
        """The front scanner speaks with another header."""

        def measure(stamp):
            self.world.measure(stamp, ["scan_rear", "camera/points"])
            message = self.world.message("scan_front", stamp)
            for name, value in changes.items():
                setattr(message.header, name, value(stamp))
            self.world.publish("scan_front", message)

        type(self).measure = staticmethod(measure)
        return [one for one in self.findings() if one.subject == "/robot1/scan_front"]

    def test_a_healthy_world(self):
        self.assertEqual([one for one in self.findings() if one.severity is Severity.FAULT], [])

    def test_a_frame_that_tf_does_not_know(self):
        (one,) = self.changed(frame_id=lambda stamp: "nowhere")
        self.assertIn("nowhere", one.what)

    def test_stamps_from_another_clock(self):
        (one,) = self.changed(stamp=lambda stamp: stamp - rospy.Duration(3.0))
        self.assertIn("s old", one.what)
        (one,) = self.changed(stamp=lambda stamp: stamp + rospy.Duration(3.0))
        self.assertIn("in the future", one.what)

    def test_a_sensor_that_falls_silent(self):
        type(self).measure = lambda stamp: self.world.measure(stamp, ["scan_rear"])
        wait_until(self.news, lambda: self.diagnostics.level() > 0, lambda: self.diagnostics)
        found = {one.subject: one for one in self.findings()}
        self.assertIs(found["/robot1/scan_front"].severity, Severity.FAULT)
        self.assertIn("silent", found["/robot1/scan_front"].what)
        self.assertIn(TRACKER, found)

    def test_the_command_says_it_and_exits_with_1(self):
        rospy.set_param("/robot1/bringup/nodes/separation_monitor", True)
        said = output_of_refusal("doctor", "robot1", "--seconds", "1")
        self.assertIn("/robot1/separation_monitor should run and does not", said)
        rospy.delete_param("/robot1/bringup/nodes/separation_monitor")


if __name__ == "__main__":
    rospy.init_node("test_doctor")
    rostest.rosrun("safe_passage", "test_doctor", DoctorTest, sys.argv)
