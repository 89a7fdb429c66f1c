"""The segmentation server under faults: a garage's door where it is, or a refusal that says why."""

from __future__ import annotations

import copy
from dataclasses import replace
from typing import Any

import numpy as np
import rospy
from rotating_scanner import SCANNER
from safe_passage.evaluation.segmentation_places import garage
from safe_passage.msg import (
    ScanSegmentation,
    SegmentScanActionGoal,
    SegmentScanActionResult,
)
from safe_passage.ros.conversions import to_header, to_transform
from safe_passage.ros.scan_conversions import to_scan_cloud
from safe_passage.scan_segmentation.assembling import Assembled
from safe_passage.simulation.scan_scene import scan_place
from sensor_msgs.msg import PointCloud2
from tf2_msgs.msg import TFMessage

from bench.fault_answers import Answers
from bench.fault_subject import Check, Input, Seen, Sent, Stated, Subject, of
from bench.fault_transforms import Transform, faults_of

NODE = "scan_segmentation_server"
RESULT = f"{NODE}/result"
ANSWERS = Answers(
    f"{NODE}/segment_scan/result", lambda result: result.segmentation, "reason", "text"
)
FRAME, LEVEL = "scanner", "odom"
MAX_AGE = 3.0  # [s] for which a cloud is the latest
DOOR, WIDTH = 4.0, 0.90  # [m] ahead, wide
LINES = 150  # of a scan
NEAR = 0.1  # [m]
OK, NO_CLOUD, NO_TF, BAD_CLOUD = (
    getattr(ScanSegmentation, name) for name in ("OK", "NO_CLOUD", "NO_TF", "BAD_CLOUD")
)


class SegmentationServerSubject(Subject):
    """A goal a step: of the topic's latest cloud, or of its own."""

    name = NODE
    launch = "scan_segmentation.launch"
    frames = frozenset({FRAME, LEVEL, ""})  # an answer has none
    parameters = {"server/max_age": MAX_AGE}  # noqa: RUF012
    tick, pause, work = 0.5, 0.03, 5.0
    recovery, judged = 3.0, 1.5
    own_cloud = False  # of the goals

    def __init__(self) -> None:
        self.outputs = {ANSWERS.topic: SegmentScanActionResult, RESULT: ScanSegmentation}
        scan, _ = scan_place(garage(), replace(SCANNER, lines=LINES), 11)
        beta = np.repeat(scan.beta[:, None], scan.points.shape[1], axis=1)
        self._assembled = Assembled(scan, beta, 0.0, 0.0)
        self._number = 0
        # both ends of the gap to a transform ahead are told, and the robot stands meanwhile
        ahead = {"future": Stated(lambda _: "", told=False)}
        tf = Input(
            "tf", "/tf", TFMessage, _level, self._patience(), self._lost(), told=False,
            stated=ahead,
        )  # fmt: skip
        goal = Input(
            "goal", f"{NODE}/segment_scan/goal", SegmentScanActionGoal, self._goal, 1.0,
            ANSWERS.refused(BAD_CLOUD), told=False,
        )  # fmt: skip
        self.inputs = (tf, *self._others(goal))

    def _patience(self) -> float:
        """[s] for which a lost cloud, or the lost tf of one, does not show."""
        return MAX_AGE + self.tick

    def _lost(self) -> Check:
        return ANSWERS.refused(NO_CLOUD)

    def _others(self, goal: Input) -> tuple[Input, ...]:
        cloud = Input(
            "cloud", "rotating_scan/points", PointCloud2, self._cloud, self._patience(),
            self._lost(), told=False,
        )  # fmt: skip
        # goals of a topic's cloud say nothing themselves: they can be lost, or come twice
        silent = Stated(ANSWERS.none, told=False)
        keep = {"silent": silent}
        faults = {"silent", "slow", "duplicated"}
        others = set(faults_of(goal.make(rospy.Time(1)))) - faults
        without = dict.fromkeys(others, "a goal without a cloud has nothing that is read")
        goal = copy_of(goal, stated=keep, without=without)
        return cloud, goal

    def _cloud(self, stamp: rospy.Time) -> PointCloud2:
        return to_scan_cloud(to_header(stamp, FRAME), self._assembled)

    def _goal(self, stamp: rospy.Time) -> SegmentScanActionGoal:
        self._number += 1
        goal = SegmentScanActionGoal(header=to_header(stamp, ""))
        goal.goal_id.stamp, goal.goal_id.id = stamp, f"faults {self._number}"
        if self.own_cloud:
            goal.goal.cloud = self._cloud(stamp)
        return goal

    def healthy(self, seen: Seen) -> str:
        answers, results = ANSWERS.seen(seen), of(RESULT, seen)
        if not answers or not results:
            return "no answer or no result"
        for last in (answers[-1], results[-1]):
            if not last.success:
                return last.text
        return ""

    def wrong(self, seen: Seen, sent: list[Sent]) -> str:
        """A door that is elsewhere, a success of nothing, a refusal with something in it."""
        del sent
        for one in [*ANSWERS.seen(seen), *of(RESULT, seen)]:
            if one.success != (one.reason == OK) or not one.text:
                return f"reason {one.reason}, success {one.success}, {one.text!r}"
            doors = [door for door in one.doors if abs(door.width - WIDTH) < NEAR]
            if one.success and not any(abs(d.pose.position.z - DOOR) < NEAR for d in doors):
                return f"no door at {DOOR} m"
            if not one.success and (one.doors or one.planes or one.map.data):
                return f"refused, and something is told: {one.text}"
        return ""


class SegmentationGoalSubject(SegmentationServerSubject):
    """The goals bring their clouds."""

    name, node = "scan_segmentation_goal", NODE
    own_cloud = True

    def _patience(self) -> float:
        return self.tick

    def _lost(self) -> Check:
        return ANSWERS.refused(NO_TF)

    def _others(self, goal: Input) -> tuple[Input, ...]:
        special = {
            name: in_goal(fault)
            for name, fault in faults_of(self._cloud(rospy.Time(1))).items()
            if name not in ("silent", "slow", "duplicated")
        }
        well = Stated(self.healthy, told=False)
        stated = {
            "silent": Stated(ANSWERS.none, told=False),
            **{
                name: Stated(ANSWERS.refused(NO_TF), told=False)
                for name in ("wrong frame", "future")
            },
            **{name: well for name in ("stale", "out of order")},  # who asks may ask of old clouds
        }
        return (copy_of(goal, stated=stated, special=special),)


def in_goal(fault: Transform) -> Transform:
    """The fault of the goal's cloud."""

    def of_goal(goal: SegmentScanActionGoal, number: int) -> list[Any]:
        spoilt = []
        for cloud in fault(goal.goal.cloud, number):
            one = copy.copy(goal)
            one.goal = copy.copy(goal.goal)
            one.goal.cloud = cloud
            spoilt.append(one)
        return spoilt

    return of_goal


def copy_of(one: Input, **values: Any) -> Input:
    """The input with other values."""
    return Input(**{**one.__dict__, **values})


def _level(stamp: rospy.Time) -> TFMessage:
    place = np.array(SCANNER.position)
    return TFMessage([to_transform(to_header(stamp, LEVEL), FRAME, place, SCANNER.rotation())])
