"""Node `scan_segmentation_server`: where the robot fits, of a 3D scan."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import Callable

import actionlib
import rospy
import tf2_ros
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header
from std_srvs.srv import Trigger, TriggerResponse

from safe_passage.core.errors import InputError, ParameterError
from safe_passage.core.reading import build
from safe_passage.msg import (
    ScanSegmentation,
    SegmentScanAction,
    SegmentScanFeedback,
    SegmentScanGoal,
    SegmentScanResult,
)
from safe_passage.ros.actions import RefusedError, forget_goals, survive_clock_jumps
from safe_passage.ros.conversions import from_transform
from safe_passage.ros.diagnostics import NodeDiagnostics
from safe_passage.ros.input_loop import rounds
from safe_passage.ros.parameters import private_values
from safe_passage.ros.scan_conversions import (
    ScanCloud,
    from_robot,
    from_scan_cloud,
    to_organised,
    unit,
)
from safe_passage.ros.segmentation_conversions import reason_code
from safe_passage.ros.segmentation_outputs import SegmentationOutputs
from safe_passage.ros.segmentation_parameters import ServerParameters
from safe_passage.ros.sensor_conversions import UnusableMessageError
from safe_passage.ros.sensor_input import InputLimits, Received, SensorInput
from safe_passage.scan_segmentation import (
    RobotConfiguration,
    ScanSegmenter,
    Segmentation,
    SegmentationError,
)
from safe_passage.scan_segmentation.configuration import configuration
from safe_passage.scan_segmentation.scan import Vector
from safe_passage.srv import SelectRobot, SelectRobotResponse

VALUES = "values"  # name of a configuration that came with a goal


@dataclass(frozen=True)
class _Placed:
    """A cloud, and where up is."""

    header: Header
    content: ScanCloud
    up: Vector


class ScanSegmentationNode:
    """Segments scans on demand, one at a time; a failure shows nothing and says why."""

    def __init__(self) -> None:
        values = private_values()
        where = rospy.get_name() + "/"
        self._robots, parameters = configuration(values, where)
        self._p = build(ServerParameters, values.get("server") or {}, where + "server")
        self._robot = self._p.robot or next(iter(self._robots))
        if self._robot not in self._robots:
            raise ParameterError(f"parameter {where}server/robot: {self._unknown(self._robot)}")
        self._segmenter = ScanSegmenter(parameters)
        self._news, self._work = threading.Event(), threading.Lock()
        self._latest: _Placed | None = None
        self._shown: _Placed | None = None
        self._diagnostics = NodeDiagnostics(self._p.input_timeout)
        self._tf = tf2_ros.Buffer(rospy.Duration(30.0))
        self._listener = tf2_ros.TransformListener(self._tf)
        self._outputs = SegmentationOutputs()
        limits = InputLimits(self._p.max_age, self._p.max_future, self._p.transform_tolerance)
        self._input = SensorInput(
            "points",
            PointCloud2,
            limits,
            self._diagnostics,
            lambda message: (message.header, from_scan_cloud(message)),
            self._place,
            self._news.set,
            expected=False,  # scans come when somebody wants one
        )
        self._server = actionlib.SimpleActionServer(
            "~segment_scan", SegmentScanAction, self._on_goal, auto_start=False
        )
        self._forget("no scan was segmented yet")
        self._server.start()
        survive_clock_jumps(self._server)
        rospy.Service("~segment_latest", Trigger, self._on_trigger)
        rospy.Service("~select_robot", SelectRobot, self._on_select)
        rospy.loginfo(f"scan segmentation waits for {self._input.topic} and goals")

    def spin(self) -> None:
        """Take clouds in until shutdown."""
        for now in rounds(self._news, lambda: self._input.waits, self._restart):
            for placed, _ in self._input.take(now):
                self._latest = placed

    def _place(self, received: Received) -> _Placed:
        header, content = received.content
        return _Placed(header, content, self._up(header, rospy.Duration(0)))

    def _up(self, header: Header, patience: rospy.Duration) -> Vector:
        """Where up is in the cloud's frame, at its stamp."""
        if not self._p.level_frame:
            return unit(self._p.up)
        found = self._tf.lookup_transform(
            header.frame_id, self._p.level_frame, header.stamp, patience
        )
        return unit(from_transform(found)[:3, 2])

    def _on_goal(self, goal: SegmentScanGoal) -> None:
        def progress(stage: str, share: float) -> bool:
            self._server.publish_feedback(SegmentScanFeedback(stage, share))
            return not (self._server.is_preempt_requested() or rospy.is_shutdown())

        with self._work:
            answer = self._answer(
                lambda: self._of_goal(goal), lambda: self._robot_of(goal), progress
            )
        result = SegmentScanResult(answer)
        if answer.success:
            self._server.set_succeeded(result, answer.text)
        elif answer.reason == ScanSegmentation.CANCELLED:
            self._server.set_preempted(result, answer.text)
        else:
            self._server.set_aborted(result, answer.text)

    def _on_trigger(self, _: object) -> TriggerResponse:
        with self._work:
            answer = self._answer(self._the_latest, self._chosen)
        return TriggerResponse(answer.success, answer.text)

    def _on_select(self, request: SelectRobot) -> SelectRobotResponse:
        known = list(self._robots)
        if request.robot not in self._robots:
            return SelectRobotResponse(False, self._unknown(request.robot), known)
        with self._work:
            self._robot = request.robot
            if self._shown is None:
                return SelectRobotResponse(True, f"{request.robot} from now on", known)
            shown = self._shown
            answer = self._answer(lambda: shown, self._chosen)
        return SelectRobotResponse(answer.success, answer.text, known)

    def _answer(
        self,
        cloud: Callable[[], _Placed],
        robot: Callable[[], tuple[str, RobotConfiguration]],
        progress: Callable[[str, float], bool] | None = None,
    ) -> ScanSegmentation:
        """What is published and answered."""
        begun, name = time.monotonic(), ""
        header = self._header()
        self._shown = None
        try:
            name, box = robot()
            placed = cloud()
            header = placed.header
            found = self._segment(placed, name, box, progress)
        except RefusedError as refused:
            return self._refuse(header, refused.reason, str(refused), name)
        except SegmentationError as error:
            return self._refuse(header, reason_code(error.reason), str(error), name)
        except InputError as error:
            return self._refuse(header, ScanSegmentation.BAD_CLOUD, str(error), name)
        self._shown = placed
        answer = self._outputs.result(header, found, name, _summary(found, name))
        self._diagnostics.latency(time.monotonic() - begun)
        rospy.loginfo(answer.text)
        return answer

    def _segment(
        self,
        placed: _Placed,
        name: str,
        box: RobotConfiguration,
        progress: Callable[[str, float], bool] | None,
    ) -> Segmentation:
        axis = unit(self._p.axis) if self._p.axis else None
        scan = to_organised(placed.content, placed.up, axis)
        return self._segmenter.segment(
            scan,
            box,
            {**self._robots, name: box},
            progress,
            lambda planes: self._outputs.planes(placed.header, planes),
        )

    def _forget(self, why: str) -> None:
        """Take away what is drawn, also by this node before it was started anew."""
        self._shown = None
        self._outputs.failure(self._header(), ScanSegmentation.NO_CLOUD, why, "")

    def _header(self) -> Header:
        """Of what is said of no cloud."""
        return Header(stamp=rospy.Time.now(), frame_id=self._p.level_frame or "scanner")

    def _refuse(self, header: Header, reason: int, text: str, name: str) -> ScanSegmentation:
        rospy.logwarn(f"no result: {text}")
        return self._outputs.failure(header, reason, text, name)

    def _of_goal(self, goal: SegmentScanGoal) -> _Placed:
        cloud = goal.cloud
        if not cloud.header.frame_id and not cloud.data:
            return self._the_latest()
        try:
            content = from_scan_cloud(cloud)
        except UnusableMessageError as error:
            text = f"the goal's cloud: {error.outcome.value} {error}"
            raise RefusedError(ScanSegmentation.BAD_CLOUD, text) from None
        try:
            patience = rospy.Duration.from_sec(self._p.transform_tolerance)
            return _Placed(cloud.header, content, self._up(cloud.header, patience))
        except tf2_ros.TransformException as error:
            raise RefusedError(
                ScanSegmentation.NO_TF, f"where up is, is not known: {error}"
            ) from None

    def _the_latest(self) -> _Placed:
        latest = self._latest
        if latest is None:
            raise RefusedError(ScanSegmentation.NO_CLOUD, f"no cloud on {self._input.topic} yet")
        age = (rospy.Time.now() - latest.header.stamp).to_sec()
        if age > self._p.max_age:
            text = f"the last cloud on {self._input.topic} is {age:.0f} s old"
            raise RefusedError(ScanSegmentation.NO_CLOUD, text)
        return latest

    def _robot_of(self, goal: SegmentScanGoal) -> tuple[str, RobotConfiguration]:
        if goal.robot:
            if goal.robot not in self._robots:
                raise RefusedError(ScanSegmentation.BAD_ROBOT, self._unknown(goal.robot))
            return goal.robot, self._robots[goal.robot]
        try:
            given = from_robot(goal.values)
        except ParameterError as error:
            raise RefusedError(ScanSegmentation.BAD_ROBOT, str(error)) from None
        return self._chosen() if given is None else (VALUES, given)

    def _chosen(self) -> tuple[str, RobotConfiguration]:
        return self._robot, self._robots[self._robot]

    def _unknown(self, name: str) -> str:
        return f"robot {name!r} is not known; known are: {', '.join(self._robots)}"

    def _restart(self) -> None:
        rospy.logwarn("the clock went back: the last cloud, goals and tf are forgotten")
        with self._work:
            self._latest = None
            self._forget("the clock went back")
        self._input.restart()
        self._tf.clear()
        forget_goals(self._server)


def _summary(found: Segmentation, robot: str) -> str:
    drivable = found.drivable
    area = ((drivable.cells == 1) | (drivable.cells == 2)).sum() * drivable.resolution**2
    parts = [
        f"for {robot}: {len(found.planes.valid)} planes, {len(found.ground)} of them ground",
        f"{area:.1f} m^2 drivable",
        f"{len(found.doors)} doors, {sum(robot in d.passable_by for d in found.doors)} passable",
        f"{len(found.stairs)} stairs",
        f"{sum(found.seconds.values()):.2f} s",
    ]
    return ", ".join([*parts, *found.planes.notes])


def main() -> None:
    """Run the node."""
    rospy.init_node("scan_segmentation_server")
    ScanSegmentationNode().spin()
