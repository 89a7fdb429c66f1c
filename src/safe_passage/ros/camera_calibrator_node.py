"""Node `camera_calibrator`: a depth camera's pose on the robot, while somebody moves the arm."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from pathlib import Path

import actionlib
import numpy as np
import rospy
import tf2_ros
from sensor_msgs.msg import Image

from safe_passage.calibration import ArmCalibrator, ArmView, Calibration, Verdict
from safe_passage.calibration.collecting import PoseCollector
from safe_passage.calibration.writers import write
from safe_passage.core.depth_image import metres
from safe_passage.core.errors import InputError
from safe_passage.core.reading import build
from safe_passage.msg import (
    CalibrateCameraAction,
    CalibrateCameraFeedback,
    CalibrateCameraGoal,
    CalibrateCameraResult,
)
from safe_passage.robot_model import JointHistory, PinholeCamera, RobotModel
from safe_passage.ros.actions import RefusedError, forget_goals, survive_clock_jumps
from safe_passage.ros.arm_inputs import ArmInputs
from safe_passage.ros.calibration_outputs import CalibrationOutputs, to_result
from safe_passage.ros.calibrator_goals import arm_of, check_goal, folder_of, guess_of
from safe_passage.ros.calibrator_parameters import CalibratorNodeParameters
from safe_passage.ros.conversions import from_transform
from safe_passage.ros.depth_conversions import from_depth_image
from safe_passage.ros.diagnostics import NodeDiagnostics
from safe_passage.ros.input_loop import LOOK_ROUND, rounds
from safe_passage.ros.parameters import private_values
from safe_passage.ros.sensor_input import InputLimits, Received, SensorInput

JOINT_TOLERANCE = 0.05  # [s] that joint states may end before an image's stamp
CANCELLED = "CANCELLED"


@dataclass(frozen=True)
class _Seen:
    """An image, and the arm at its stamp and some time before."""

    stamp: rospy.Time
    frame: str
    pixels: np.ndarray
    camera: PinholeCamera
    before: dict[str, float]
    now: dict[str, float]
    arrived: float  # [s] monotonic


class CameraCalibratorNode:
    """Calibrates on demand, one goal at a time; a failure writes nothing and says why."""

    def __init__(self) -> None:
        self._p = p = build(CalibratorNodeParameters, private_values(), rospy.get_name())
        self._news = threading.Event()
        self._state = threading.Condition()  # of what the goal's thread and the main one share
        self._collector: PoseCollector | None = None
        self._seen: _Seen | None = None
        self._valid_share, self._jumped = 0.0, False
        self._model: RobotModel | None = None
        self._diagnostics = NodeDiagnostics(p.input_timeout)
        self._tf = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._tf)
        self._outputs = CalibrationOutputs(p.before_frame, p.before_apart, p.view_frame)
        limits = InputLimits(p.max_age, p.max_future, p.transform_tolerance)
        joints = JointHistory(tolerance=JOINT_TOLERANCE)
        self._arm = ArmInputs(joints, limits, self._diagnostics)
        self._input = SensorInput(
            "depth/image_rect",
            Image,
            limits,
            self._diagnostics,
            from_depth_image,
            self._place,
            self._news.set,
        )
        self._server = actionlib.SimpleActionServer(
            "~calibrate", CalibrateCameraAction, self._on_goal, auto_start=False
        )
        self._server.start()
        survive_clock_jumps(self._server)
        rospy.loginfo(f"camera calibration waits for {self._input.topic} and goals")

    def spin(self) -> None:
        """Take images in until shutdown."""
        for now in rounds(self._news, lambda: self._input.waits, self._restart):
            for seen, _ in self._input.take(now):
                self._take(seen)

    def _place(self, received: Received) -> _Seen:
        """The arm at the image's stamp, or what the image waits for."""
        camera, stamp = self._arm.camera_of(received.content), received.stamp
        before: dict[str, float] = {}
        now: dict[str, float] = {}
        if self._model is not None:  # else: before the first goal
            names, seconds = self._model.movable, stamp.to_sec()
            now = self._arm.positions(seconds, names)
            before = self._arm.positions(seconds - self._p.still_time, names)
        return _Seen(stamp, received.frame, received.content, camera, before, now, received.arrived)

    def _take(self, seen: _Seen) -> None:
        with self._state:
            first, self._seen = self._seen, seen
            if self._collector is None or not seen.now:
                self._state.notify_all()  # a goal may wait for its inputs
                return
            if first and (first.camera, first.frame) != (seen.camera, seen.frame):
                self._jumped = True  # another camera: what was collected is of no use
                return
            view = self._collector.add(metres(seen.pixels), seen.before, seen.now)
            if view is not None:
                self._valid_share = float(np.isfinite(view.depth).mean())
                self._state.notify_all()
                rospy.loginfo(f"pose {len(self._collector.views)} taken")

    def _on_goal(self, goal: CalibrateCameraGoal) -> None:
        begun = time.monotonic()
        try:
            answer = self._answer(goal)
        except RefusedError as refused:
            answer = CalibrateCameraResult(verdict=refused.reason, why=str(refused))
        finally:
            with self._state:
                self._collector = None
        self._diagnostics.latency(time.monotonic() - begun)
        if answer.success:
            rospy.loginfo(answer.why)
            self._server.set_succeeded(answer, answer.why)
            return
        rospy.logwarn(f"no result: {answer.verdict}: {answer.why}")
        end = (
            self._server.set_preempted if answer.verdict == CANCELLED else self._server.set_aborted
        )
        end(answer, answer.why)

    def _answer(self, goal: CalibrateCameraGoal) -> CalibrateCameraResult:
        """Inputs -> guess -> poses -> calibration -> picture and files."""
        p = self._p
        check_goal(goal)
        folder = folder_of(goal)
        self._model = model = arm_of(p.description_parameter, p.visual)
        root = p.root_frame or model.root
        self._outputs.clear(root)
        seen = self._inputs(model)
        T_initial = self._guess(goal, root, seen)
        views = self._collect(goal, seen)
        self._say("calibrating", len(views))
        result = self._calibrate(model, seen.camera, views, T_initial)
        self._check_asked()
        self._outputs.show(model, seen.camera, views, result, root)
        child = p.child_frame or seen.frame
        files: list[Path] = []
        if result.verdict is Verdict.OK and folder is not None:
            try:
                files = write(result, folder, root, child, not p.child_frame)
            except OSError as error:
                raise RefusedError("NOT_WRITTEN", f"output_folder {folder}: {error}") from None
        return to_result(result, root, child, not p.child_frame, files)

    def _calibrate(
        self, model: RobotModel, camera: PinholeCamera, views: list[ArmView], T: np.ndarray
    ) -> Calibration:
        calibrator = ArmCalibrator(model, camera, self._p)
        try:
            return calibrator.calibrate(views, T, self._check_asked)
        finally:
            calibrator.close()

    def _inputs(self, model: RobotModel) -> _Seen:
        """An image that is new and has all that it needs; waits for it."""
        with self._state:
            self._seen, self._jumped = None, False
        end = time.monotonic() + self._p.input_timeout
        while time.monotonic() < end:
            self._say("inputs", 0)
            self._check_asked()
            with self._state:
                if self._seen is not None and self._seen.now:
                    return self._seen
                self._state.wait(LOOK_ROUND)
        raise RefusedError("NO_INPUT", self._missing(model))

    def _missing(self, model: RobotModel) -> str:
        """Which input does not come."""
        arm = self._arm
        if arm.camera is None:
            return f"nothing usable on {arm.info_topic}"
        try:
            arm.joints.at(rospy.Time.now().to_sec() - self._p.max_age, model.movable)
        except InputError as error:
            return f"{arm.joints_topic}: {error}"
        return f"no usable image on {self._input.topic} that goes with {arm.info_topic}"

    def _guess(self, goal: CalibrateCameraGoal, root: str, seen: _Seen) -> np.ndarray:
        """T_root_camera (4, 4), of the goal or of tf at an image's stamp."""
        given = guess_of(goal)
        if given is not None:
            return given
        patience = rospy.Duration.from_sec(self._p.transform_tolerance)
        try:
            found = self._tf.lookup_transform(root, seen.frame, seen.stamp, patience)
        except tf2_ros.TransformException as error:
            why = f"tf has no {seen.frame} in {root}, and the goal has no guess: {error}"
            raise RefusedError("NO_GUESS", why) from None
        return from_transform(found)

    def _collect(self, goal: CalibrateCameraGoal, seen: _Seen) -> list[ArmView]:
        """As many poses as are wanted, or as came in time."""
        p = self._p
        wanted = goal.poses or p.poses
        patience = goal.timeout if goal.timeout > 0.0 else p.timeout
        end = rospy.Time.now() + rospy.Duration.from_sec(patience)
        collector = PoseCollector(p.images, p.still_angle, p.new_pose, p.least_share)
        with self._state:
            self._collector, self._valid_share = collector, 0.0
        while len(collector.views) < wanted and rospy.Time.now() < end:
            self._say("waiting", len(collector.views))
            self._check_asked()
            self._check_alive()
            with self._state:
                self._state.wait(LOOK_ROUND)
        with self._state:
            self._collector = None
        if len(collector.views) < min(wanted, p.least_poses):
            why = (
                f"{len(collector.views)} of {wanted} poses in {patience:.0f} s: the arm must stand "
                f"still in each for {p.still_time:g} s and {p.images} images"
            )
            raise RefusedError("TOO_FEW_POSES", why)
        return list(collector.views[:wanted])

    def _say(self, stage: str, poses: int) -> None:
        self._server.publish_feedback(CalibrateCameraFeedback(stage, poses, self._valid_share))

    def _check_asked(self) -> None:
        """Whether a result is still wanted and can be had."""
        if self._server.is_preempt_requested() or rospy.is_shutdown():
            raise RefusedError(CANCELLED, "cancelled: nothing is written")
        if self._jumped:
            raise RefusedError("INTERRUPTED", "the clock went back, or the camera is another now")

    def _check_alive(self) -> None:
        """Whether images still come with all that they need."""
        seen, model = self._seen, self._model
        if seen and model and time.monotonic() - seen.arrived > self._p.input_timeout:
            raise RefusedError("NO_INPUT", self._missing(model))

    def _restart(self) -> None:
        rospy.logwarn("the clock went back: joint states, tf, images and the goal are forgotten")
        self._input.restart()
        self._arm.joints.clear()
        self._tf.clear()
        forget_goals(self._server)
        with self._state:
            self._seen, self._jumped = None, True
            self._state.notify_all()


def main() -> None:
    """Run the node."""
    rospy.init_node("camera_calibrator")
    CameraCalibratorNode().spin()
