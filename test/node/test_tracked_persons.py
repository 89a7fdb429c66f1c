#!/usr/bin/env python3
"""Persons on tracks: what a detector has seen once, tracker and merger keep and move along."""

import math
import sys
import threading
import unittest

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import Point, Vector3
from node_testing import Diagnostics, wait_until
from safe_passage.core.geometry import compose, matrix
from safe_passage.msg import Person, PersonArray, TrackedObstacle, TrackedObstacleArray
from safe_passage.ros.conversions import to_header
from sensor_msgs.msg import LaserScan
from tracker_world import BASE, ODOM, SENSORS, World

WALK_RADIUS, WALK_SPEED = 2.2, 1.0  # [m], [m/s]
RADIUS = 1.2  # [m] of a safety area
FRONT, CAMERA = "scan_front", "camera/points"
EVERY = 4  # steps between two answers of the detector
LATE = 2  # steps that it takes for one


class TrackedPersonsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.news = threading.Condition()
        cls.tracks, cls.tracked, cls.merged, cls.order = {}, {}, {}, []
        cls.diagnostics = Diagnostics("robot1/obstacle_tracker", cls.news)
        cls.world = World()
        cls.persons = rospy.Publisher("persons", PersonArray, queue_size=10)
        for topic, kind, kept in (
            ("tracks", TrackedObstacleArray, cls.tracks),
            ("tracked_persons", PersonArray, cls.tracked),
            ("scan_human_aware", LaserScan, cls.merged),
        ):
            rospy.Subscriber(topic, kind, cls.keep, callback_args=kept)

    @classmethod
    def keep(cls, message, kept):
        with cls.news:
            kept[message.header.stamp] = message
            if kept is cls.tracked:
                cls.order.append(message)
            cls.news.notify_all()

    def setUp(self):
        self.world.begin()
        self.steps, self.looks = 0, []  # stamps at which the detector has looked

    def wait(self, reached, what, step=None):
        wait_until(self.news, reached, lambda: f"{what}; {self.diagnostics}", step)

    def array(self, stamp, *places, frame=None):
        """What a detector says of persons at `places` (x, y) [m], odom, in the camera's frame."""
        T_camera_odom = np.linalg.inv(
            matrix(self.world.pose_after(self.world.since(stamp))) @ SENSORS[CAMERA].T_base_sensor
        )
        camera = self.world.frame(SENSORS[CAMERA].name)
        header = to_header(stamp, camera if frame is None else frame)
        message = PersonArray(header=header)
        for x, y in places:
            at = T_camera_odom @ (x, y, 0.0, 1.0)
            person = Person(position=Point(*at[:3]), confidence=0.9, method=Person.METHOD_YOLO)
            person.velocity = Vector3(math.nan, math.nan, math.nan)
            message.persons.append(person)
        return message

    def see(self, detector=False):
        """A step of the world; tracks and persons that answer it."""
        sent = []

        def step():
            stamp = self.world.tick()
            sent.append(stamp)
            self.looks.append(stamp)
            self.steps += 1
            if detector and self.steps % EVERY == 0 and len(self.looks) > LATE:
                then = self.looks[-1 - LATE]
                people = self.world.people_after(self.world.since(then))
                self.persons.publish(self.array(then, *people))
            self.world.measure(stamp)

        def answered():
            return [s for s in sent if s in self.tracks and s in self.tracked]

        step()
        self.wait(answered, "tracks and tracked persons", step)
        return self.tracked[answered()[0]]

    def walk(self, start, end, detected=math.inf):
        """Somebody goes round the robot; a detector sees it for so many seconds. Persons told."""

        def place(t):
            bearing = start + t * WALK_SPEED / WALK_RADIUS
            return [WALK_RADIUS * np.array([math.cos(bearing), math.sin(bearing)])]

        self.world.people_after = place
        while self.world.age < (end - start) * WALK_RADIUS / WALK_SPEED:
            yield self.see(detector=self.world.age < detected)

    def stand(self, place, seconds, detector=True):
        """Somebody stands there, a detector sees it for so long."""
        self.world.people_after = lambda _: [np.array(place)]
        end = self.world.age + seconds
        while self.world.age < end:
            array = self.see(detector)
        return array

    def one_at(self, array, place):
        """The tracked person there; that of the test before may be carried on elsewhere."""
        near = [p for p in array.persons if p.id and distance(p, place) < 0.5]
        self.assertTrue(near, f"nobody at {place}: {array.persons}")
        return min(near, key=lambda p: p.id)  # what appears beside it is told for a moment

    def test_1_without_a_detector_nobody_is_a_person(self):
        for array in self.walk(-0.6, 0.0, detected=0.0):
            self.assertEqual(array.persons, [])
            self.assertEqual(array.header.frame_id, ODOM)
        obstacles = self.tracks[array.header.stamp].obstacles
        self.assertEqual({o.classification for o in obstacles}, {TrackedObstacle.UNKNOWN})
        self.assertTrue(all(math.isnan(o.person_probability) for o in obstacles))
        self.assertNotIn("persons", self.diagnostics.message())

    def test_2_a_person_is_kept_and_followed_when_the_detector_is_silent(self):
        ids, errors, speeds, methods, ranges = set(), [], [], set(), []
        for array in self.walk(-0.8, 1.9, detected=2.0):
            age = self.world.since(array.header.stamp)
            (place,) = self.world.people_after(age)
            if age < 1.0:
                continue  # first somebody must be seen
            person = self.one_at(array, place)
            ids.add(person.id)
            errors.append(distance(person, place))
            if age < 1.9:
                continue
            if age > 2.7:
                methods.add(person.method)
                ranges.append(self.range_error(array.header.stamp, place))
            ahead = np.array([-place[1], place[0]]) / WALK_RADIUS * WALK_SPEED
            speeds.append(np.hypot(person.velocity.x - ahead[0], person.velocity.y - ahead[1]))
        self.assertEqual(len(ids), 1)
        self.assertEqual(methods, {Person.METHOD_TRACK})
        self.assertLess(np.median(errors), 0.15)
        self.assertLess(max(errors), 0.35)
        self.assertLess(np.median(speeds), 0.25)
        self.assertGreater(len(ranges), 50)
        self.assertLess(np.abs(ranges).max(), 0.35)
        (told,) = (o for o in self.tracks[array.header.stamp].obstacles if o.id in ids)
        self.assertEqual(told.classification, TrackedObstacle.PERSON)
        self.assertGreater(told.person_probability, 0.9)

    def range_error(self, stamp, place):
        """[m] of the merged scan's range towards the person: the near edge of its area."""
        self.wait(lambda: stamp in self.merged, "the merged scan")
        lidar, scan = SENSORS[FRONT], self.merged[stamp]
        at = lidar.T_base_sensor[:2, 3]
        yaw = math.atan2(lidar.T_base_sensor[1, 0], lidar.T_base_sensor[0, 0])
        x, y, _ = compose((0.0, 0.0, -yaw), (place[0] - at[0], place[1] - at[1], 0.0))
        beam = round((math.atan2(y, x) - scan.angle_min) / scan.angle_increment)
        return scan.ranges[beam] - (math.hypot(x, y) - RADIUS)

    def test_3_what_the_camera_sees_is_told_in_its_words(self):
        array = self.stand((2.5, 0.0), 2.0)
        person = self.one_at(array, (2.5, 0.0))
        self.assertEqual(person.method, Person.METHOD_YOLO)
        self.assertAlmostEqual(person.confidence, 0.9, places=5)

    def test_4_a_detection_without_a_track_is_passed_on(self):
        self.see()
        stamp = self.looks[-1]
        self.persons.publish(self.array(stamp, (3.0, -2.0)))

        def passed():
            return [p for array in self.order[-20:] for p in array.persons if not p.id]

        self.wait(passed, "a person without a track", self.see)
        (person,) = passed()
        self.assertAlmostEqual(person.position.x, 3.0, places=3)
        self.assertAlmostEqual(person.position.y, -2.0, places=3)
        self.assertTrue(math.isnan(person.velocity.x))

    def test_5_a_camera_that_sees_nobody_there_ends_the_label(self):
        person = self.one_at(self.stand((2.5, 0.2), 2.0), (2.5, 0.2))
        self.assertTrue(self.labelled(self.stand((2.5, 0.2), 3.0, detector=False), person.id))
        end = self.world.age + 8.0
        while self.world.age < end and self.labelled(self.order[-1], person.id):
            self.see()
            self.persons.publish(self.array(self.looks[-1]))
        self.assertFalse(self.labelled(self.order[-1], person.id))

    @staticmethod
    def labelled(array, number):
        return number in [p.id for p in array.persons]

    def test_6_bad_persons_are_dropped_with_a_reason_and_tracking_goes_on(self):
        def ago(seconds):
            return self.looks[-1] - rospy.Duration.from_sec(seconds)

        nan = math.nan
        cases = {
            "NOT_FINITE": lambda: self.array(ago(0.0), (nan, nan)),
            "NO_TF": lambda: self.array(ago(0.0), (3.0, 0.0), frame="no_such_frame"),
            "BAD_FIELDS": lambda: self.array(ago(0.0), (3.0, 0.0), frame=""),
            "STALE": lambda: self.array(ago(5.0), (3.0, 0.0)),
            "FUTURE": lambda: self.array(ago(-5.0), (3.0, 0.0)),
        }
        self.see()
        began = len(self.order)
        for reason, make in cases.items():
            key = f"/robot1/persons {reason}"
            before = self.diagnostics.count(key)

            def step(make=make):
                self.persons.publish(make())
                for _ in range(5):
                    self.see()

            self.wait(lambda k=key, b=before: self.diagnostics.count(k) > b, key, step)
        self.assertFalse([p for array in self.order[began:] for p in array.persons if not p.id])

    def test_7_without_a_cycle_there_is_silence(self):
        self.stand((2.5, 0.0), 1.0)
        last = self.world.measured
        silent = f"silent: /robot1/{FRONT}"

        def step():
            stamp = self.world.tick()
            self.persons.publish(self.array(stamp, (2.5, 0.0)))

        self.wait(lambda: silent in self.diagnostics.message(), silent, step)
        self.assertLessEqual(max(array.header.stamp for array in self.order), last)

    def test_8_labels_are_forgotten_when_the_clock_goes_back(self):
        self.assertTrue([p for p in self.stand((2.5, 0.0), 2.0).persons if p.id])
        self.world.set_back(10.0)
        self.looks = []
        array = self.stand((2.5, 0.0), 2.0, detector=False)
        self.assertLess(array.header.stamp.to_sec(), 50.0)
        self.assertEqual(array.persons, [])
        self.assertEqual(self.tracks[array.header.stamp].header.frame_id, BASE)


def distance(person, place):
    return math.hypot(person.position.x - place[0], person.position.y - place[1])


if __name__ == "__main__":
    rospy.init_node("test_tracked_persons", disable_rostime=True)
    rostest.rosrun("safe_passage", "test_tracked_persons", TrackedPersonsTest, sys.argv)
