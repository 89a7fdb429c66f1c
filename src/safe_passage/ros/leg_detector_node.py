"""Node `leg_detector`: persons from a 2D laser scan alone, the papers' baseline."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

import rospy
from sensor_msgs.msg import LaserScan
from visualization_msgs.msg import MarkerArray

from safe_passage.core.errors import InputError, ParameterError
from safe_passage.core.parameters import check_range, check_text
from safe_passage.leg_detection.classifiers import LegModel, load
from safe_passage.leg_detection.parameters import LegDetectorParameters
from safe_passage.leg_detection.pipeline import LegDetector
from safe_passage.msg import PersonArray
from safe_passage.ros.clock import JumpDetector
from safe_passage.ros.diagnostics import NodeDiagnostics, Outcome
from safe_passage.ros.leg_conversions import from_message, to_markers, to_persons
from safe_passage.ros.parameters import read_parameters
from safe_passage.ros.sensor_conversions import UnusableMessageError, check_count


@dataclass(frozen=True)
class LegDetectorNodeParameters(LegDetectorParameters):
    """Private parameters of the node."""

    model: str = ""  # file, made by train_leg_detector
    laser_height: float = 0.2  # [m] of the scan plane over the ground; negative: laser upside down
    max_age: float = 0.5  # [s] older scans are dropped
    max_future: float = 0.1  # [s] scans stamped farther ahead are dropped
    input_timeout: float = 1.0  # [s] silence reported in /diagnostics

    def __post_init__(self) -> None:
        super().__post_init__()
        check_text("model", self.model, may_be_empty=True)
        check_range("laser_height", self.laser_height, -2.0, 2.0, "m")
        check_range("max_age", self.max_age, 0.0, 10.0, "s")
        check_range("max_future", self.max_future, 0.0, 10.0, "s")
        check_range("input_timeout", self.input_timeout, 0.01, 60.0, "s")


class LegDetectorNode:
    """Converts, calls the detector, publishes."""

    def __init__(self) -> None:
        self._p = read_parameters(LegDetectorNodeParameters)
        model = _load_model(self._p.model)
        self._detector = LegDetector(model, self._p)
        self._jumps, self._newest = JumpDetector(), rospy.Time()
        self._topic = rospy.resolve_name("scan")
        self._diagnostics = NodeDiagnostics(self._p.input_timeout)
        self._diagnostics.expect(self._topic)
        self._persons_pub = rospy.Publisher("persons", PersonArray, queue_size=1)
        self._markers_pub = rospy.Publisher("~markers", MarkerArray, queue_size=1)
        rospy.Subscriber("scan", LaserScan, self._receive, queue_size=1, buff_size=2**20)
        rospy.loginfo(f"{model.name} of {self._p.model} waits for {self._topic}")

    def _receive(self, message: LaserScan) -> None:
        arrived = time.monotonic()
        self._restart_after_jump(rospy.Time.now())
        outcome, detail = self._judge_header(message, rospy.Time.now())
        if outcome is Outcome.OK:
            self._newest = message.header.stamp
            try:
                self._publish(message)
                self._diagnostics.latency(time.monotonic() - arrived)
            except UnusableMessageError as error:
                outcome, detail = error.outcome, str(error)
        self._diagnostics.count(self._topic, outcome, detail)

    def _publish(self, message: LaserScan) -> None:
        scan = from_message(message)
        check_count(message)
        detection = self._detector.detect(scan)
        header = message.header
        self._persons_pub.publish(to_persons(detection, header, self._p.laser_height))
        if self._markers_pub.get_num_connections():
            self._markers_pub.publish(to_markers(detection, header))

    def _judge_header(self, message: LaserScan, now: rospy.Time) -> tuple[Outcome, str]:
        stamp = message.header.stamp
        age = (now - stamp).to_sec()
        if not message.header.frame_id:
            return Outcome.BAD_FIELDS, "no frame_id"
        if age > self._p.max_age:
            return Outcome.STALE, f"{age:.3f} s old"
        if age < -self._p.max_future:
            return Outcome.FUTURE, f"{-age:.3f} s ahead"
        if stamp <= self._newest:
            return Outcome.OUT_OF_ORDER, f"{(self._newest - stamp).to_sec():.3f} s behind the last"
        return Outcome.OK, ""

    def _restart_after_jump(self, now: rospy.Time) -> None:
        if self._jumps.jumped_back(now):
            rospy.logwarn("the clock went back: the last scan is forgotten")
            self._detector.reset()
            self._newest = rospy.Time()


def _load_model(name: str) -> LegModel:
    """Raises ParameterError: the file is missing, or is not for this program."""
    parameter = rospy.resolve_name("~model")
    how = "rosrun safe_passage train_leg_detector makes one from recordings"
    if not name:
        raise ParameterError(f"parameter {parameter} names no file; {how}")
    try:
        return load(Path(name).expanduser())
    except InputError as error:
        raise ParameterError(f"parameter {parameter}: {error}; {how}") from None


def main() -> None:
    rospy.init_node("leg_detector")
    LegDetectorNode()
    rospy.spin()
