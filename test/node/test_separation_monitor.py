#!/usr/bin/env python3
"""Node separation_monitor: slows down, stops, lets go; whatever is lost, it stops and says why."""

import math
import sys
import threading
import time
import unittest

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import Twist
from node_testing import Diagnostics, output_of_refusal, wait_until
from safe_passage.msg import SeparationState
from separation_world import BASE, TICK, World
from visualization_msgs.msg import Marker, MarkerArray

FREE, SLOW, STOP = SeparationState.FREE, SeparationState.SLOW, SeparationState.STOP
TIMEOUT = 0.4  # [s] of tracks and odometry, separation_monitor.yaml
COMMAND_TIMEOUT = 0.6  # [s]
SLACK = 3 * TICK  # [s] until the test sees what the node saw
PERIOD = 0.2  # [s] of the node's timer
NAMES = {
    value: name
    for name, value in vars(SeparationState).items()
    if name.isupper() and isinstance(value, int) and name not in ("FREE", "SLOW", "STOP")
}


class SeparationMonitorTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.news = threading.Condition()
        cls.states, cls.commands, cls.markers = [], [], []
        cls.diagnostics = Diagnostics("robot1/separation_monitor", cls.news)
        cls.world = World()
        for topic, kind, kept in (
            ("separation_monitor/state", SeparationState, cls.states),
            ("cmd_vel", Twist, cls.commands),
            ("separation_monitor/markers", MarkerArray, cls.markers),
        ):
            rospy.Subscriber(topic, kind, cls.keep, callback_args=kept)

    @classmethod
    def keep(cls, message, kept):
        with cls.news:
            kept.append(message)
            cls.news.notify_all()

    def setUp(self):
        self.world.calm()

    def wait(self, reached, what, step=None):
        wait_until(self.news, reached, lambda: f"{what}; {self.state()}; {self.diagnostics}", step)

    def state(self):
        return self.states[-1] if self.states else SeparationState()

    def see(self, without=(), **spoilt):
        """A step of the world, and the state that answers it."""
        stamp = self.world.tick(without, **spoilt)
        self.wait(lambda: self.states and self.state().header.stamp >= stamp, "a state")
        return self.state()

    def see_until(self, reached, what, most=80, **how):
        """Steps of the world until the state is so; returns how long it took [s]."""
        for k in range(most):
            if reached(self.see(**how)):
                return (k + 1) * TICK
        raise AssertionError(f"never {what}: {self.state()}")

    def be_free(self):
        """All is well, and the command passes unchanged."""
        took = self.see_until(lambda state: state.level == FREE, "free")
        self.assertEqual(NAMES[self.state().reason], "OK")
        self.wait_for_command(self.world.command)
        return took

    def wait_for_command(self, wanted):
        def came():
            return self.commands and np.allclose(parts(self.commands[-1]), wanted, atol=1e-6)

        self.wait(came, f"command {wanted}, not {self.commands[-1:]}", self.see)

    def assert_stops(self, reason, within, text="", **how):
        """For this reason, in time; and goes on by itself as soon as all is well."""
        self.be_free()
        took = self.see_until(lambda s: NAMES[s.reason] == reason, reason, **how)
        self.assertLessEqual(took, within + SLACK, reason)
        state = self.state()
        self.assertEqual((state.level, state.scale), (STOP, 0.0))
        self.assertIn(text, state.text)
        with self.news:
            sent = len(self.commands)
        self.see(**how)
        self.wait(lambda: len(self.commands) > sent, "a command", lambda: self.see(**how))
        self.assertEqual(parts(self.commands[-1]), (0.0, 0.0, 0.0))
        self.be_free()

    def test_1_waits_for_its_inputs_and_stands(self):
        def named():
            topics = ("tracks", "odom")
            said = self.diagnostics.message()
            waits = all(f"waiting for: /robot1/{t}" in said for t in topics)
            return waits and self.states and self.commands

        only = {"without": ("tf", "arm", "odom", "tracks")}
        self.wait(named, "'waiting for'", lambda: self.world.tick(**only))
        self.assertEqual(NAMES[self.state().reason], "NO_TRACKS")
        self.assertEqual(parts(self.commands[-1]), (0.0, 0.0, 0.0))
        self.see_until(lambda s: NAMES[s.reason] == "NO_ODOMETRY", "odometry", without=("odom",))
        self.assertEqual(parts(self.commands[-1]), (0.0, 0.0, 0.0))

    def test_2_a_free_way_changes_nothing(self):
        self.be_free()
        for command in ((0.5, 0.1, -0.3), (-0.4, 0.0, 0.0), (0.0, 0.0, 0.7)):
            self.world.command = command
            self.wait_for_command(command)
        state = self.state()
        self.assertEqual((state.header.frame_id, state.scale), (BASE, 1.0))
        self.assertTrue(math.isinf(state.time_to_collision))
        self.assertAlmostEqual(state.present_distance, math.hypot(7.4, 7.64), delta=0.25)

    def test_3_slow_stop_release(self):
        """Somebody comes nearer from ahead, stands, and leaves."""
        self.be_free()
        levels = []
        for x in np.arange(3.0, 0.95, -0.05):
            self.world.people = [(x, 0.0, 0.0, 0.0)]
            state = self.see()
            levels.append(state.level)
            self.assertEqual(NAMES[state.reason], "OK" if state.level == FREE else "OBSTACLE")
        self.assertEqual(sorted(levels), levels)
        self.assertEqual(set(levels), {FREE, SLOW, STOP})
        self.wait_for_command((0.0, 0.0, 0.0))
        state = self.state()
        self.assertEqual(state.obstacle_id, 1)
        self.assertGreater(state.required_distance, 0.3)
        self.assertAlmostEqual(state.present_distance, 1.0 - 0.6 - 0.17, delta=0.05)
        self.world.calm()
        self.assertGreaterEqual(self.be_free(), 0.2)

    def test_3_who_walks_towards_it_stops_it_from_afar(self):
        self.be_free()
        self.world.people = [(4.0, 0.0, -1.5, 0.0)]
        took = self.see_until(lambda s: s.level == STOP, "stopped")
        self.assertLessEqual(took, 2.0 * TICK)  # a cycle may come between the clock and the tracks
        state = self.state()
        self.assertAlmostEqual(state.time_to_collision, (3.4 - 0.17 - 0.25) / 2.0, delta=0.3)

    def test_3_leaving_is_allowed(self):
        self.be_free()
        self.world.people = [(0.9, 0.0, 0.0, 0.0)]
        self.see_until(lambda s: s.level == STOP, "stopped")
        self.world.command = (-0.2, 0.0, 0.0)
        self.wait_for_command((-0.2, 0.0, 0.0))
        self.see_until(lambda s: NAMES[s.reason] == "ESCAPE", "the state that told so")
        self.world.command = (0.2, 0.0, 0.0)
        self.wait_for_command((0.0, 0.0, 0.0))

    def test_3_tracks_alone_make_it_react(self):
        """Long before the timer, and without a new command."""
        took = []
        for _ in range(5):
            self.world.calm()
            self.be_free()
            self.world.people = [(1.0, 0.0, 0.0, 0.0)]
            with self.news:
                sent = len(self.commands)
            began = time.monotonic()
            self.world.send("tracks")

            def stopped(sent=sent):
                return any(parts(c) == (0.0, 0.0, 0.0) for c in self.commands[sent:])

            self.wait(stopped, "a stop", None)
            took.append(time.monotonic() - began)
        self.assertLess(min(took), 0.25 * PERIOD)

    def test_3_the_arm_counts(self):
        """A person whom the platform passes, under a hand that reaches out to the side."""
        self.be_free()
        self.world.people = [(1.5, 1.3, 0.0, 0.0)]
        for _ in range(5):
            self.assertEqual(self.see().level, FREE)

        def reach_out(message):
            message.transforms[1].transform.translation.y = 1.1

        self.see_until(lambda s: s.level != FREE, "limited", arm=reach_out)
        self.see_until(lambda s: s.level == FREE, "free")

    def test_4_the_path_counts_if_it_is_young_and_followed(self):
        aside = [(0.1 * i, 0.02 * i**1.5) for i in range(20)]
        self.be_free()
        self.world.people = [(2.2, 0.0, 0.0, 0.0)]
        self.world.command = (1.0, 0.0, 0.0)

        def state_with(points, **how):
            self.world.send_plan(points, **how)
            return self.see_until(lambda s: s.on_path, "on path", most=20) and self.state()

        self.see_until(lambda s: s.level == SLOW, "slow")
        self.assertFalse(self.state().on_path)
        self.assertTrue(state_with(aside).on_path)
        self.see_until(lambda s: s.level == FREE, "free")
        # left behind; then of an unknown frame; then old
        for points, how in (
            ([(0.0, 2.0), (3.0, 2.0)], {}),
            (aside, {"frame": "nowhere"}),
            (aside, {"age": 60.0}),
        ):
            state_with(aside)
            self.world.send_plan(points, **how)
            self.see_until(lambda s: not s.on_path, "off path", most=20)
            self.see_until(lambda s: s.level == SLOW, "slow")

    def test_5_silent_and_unusable_tracks_stop_it(self):
        self.assert_stops("STALE_TRACKS", TIMEOUT, without=("tracks",))

        def nan(array):
            array.obstacles[0].velocity.x = math.nan

        def no_frame(array):
            array.header.frame_id = ""

        def old(array):
            array.header.stamp -= rospy.Duration(5)

        def ahead(array):
            array.header.stamp += rospy.Duration(5)

        def torn(array):
            array.obstacles[0].cells_x = array.obstacles[0].cells_x[1:]

        for spoil, count in (
            (nan, "NOT_FINITE"),
            (no_frame, "BAD_FIELDS"),
            (old, "STALE"),
            (ahead, "FUTURE"),
            (torn, "BAD_FIELDS"),
        ):
            before = self.diagnostics.count(f"/robot1/tracks {count}")
            self.assert_stops("STALE_TRACKS", TIMEOUT, tracks=spoil)
            self.wait(
                lambda count=count, before=before: self.diagnostics.count(f"/robot1/tracks {count}")
                > before,
                count,
                self.see,
            )

    def test_5_a_silent_sensor_stops_it_unless_it_is_optional(self):
        def silent(name):
            def spoil(array):
                array.alive[array.sensors.index(name)] = False

            return spoil

        self.be_free()
        for _ in range(5):
            self.assertEqual(self.see(tracks=silent("camera")).level, FREE)
        self.assert_stops("SENSOR_SILENT", 0.0, "laser", tracks=silent("laser"))

    def test_5_silent_odometry_stops_it(self):
        self.assert_stops("STALE_ODOMETRY", TIMEOUT, without=("odom",))

    def test_5_odometry_that_is_no_number_stops_it(self):
        def nan(odometry):
            odometry.twist.twist.linear.x = math.nan

        self.assert_stops("STALE_ODOMETRY", TIMEOUT, odom=nan)

    def test_5_odometry_of_a_frame_that_nobody_knows_stops_it(self):
        def of_another_robot(odometry):
            odometry.child_frame_id = "robot2/base_link"

        self.assert_stops("STALE_ODOMETRY", TIMEOUT, odom=of_another_robot)

    def test_5_odometry_counts_in_the_frame_it_is_told_of(self):
        def of_the_shoulder(odometry):
            odometry.child_frame_id = "robot1/shoulder"

        self.be_free()
        for _ in range(20):
            self.assertEqual(self.see(odom=of_the_shoulder).level, FREE)

    def test_5_tf_gone_stops_it(self):
        self.assert_stops("NO_TF", TIMEOUT, "robot1/odom", without=("tf",))
        self.assert_stops("NO_TF", TIMEOUT, "robot1/shoulder", without=("arm",))

    def test_5_a_command_that_is_no_number_stops_it(self):
        for name in ("linear", "angular"):
            for part in "xyz":
                for value in (math.nan, math.inf, 1e308):

                    def spoil(twist, name=name, part=part, value=value):
                        setattr(getattr(twist, name), part, value)

                    self.see_until(
                        lambda s: NAMES[s.reason] == "BAD_COMMAND", "refused", command=spoil
                    )
        self.assert_stops("BAD_COMMAND", 0.0, command=spoil)

    def test_5_an_old_command_is_not_repeated(self):
        self.assert_stops("STALE_COMMAND", COMMAND_TIMEOUT, without=("command",))
        self.be_free()
        for _ in range(int((COMMAND_TIMEOUT + 0.5) / TICK) + 4):
            self.see(without=("command",))
        with self.news:
            sent = len(self.commands)
        for _ in range(5):
            self.see(without=("command",))
        self.assertEqual(len(self.commands), sent, "others may command now")

    def test_6_a_tracker_that_starts_anew_stops_it(self):
        self.be_free()
        for how in ("younger", "lower numbers"):
            if how == "lower numbers":
                self.be_shown_number(50)
                self.world.first_id = 3
            self.world.began = self.world.stamp.to_sec()
            self.world.tick()  # its tracks alone, however late they come
            self.wait(lambda: NAMES[self.state().reason] == "TRACKER_RESTARTED", "restarted")
            self.assertEqual(self.state().level, STOP)
            self.assertGreaterEqual(self.be_free(), 0.5 - SLACK)

    def be_shown_number(self, number):
        """A track of that number, so near that the state which answers it names it; then free."""
        self.world.first_id, self.world.people = number, [(1.0, 0.0, 0.0, 0.0)]
        self.see_until(lambda state: state.obstacle_id == number, f"number {number}")
        self.world.calm()
        self.world.first_id = number
        self.be_free()

    def test_7_the_clock_goes_back(self):
        self.be_free()
        self.world.set_back(20.0)
        self.world.began = 0.0
        nothing_yet = {"without": ("tf", "arm", "odom", "tracks")}
        self.wait(
            lambda: NAMES[self.state().reason] == "CLOCK_JUMP",
            "CLOCK_JUMP",
            lambda: self.world.tick(**nothing_yet),
        )
        self.assertLess(self.state().header.stamp.to_sec(), 50.0)
        self.wait_for_zero_since_jump()
        self.be_free()

    def wait_for_zero_since_jump(self):
        self.wait(
            lambda: parts(self.commands[-1]) == (0.0, 0.0, 0.0),
            "a stop",
            lambda: self.world.tick(without=("tf", "arm", "odom", "tracks")),
        )

    def test_8_the_picture_has_everything(self):
        self.be_free()
        self.world.people = [(1.6, -2.0, 0.0, 1.0)]
        names = {"present", "predicted", "robot", "way", "velocity", "state"}

        def complete():
            return self.markers and names <= {marker.ns for marker in self.markers[-1].markers}

        self.wait(complete, names, self.see)
        markers = self.markers[-1].markers
        self.assertEqual(markers[0].action, Marker.DELETEALL)
        self.assertEqual({marker.header.frame_id for marker in markers}, {BASE})
        self.assertTrue(all(marker.lifetime.to_sec() > 0 for marker in markers[1:]))

    def test_9_wrong_parameters_are_refused_by_name(self):
        round_one = "_robot_radius:=0.3"
        cases = (
            ([], "footprint: give either it or robot_radius"),
            ([round_one, "_odd:=1"], "/odd is not known"),
            ([round_one, "_horizon:=0.0"], "/horizon is 0.0, must lie in [0.2, 20.0] s"),
            ([round_one, "_worst_case:=3"], "/worst_case is 3, must be true or false"),
            ([round_one, "_arm_frames:=[{frame: a, odd: 1}]"], "/arm_frames[0]/odd is not known"),
        )
        for i, (arguments, said) in enumerate(cases):  # parameters stay: a new name each
            output = output_of_refusal("separation_monitor", *arguments, f"__name:=refused_{i}")
            self.assertIn(said, output)
            self.assertIn(f"/robot1/refused_{i}/", output)


def parts(twist):
    """(forward, left, turn)"""
    return twist.linear.x, twist.linear.y, twist.angular.z


if __name__ == "__main__":
    rospy.init_node("test_separation_monitor", disable_rostime=True)
    rostest.rosrun("safe_passage", "test_separation_monitor", SeparationMonitorTest, sys.argv)
