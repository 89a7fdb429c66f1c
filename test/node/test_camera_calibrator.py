#!/usr/bin/env python3
"""Node camera_calibrator: the camera's pose against truth, refusals, preemption, lost inputs."""

import os
import sys
import tempfile
import threading
import unittest
from pathlib import Path

import actionlib
import numpy as np
import rospy
import rostest
import tf2_ros
import yaml
from actionlib_msgs.msg import GoalStatus
from arm_world import ARM, box_arm
from geometry_msgs.msg import Point, Quaternion
from node_testing import TIMEOUT, Diagnostics, output_of_refusal, wait_until
from safe_passage.evaluation.calibration_trials import errors
from safe_passage.msg import CalibrateCameraAction, CalibrateCameraGoal
from safe_passage.ros.conversions import from_transform
from sensor_msgs.msg import PointCloud2

NAME = "/robot1/camera_calibrator"
SHOWN = "before/sensor", "before/reference", "after/sensor", "after/reference"
POSES = 5
PATIENCE = rospy.Duration(4 * TIMEOUT)


class CameraCalibratorTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.news = threading.Condition()
        cls.shown, cls.feedback = {}, []
        cls.diagnostics = Diagnostics(NAME, cls.news)
        for name in SHOWN:
            rospy.Subscriber(f"{NAME}/{name}", PointCloud2, cls.note, name)
        cls.world = box_arm()
        cls.world.without = {"info"}  # until the first test has been refused for it
        cls.thread = threading.Thread(target=cls.world.run, daemon=True)
        cls.thread.start()
        wait_until(cls.news, rospy.get_time, "the clock", lambda: None)
        cls.client = actionlib.SimpleActionClient(f"{NAME}/calibrate", CalibrateCameraAction)
        assert cls.client.wait_for_server(rospy.Duration(TIMEOUT))
        cls.tf = tf2_ros.Buffer()
        cls.listener = tf2_ros.TransformListener(cls.tf)
        cls.folder = tempfile.TemporaryDirectory()

    @classmethod
    def tearDownClass(cls):
        cls.world.stop()
        cls.thread.join()
        cls.folder.cleanup()

    @classmethod
    def note(cls, message, name):
        with cls.news:
            cls.shown[name] = message
            cls.news.notify_all()

    def setUp(self):
        self.output = Path(self.folder.name) / self.id().rsplit(".", 1)[-1]

    def tearDown(self):
        self.world.without = set()

    def ask(self, **values):
        """A goal's result and how it ended."""
        self.send(**values)
        self.assertTrue(self.client.wait_for_result(PATIENCE), str(self.diagnostics))
        return self.client.get_result(), self.client.get_state()

    def send(self, **values):
        def note(feedback):
            with self.news:
                self.feedback.append(feedback)
                self.news.notify_all()

        self.feedback.clear()
        goal = CalibrateCameraGoal(
            **{"poses": POSES, "timeout": 60.0, "output_folder": str(self.output), **values}
        )
        self.client.send_goal(goal, feedback_cb=note)

    def assert_refused(self, verdict, *words, **values):
        result, state = self.ask(**values)
        self.assertEqual(result.verdict, verdict, result.why)
        self.assertFalse(result.success)
        self.assertEqual(state, GoalStatus.ABORTED)
        for word in words:
            self.assertIn(word, result.why)
        self.assertFalse(self.output.exists() and os.listdir(self.output))

    def test_1_without_model_or_camera_info_it_names_them(self):
        self.assert_refused("NO_INPUT", "/robot1/robot_description")
        rospy.set_param("robot_description", "<robot")
        self.assert_refused("NO_INPUT", "/robot1/robot_description")
        rospy.set_param("robot_description", ARM)
        self.assert_refused("NO_INPUT", "/robot1/depth/camera_info")

    def test_2_the_camera_is_where_it_is(self):
        result, state = self.ask()
        self.assertTrue(result.success, result.why)
        self.assertEqual(state, GoalStatus.SUCCEEDED)
        self.assertEqual(result.transform.header.frame_id, self.world.root)
        self.assertEqual(result.transform.child_frame_id, self.world.frame)
        shift, turn = errors(from_transform(result.transform), self.world.T_root_camera)
        self.assertLess(shift, 0.005)
        self.assertLess(turn, np.radians(0.4))
        self.assertLess(result.rms, 0.007)
        self.assertEqual(len(result.pose_rms), POSES)
        self.assertEqual(len(result.eigenvalues), 6)
        self.assertTrue(result.weakest)
        self.assertEqual({Path(one).name for one in result.files}, set(os.listdir(self.output)))
        written = yaml.safe_load((self.output / "camera.yaml").read_text())
        self.assertAlmostEqual(
            written["translation"]["x"], result.transform.transform.translation.x, places=5
        )
        self.assertLessEqual({"waiting", "calibrating"}, {one.stage for one in self.feedback})
        self.assertGreater(max(one.valid_share for one in self.feedback), 0.5)
        wait_until(
            self.news,
            lambda: all(name in self.shown and self.shown[name].width > 500 for name in SHOWN),
            lambda: f"clouds: { {name: one.width for name, one in self.shown.items()} }",
        )
        self.assertEqual(self.shown["after/sensor"].header.frame_id, self.world.root)
        self.assertEqual(self.shown["before/sensor"].header.frame_id, "calibration_before")
        T_view_before, T_view_root = map(self.in_view, ("calibration_before", self.world.root))
        camera = T_view_root @ self.world.T_root_camera
        self.assertGreater(camera[0, 3], 0.5)  # the view looks from the camera's side
        self.assertGreater(camera[1, 0], 0.5)  # and has to the right what the camera has there,
        self.assertLess(T_view_before[1, 3], -0.5)  # "before" to the left
        self.assertGreater(T_view_root[1, 3], 0.5)

    def in_view(self, frame):
        return from_transform(self.tf.lookup_transform("calibration_view", frame, rospy.Time()))

    def test_3_a_camera_that_looks_away_gives_no_result(self):
        result, state = self.ask(
            guess_given=True, guess=pose(1.2, 0.5, 5.0, Quaternion(0.0, 0.0, 0.0, 1.0))
        )
        self.assertFalse(result.success, result.why)
        self.assertIn(result.verdict, ("NOT_SEEN", "NOT_CONVERGED", "FEW_INLIERS"))
        self.assertEqual(state, GoalStatus.ABORTED)
        self.assertFalse(os.listdir(self.output))
        self.assertEqual(list(result.files), [])

    def test_4_goals_that_make_no_sense(self):
        self.assert_refused("BAD_GOAL", "must be absolute", output_folder="here")
        self.assert_refused("BAD_GOAL", "/proc/nowhere", output_folder="/proc/nowhere")
        result, _ = self.ask(output_folder="/proc")  # is there, and nothing can be made in it
        self.assertEqual(result.verdict, "BAD_GOAL", result.why)
        for name, value in (
            ("timeout", float("nan")), ("timeout", 3e38), ("timeout", -1.0), ("poses", 10**6),
        ):  # fmt: skip
            self.assert_refused("BAD_GOAL", name, **{name: value})
        wrong = pose(1.0, 0.0, 0.0, Quaternion(0.0, 0.0, 0.0, 0.0))
        self.assert_refused("BAD_GOAL", "guess", guess_given=True, guess=wrong)

    def test_5_a_lost_input_is_named(self):
        for lost, words in (
            ("joints", ("/robot1/joint_states", "joint a")),
            ("image", ("/robot1/depth/image_rect",)),
        ):
            self.world.without = {lost}
            self.assert_refused("NO_INPUT", *words)
        self.world.without = {"tf"}
        # what tf knew is older than the images by now
        wait_until(self.news, self.no_guess, lambda: "a refusal without tf", lambda: None)

    def no_guess(self):
        result, _ = self.ask(poses=1, timeout=0.2)
        return result.verdict == "NO_GUESS" and self.world.frame in result.why

    def test_6_an_arm_that_is_held_in_too_few_poses(self):
        self.assert_refused("TOO_FEW_POSES", "of 5 poses", timeout=1.0)

    def until_feedback(self, reached, what):
        """Wait for a feedback of the last goal."""
        wait_until(
            self.news,
            lambda: any(map(reached, list(self.feedback))),
            lambda: f"{what}; {self.diagnostics}",
        )

    def assert_ended(self, state, verdict):
        """The last goal ends so, and has written nothing."""
        self.assertTrue(self.client.wait_for_result(PATIENCE))
        result = self.client.get_result()
        self.assertEqual(result.verdict, verdict, result.why)
        self.assertEqual(self.client.get_state(), state)
        self.assertFalse(self.output.is_dir() and os.listdir(self.output))

    def test_7_cancelled(self):
        for stage, poses in (("waiting", 50), ("calibrating", 3)):
            self.send(poses=poses)
            self.until_feedback(lambda one, at=stage: one.stage == at and one.poses > 0, stage)
            self.client.cancel_goal()
            self.assert_ended(GoalStatus.PREEMPTED, "CANCELLED")

    def test_8_a_folder_that_is_gone_when_it_is_needed(self):
        self.send()
        self.until_feedback(lambda one: one.stage == "waiting", "waiting")
        self.output.rmdir()
        self.output.write_text("a file, where the folder was")
        self.assert_ended(GoalStatus.ABORTED, "NOT_WRITTEN")

    def test_9_a_clock_that_goes_back_ends_the_goal_and_the_next_works(self):
        self.send(poses=50)
        self.until_feedback(lambda one: one.poses > 0, "a pose")
        self.world.begin -= 900.0
        self.assert_ended(GoalStatus.ABORTED, "INTERRUPTED")
        result, _ = self.ask()
        self.assertTrue(result.success, result.why)

    def test_9_wrong_parameters(self):
        for i, (name, value) in enumerate((("poses", "0"), ("method", "NDT"), ("arm", "1"))):
            output = output_of_refusal("camera_calibrator", f"_{name}:={value}", f"__name:=no_{i}")
            self.assertIn(f"parameter /robot1/no_{i}/{name}", output)
        output = output_of_refusal("camera_calibrator", "_diagnostic_period:=0", "__name:=no")
        self.assertIn("diagnostic_period is 0", output)


def pose(x, y, z, turn):
    goal = CalibrateCameraGoal().guess
    goal.position, goal.orientation = Point(x, y, z), turn
    return goal


if __name__ == "__main__":
    rospy.init_node("test_camera_calibrator")  # goals are stamped by the simulated clock
    rostest.rosrun("safe_passage", "test_camera_calibrator", CameraCalibratorTest, sys.argv)
