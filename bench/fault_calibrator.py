"""The camera calibrator under faults: the camera where it is, or a refusal that says why."""

from __future__ import annotations

import numpy as np
import rospy
from arm_world import SeenArm
from box_arm import ARM, POSES, T_ROOT_CAMERA, off
from safe_passage.evaluation.calibration_trials import errors
from safe_passage.msg import (
    CalibrateCameraActionGoal,
    CalibrateCameraActionResult,
)
from safe_passage.robot_model import load_robot_model
from safe_passage.ros.conversions import from_transform, to_header
from safe_passage.simulation.robots import CameraModel
from sensor_msgs.msg import CameraInfo, Image, JointState
from tf2_msgs.msg import TFMessage

from bench.fault_answers import Answers
from bench.fault_subject import Check, Input, Seen, Sent, Stated, Subject
from bench.fault_transforms import huge

NODE = "camera_calibrator"
ANSWERS = Answers(f"{NODE}/calibrate/result", lambda result: result, "verdict", "why")
TICK = 0.1  # [s] simulated
HOLD = 2  # steps that the arm stands in a pose
WANTED = 4  # poses
GOAL_TIME = 1.2  # [s] simulated, for all poses
BETWEEN = 24  # steps between two goals
GONE = 1.5  # [s] simulated, after which no goal has all its poses from before a loss
NEAR = 0.03, np.radians(2.5)  # [m], [rad] of a result that is right; the guess is farther off
CAMERA = CameraModel(width=240, height=180, focal=197.0, range_min=0.4)
UNREAD = "nobody reads the stamp of a goal"
OFF = 0.06, 6.0  # [m], [deg] of the guess


class CameraCalibratorSubject(Subject):
    """An arm of boxes that goes through four poses; a goal every few seconds."""

    name = NODE
    launch = "camera_calibrator.launch"
    arguments = ("root_frame:=robot1/foot",)
    frames = frozenset({""})  # an answer has none
    # one small image a pose, and no result but a coarse one: what is judged is not the calibration
    parameters = {  # noqa: RUF012
        "poses": WANTED, "images": 1, "still_time": TICK, "transform_tolerance": 0.25,
        "input_timeout": 0.15, "start_search": False, "least_points": 200,
        "settled_translation": 0.01, "settled_rotation": 0.01, "most_translation": 0.01,
        "most_rotation": 0.02, "most_rms": 0.03, "coarse_voxel": 0.03,
    }  # fmt: skip
    without_number = frozenset({"rms", "pose_rms"})  # of what is refused
    tick, pause, work = TICK, 0.01, 5.0
    recovery, judged = 2.0 * BETWEEN * TICK, (BETWEEN + 8) * TICK

    def __init__(self) -> None:
        self.outputs = {ANSWERS.topic: CalibrateCameraActionResult}
        guess = off(T_ROOT_CAMERA, *OFF)
        self._arm = SeenArm(
            load_robot_model(ARM, {}), POSES[:WANTED], T_ROOT_CAMERA, guess, "robot1/", CAMERA
        )
        self._goals = 0
        well = Stated(self.healthy, told=False)
        no_input, no_guess = ANSWERS.refused("NO_INPUT"), ANSWERS.refused("NO_GUESS")
        kept = {name: well for name in ("silent", "stale", "future", "wrong frame")}
        kept.update({name: Stated(self.healthy, told=True) for name in ("NaN", "empty")})
        # both ends of the gap to a transform ahead are told, and the camera stands meanwhile
        ahead = {"future": Stated(lambda _: "", told=False)}
        # half of the moments are known: too few poses may be
        half = {"out of order": Stated(self._well_or("TOO_FEW_POSES"), told=False)}
        no_sense = {
            name: Stated(ANSWERS.refused("BAD_GOAL"), told=False) for name in ("NaN", "huge")
        }
        kinds = (
            ("tf", "/tf", TFMessage, self._tf, no_guess, ahead),
            ("joints", "joint_states", JointState, self._joints, no_input,
             {"wrong frame": well, **half}),
            ("camera_info", "depth/camera_info", CameraInfo, self._arm.info, no_input, kept),
            ("image", "depth/image_rect", Image, self._image, no_input,
             {"NaN": Stated(ANSWERS.refused("NOT_SEEN"), told=False),
              "wrong frame": Stated(no_guess, told=False), **half}),
        )  # fmt: skip
        goal = Input(
            "goal", f"{NODE}/calibrate/goal", CalibrateCameraActionGoal, self._goal, GONE,
            ANSWERS.none, told=False, stated=no_sense, every=BETWEEN,
            special={"huge": lambda goal, _: huge(goal, 0)},  # every one: goals are rare
            without=dict.fromkeys(("stale", "future", "out of order"), UNREAD),
        )  # fmt: skip
        self.inputs = (
            *(
                Input(name, topic, kind, make, GONE, lost, told=False, stated=stated)
                for name, topic, kind, make, lost, stated in kinds
            ),
            goal,
        )

    def prepare(self) -> None:
        rospy.set_param("robot_description", ARM)

    def _tf(self, stamp: rospy.Time) -> TFMessage:
        return TFMessage(self._arm.transforms(_number(stamp), stamp))

    def _joints(self, stamp: rospy.Time) -> JointState:
        return self._arm.joints(_number(stamp), stamp)

    def _image(self, stamp: rospy.Time) -> Image:
        return self._arm.image(_number(stamp), _step(stamp), stamp)

    def _goal(self, stamp: rospy.Time) -> CalibrateCameraActionGoal:
        self._goals += 1
        goal = CalibrateCameraActionGoal(header=to_header(stamp, ""))
        goal.goal_id.stamp, goal.goal_id.id = stamp, f"faults {self._goals}"
        goal.goal.timeout = GOAL_TIME
        return goal

    def healthy(self, seen: Seen) -> str:
        answers = ANSWERS.seen(seen)
        if not answers:
            return "no answer"
        return "" if answers[-1].success else f"{answers[-1].verdict}: {answers[-1].why}"

    def _well_or(self, *verdicts: str) -> Check:
        def check(seen: Seen) -> str:
            return self.healthy(seen) and ANSWERS.refused(*verdicts)(seen)

        return check

    def wrong(self, seen: Seen, sent: list[Sent]) -> str:
        """A camera that is elsewhere; a result that does not say what it is."""
        del sent
        for one in ANSWERS.seen(seen):
            if one.success != (one.verdict == "OK") or not one.why:
                return f"verdict {one.verdict!r}, success {one.success}, {one.why!r}"
            if one.success:
                if not np.isfinite([one.rms, *one.pose_rms]).all():
                    return f"rms {one.rms}, {one.pose_rms}"
                away = errors(from_transform(one.transform), T_ROOT_CAMERA)
                if any(error > near for error, near in zip(away, NEAR)):
                    return f"the camera is {away[0]:.3f} m, {np.degrees(away[1]):.1f} deg off"
        return ""


def _step(stamp: rospy.Time) -> int:
    return round(stamp.to_sec() / TICK)


def _number(stamp: rospy.Time) -> int:
    return _step(stamp) // HOLD % WANTED
