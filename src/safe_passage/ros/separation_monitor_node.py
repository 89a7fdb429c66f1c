"""Node `separation_monitor`: tracks, the robot's way and its command -> the command it may do."""

from __future__ import annotations

import time
from dataclasses import replace

import rospy
import tf2_ros
from geometry_msgs.msg import Twist
from visualization_msgs.msg import MarkerArray

from safe_passage.msg import SeparationState
from safe_passage.ros.clock import JumpDetector
from safe_passage.ros.conversions import to_header
from safe_passage.ros.diagnostics import NodeDiagnostics
from safe_passage.ros.live_tuning import LiveTuning
from safe_passage.ros.parameters import private_values
from safe_passage.ros.separation_conversions import to_state, to_twist
from safe_passage.ros.separation_inputs import SeparationInputs
from safe_passage.ros.separation_markers import draw
from safe_passage.ros.separation_parameters import LIVE, make_separation_parameters
from safe_passage.separation import Assessment, Level, Reason, SeparationMonitor, Supervisor
from safe_passage.separation.robot_motion import Velocity

STAND: Velocity = (0.0, 0.0, 0.0)


class SeparationMonitorNode:
    """A cycle at each track or command that comes in, and at `control_rate` at least."""

    def __init__(self) -> None:
        self._p = make_separation_parameters(private_values(), rospy.get_name())
        self._monitor, self._supervisor = SeparationMonitor(self._p), Supervisor(self._p)
        self._jumps, self._drawn, self._reason = JumpDetector(), rospy.Time(), Reason.OK
        self._command_pub = rospy.Publisher("cmd_vel_out", Twist, queue_size=1, tcp_nodelay=True)
        self._state_pub = rospy.Publisher("~state", SeparationState, queue_size=1)
        self._markers_pub = rospy.Publisher("~markers", MarkerArray, queue_size=1)
        self._diagnostics = NodeDiagnostics(self._p.input_timeout)
        self._inputs = SeparationInputs(self._p, self._diagnostics, self._supervisor)
        self._tuning = LiveTuning(self._p, LIVE)
        frames = f"{self._p.odom_frame} -> {self._p.base_frame}"
        awaited = ", ".join(self._inputs.awaited)
        rospy.loginfo(
            f"separation monitor waits for tf {frames} and for {awaited}; the robot stands"
        )

    def spin(self) -> None:
        """Watch until shutdown; in the main thread, so that a fault ends the node."""
        while not rospy.is_shutdown():
            arrived = self._inputs.wait(1.0 / self._p.control_rate)
            self._tune()
            self._cycle(rospy.Time.now())
            self._diagnostics.latency(time.monotonic() - arrived)
        self._command_pub.publish(Twist())

    def _tune(self) -> None:
        """Between two cycles; nothing is forgotten."""
        parameters = self._tuning.take()
        if parameters is None:
            return
        self._p = parameters
        for part in (self._monitor, self._supervisor, self._inputs):
            part.tune(parameters)

    def _cycle(self, now: rospy.Time) -> None:
        if self._jumps.jumped_back(now):
            rospy.logwarn("the clock went back: the robot stands until everything has come anew")
            self._inputs.restart()
            self._supervisor.clock_jumped()
            self._drawn = rospy.Time()
        command, age = self._inputs.command(now)
        limited, assessment = self._limit(now, command)
        if age <= self._p.command_timeout + self._p.stop_repeat:
            self._command_pub.publish(to_twist(limited))
        self._report(now, assessment)

    def _limit(self, now: rospy.Time, command: Velocity | None) -> tuple[Velocity, Assessment]:
        """What may be done now, and why."""
        reason = self._supervisor.judge(self._inputs.inputs(now))
        if reason is Reason.OK:
            try:
                obstacles, robot = self._inputs.obstacles(now), self._inputs.robot(now)
            except tf2_ros.TransformException as error:
                reason, self._inputs.detail = Reason.NO_TF, str(error)
        if reason is not Reason.OK:
            return STAND, self._monitor.refuse(now.to_sec(), reason)
        assessment = self._monitor.assess(now.to_sec(), obstacles, robot, command)
        if command is None:
            silent = replace(assessment, level=Level.STOP, reason=Reason.STALE_COMMAND, scale=0.0)
            return STAND, silent
        return self._monitor.limit(command)

    def _report(self, now: rospy.Time, assessment: Assessment) -> None:
        header = to_header(now, self._p.base_frame)
        missing = assessment.reason in (Reason.NO_TF, Reason.SENSOR_SILENT)
        state = to_state(assessment, header, self._inputs.detail if missing else "")
        self._state_pub.publish(state)
        changed = assessment.reason is not self._reason
        if changed and max(assessment.reason, self._reason) > Reason.ESCAPE:
            rospy.loginfo(f"separation monitor: {state.text}")
        self._reason = assessment.reason
        if (now - self._drawn).to_sec() * self._p.debug_rate < 0.99:
            return
        self._drawn = now
        if self._markers_pub.get_num_connections():
            self._markers_pub.publish(draw(self._monitor.outlook, assessment, header))


def main() -> None:
    """Run the node."""
    rospy.init_node("separation_monitor")
    SeparationMonitorNode().spin()
