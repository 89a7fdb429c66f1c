"""Node `scan_assembler`: lines of a 2D scanner that turns -> one organised cloud a sweep."""

from __future__ import annotations

import math
import threading
import time
from dataclasses import dataclass

import numpy as np
import rospy
from sensor_msgs.msg import JointState, LaserScan, PointCloud2
from std_msgs.msg import Header

from safe_passage.core.errors import InputError, ParameterError
from safe_passage.core.parameters import check_range, check_text
from safe_passage.core.reading import build
from safe_passage.robot_model import JointHistory
from safe_passage.ros.conversions import from_transform
from safe_passage.ros.diagnostics import NodeDiagnostics, Outcome
from safe_passage.ros.input_loop import rounds
from safe_passage.ros.parameters import private_values
from safe_passage.ros.sampled_transforms import SampledTransforms
from safe_passage.ros.scan_conversions import to_scan_cloud
from safe_passage.ros.sensor_conversions import UnusableMessageError, scan_beams
from safe_passage.ros.sensor_input import InputLimits, NotYetError, Received, SensorInput
from safe_passage.scan_segmentation.assembling import (
    AssemblingParameters,
    Line,
    ScanAssembler,
    Step,
)

ASSEMBLING = "sweep"  # what the lines are counted under in /diagnostics
OUTCOMES = {Step.TAKEN: Outcome.OK, Step.STANDING: Outcome.NO_TURN, Step.NO_BEAMS: Outcome.EMPTY}


@dataclass(frozen=True)
class AssemblerNodeParameters(AssemblingParameters):
    """The assembling's, and the node's own."""

    frame: str = "scanner"  # of the clouds; its z is the axis of the rotation and does not turn
    joint: str = ""  # of joint_states, its position [rad] is the angle; empty: tf tells it
    joint_offset: float = 0.0  # [rad] of the angle where the joint's position is 0
    joint_sign: float = 1.0  # -1: the joint turns clockwise about the axis
    joint_gap: float = 0.2  # [s] between two joint states or transforms, at most
    max_age: float = 2.0  # [s] older scans are dropped
    max_future: float = 0.1  # [s] scans stamped farther ahead are dropped
    transform_tolerance: float = 0.5  # [s] a scan waits so long for the angle
    input_timeout: float = 2.0  # [s] silence reported in /diagnostics

    def __post_init__(self) -> None:
        super().__post_init__()
        check_text("frame", self.frame)
        check_text("joint", self.joint, may_be_empty=True)
        check_range("joint_offset", self.joint_offset, -2.0 * math.pi, 2.0 * math.pi, "rad")
        if abs(self.joint_sign) != 1.0:
            raise ParameterError(f"joint_sign is {self.joint_sign}, must be 1 or -1")
        check_range("joint_gap", self.joint_gap, 0.001, 10.0, "s")
        check_range("max_age", self.max_age, 0.0, 60.0, "s")
        check_range("max_future", self.max_future, 0.0, 10.0, "s")
        check_range("transform_tolerance", self.transform_tolerance, 0.0, 10.0, "s")
        check_range("input_timeout", self.input_timeout, 0.01, 60.0, "s")


@dataclass(frozen=True)
class _Beams:
    """A scan, whose angle is not known yet."""

    alpha: np.ndarray  # (W,) [rad]
    ranges: np.ndarray  # (W,) [m]
    remission: np.ndarray | None
    lasts: float  # [s] from its first beam to its last


class ScanAssemblerNode:
    """Passes on whole sweeps, and none with a hole in it."""

    def __init__(self) -> None:
        self._p = build(AssemblerNodeParameters, private_values(), rospy.get_name())
        self._assembler = ScanAssembler(self._p)
        self._news = threading.Event()
        self._diagnostics = NodeDiagnostics(self._p.input_timeout)
        self._turned: float | None = None  # [rad] the joint's last position, unwrapped
        self._joints = JointHistory(10.0, tolerance=1e-3, max_gap=self._p.joint_gap)
        self._tf: SampledTransforms | None = None
        self._cloud_pub = rospy.Publisher("points", PointCloud2, queue_size=2)
        if self._p.joint:
            self._joints_topic = rospy.resolve_name("joint_states")
            self._diagnostics.expect(self._joints_topic)
            rospy.Subscriber("joint_states", JointState, self._on_joints, queue_size=200)
        else:
            self._tf = SampledTransforms(
                self._p.joint_gap,
                self._p.max_future,
                lambda outcome, why: self._diagnostics.count("tf", outcome, why),
            )
        limits = InputLimits(self._p.max_age, self._p.max_future, self._p.transform_tolerance)
        self._input = SensorInput(
            "scan", LaserScan, limits, self._diagnostics, _beams, self._line, self._news.set
        )
        angle = f"joint {self._p.joint}" if self._p.joint else f"tf to {self._p.frame}"
        rospy.loginfo(f"scan assembler waits for {self._input.topic}, {angle}")

    def spin(self) -> None:
        """Assemble until shutdown."""
        for now in rounds(self._news, lambda: self._input.waits, self._restart):
            for line, arrived in self._input.take(now):
                self._add(line, arrived)

    def _add(self, line: Line, arrived: float) -> None:
        step, done = self._assembler.add(line)
        outcome = OUTCOMES.get(step, Outcome.BROKEN_SWEEP)
        self._diagnostics.count(ASSEMBLING, outcome, step.value)
        if done is not None:
            # the stamp of the last line: only then the cloud is what is around the robot
            header = Header(stamp=rospy.Time.from_sec(done.last), frame_id=self._p.frame)
            self._cloud_pub.publish(to_scan_cloud(header, done))
            self._diagnostics.latency(time.monotonic() - arrived)

    def _line(self, received: Received) -> Line:
        """The scan, with the angle of each of its beams; raises while that is not known."""
        beams: _Beams = received.content
        first = received.stamp.to_sec()
        if self._tf is None:
            ends, mount = self._joint_angles(first, first + beams.lasts), None
        else:
            ends, mount = _tf_angles(self._tf, self._p.frame, received, beams.lasts)
        within = ends[1] - ends[0]
        within = (within + math.pi) % (2.0 * math.pi) - math.pi
        beta = ends[0] + within * np.linspace(0.0, 1.0, len(beams.alpha))
        return Line(first, beams.alpha, beams.ranges, beams.remission, beta, mount)

    def _joint_angles(self, first: float, last: float) -> tuple[float, float]:
        name = self._p.joint
        try:
            positions = [self._joints.at(stamp, [name])[name] for stamp in (first, last)]
        except InputError as error:
            raise NotYetError(Outcome.NO_JOINTS, str(error)) from None
        a, b = (self._p.joint_offset + self._p.joint_sign * position for position in positions)
        return a, b

    def _on_joints(self, message: JointState) -> None:
        if self._p.joint not in message.name:
            return  # of another part of the robot
        outcome, detail = Outcome.OK, ""
        ahead = (message.header.stamp - rospy.Time.now()).to_sec()
        if ahead > self._p.max_future:
            outcome, detail = Outcome.FUTURE, f"{ahead:.3f} s ahead"
        else:
            try:
                self._note(message)
            except (InputError, IndexError) as error:
                outcome, detail = Outcome.BAD_FIELDS, str(error)
        self._diagnostics.count(self._joints_topic, outcome, detail)
        self._news.set()

    def _note(self, message: JointState) -> None:
        position = message.position[message.name.index(self._p.joint)]
        if not math.isfinite(position):
            raise InputError(f"joint {self._p.joint}: its position is {position}")
        if self._turned is not None:  # encoders begin anew at a whole turn
            turns = round((self._turned - position) / (2.0 * math.pi))
            position += 2.0 * math.pi * turns
        self._turned = position
        self._joints.add(message.header.stamp.to_sec(), [self._p.joint], [position])

    def _restart(self) -> None:
        rospy.logwarn("the clock went back: the sweep, angles and waiting scans are forgotten")
        self._input.restart()
        self._assembler.restart()
        self._joints.clear()
        self._turned = None
        if self._tf is not None:
            self._tf.clear()


def _beams(scan: LaserScan) -> _Beams:
    """Raises UnusableMessageError."""
    beams = scan_beams(scan)
    lasts = scan.time_increment * (len(beams.ranges) - 1)
    if not math.isfinite(lasts) or not 0.0 <= lasts < 1.0:
        raise UnusableMessageError(
            Outcome.BAD_FIELDS, f"time_increment {scan.time_increment} s of {len(beams.ranges)}"
        )
    if not math.isfinite(beams.angle_min + beams.angle_increment):
        raise UnusableMessageError(Outcome.BAD_FIELDS, "angles are not finite")
    remission = np.array(scan.intensities, np.float32)
    whole = len(remission) == len(beams.ranges)
    return _Beams(beams.angles(), beams.ranges, remission if whole else None, lasts)


def _tf_angles(
    tf: SampledTransforms, frame: str, received: Received, lasts: float
) -> tuple[tuple[float, float], np.ndarray]:
    """Angles at the first and last beam, and the mount of the scanner on what turns."""
    stamps = received.stamp, received.stamp + rospy.Duration.from_sec(lasts)
    first, last = (from_transform(tf.lookup(frame, received.frame, stamp)) for stamp in stamps)
    ends = _angle(first), _angle(last)
    c, s = math.cos(ends[0]), math.sin(ends[0])
    back = np.array([[c, s, 0, 0], [-s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    return ends, back @ first


def _angle(T: np.ndarray) -> float:
    """[rad] of the scanner's plane about the axis: where x of equations 1 to 3 points to."""
    normal = T[:3, 2]  # of the plane
    if math.hypot(normal[0], normal[1]) < 1e-3:
        raise NotYetError(Outcome.NO_TF, "the scanner turns in its own plane: no 3D scan")
    return math.atan2(normal[0], -normal[1])


def main() -> None:
    """Run the node."""
    rospy.init_node("scan_assembler")
    ScanAssemblerNode().spin()
