"""The separation monitor under faults: whatever is lost, the robot stands."""

from __future__ import annotations

from typing import Any

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry, Path
from safe_passage.msg import SeparationState, TrackedObstacleArray
from safe_passage.ros.conversions import to_header
from separation_world import BASE, ODOM, World
from tf2_msgs.msg import TFMessage

from bench.fault_graph import NODE_TESTS
from bench.fault_subject import SLACK, Check, Input, Seen, Sent, Stated, Subject, of
from bench.fault_transforms import OLD

STATE, COMMAND = "separation_monitor/state", "cmd_vel"
NO_TF, BAD_COMMAND, STALE_COMMAND, STALE_TRACKS, STALE_ODOMETRY = (
    getattr(SeparationState, name)
    for name in ("NO_TF", "BAD_COMMAND", "STALE_COMMAND", "STALE_TRACKS", "STALE_ODOMETRY")
)
AHEAD = 0.5  # [m/s] commanded


class Messages(World):
    """The messages of the node's test, of any time, published by nobody."""

    def __init__(self) -> None:
        self.began, self._at = 0.0, rospy.Time()
        self.calm()

    @property
    def stamp(self) -> rospy.Time:
        """Of the message asked for."""
        return self._at

    def message(self, name: str, stamp: rospy.Time) -> Any:
        """What speaks under that name."""
        self._at = stamp
        return getattr(self, "_" + name)()


class SeparationMonitorSubject(Subject):
    """Somebody far away; odometry, path and command ahead."""

    name = "separation_monitor"
    launch = "separation_monitor.launch"
    arguments = (
        "plan:=plan",
        f"odom_frame:={ODOM}",
        f"base_frame:={BASE}",
        f"config:={NODE_TESTS}/separation_monitor.yaml",
    )
    frames = frozenset({BASE})
    without_number = frozenset(
        f"{name}_distance" for name in ("present", "predicted", "required")
    ) | {"time_to_collision"}

    def __init__(self) -> None:
        self._world = Messages()
        self.outputs = {STATE: SeparationState, COMMAND: Twist}
        no_tf, nobody = {NO_TF}, Stated(self.healthy, told=False)
        self.inputs = (
            self._input("tf", "/tf", TFMessage, 0.4, no_tf),
            self._input("arm", "/tf", TFMessage, 0.4, no_tf),
            self._input("odom", "odom", Odometry, 0.4, {STALE_ODOMETRY}),
            self._input(
                "tracks",
                "tracks",
                TrackedObstacleArray,
                0.4,
                {STALE_TRACKS, NO_TF},
                {"empty": nobody},
            ),
            self._input("command", "cmd_vel_raw", Twist, 0.6, {BAD_COMMAND, STALE_COMMAND}),
            Input("plan", "plan", Path, self._plan, 3.0, off_path, told=False),
        )

    def _input(self, name, topic, kind, timeout, reasons, stated=None) -> Input:
        def make(stamp: rospy.Time) -> Any:
            return self._world.message(name, stamp)

        # the state says why the robot stands: no need of another word
        lost = stands(frozenset(reasons))
        if kind is TFMessage:  # tf keeps what is ahead as the newest
            stated = {"future": Stated(lost, told=False, late=OLD)}
        return Input(name, topic, kind, make, timeout, lost, told=False, stated=stated or {})

    def _plan(self, stamp: rospy.Time) -> Path:
        path = Path(header=to_header(stamp, ODOM))
        for k in range(20):
            path.poses.append(PoseStamped(header=path.header))
            path.poses[-1].pose.position.x, path.poses[-1].pose.orientation.w = 0.1 * k, 1.0
        return path

    def begin(self, now: rospy.Time) -> None:
        self._world.began = now.to_sec()

    def healthy(self, seen: Seen) -> str:
        states, commands = of(STATE, seen), of(COMMAND, seen)
        if not states or not commands:
            return "no state or no command"
        last = states[-1]
        if last.level != SeparationState.FREE or not last.on_path:
            return f"level {last.level}, {last.text}, on path {last.on_path}"
        return "" if commands[-1].linear.x == AHEAD else f"command {commands[-1].linear.x}"

    def wrong(self, seen: Seen, sent: list[Sent]) -> str:
        """It drives although something has not come for longer than it may stay away."""
        for one in self.inputs:
            times = np.array([given.at for given in sent if given.name == one.name])
            for state in of(STATE, seen) if one.name != "plan" else []:
                before = times[times <= state.header.stamp.to_sec() + 1e-6]
                silent = state.header.stamp.to_sec() - before.max() if len(before) else 0.0
                if silent > one.timeout + SLACK and state.level != SeparationState.STOP:
                    return f"no {one.name} for {silent:.2f} s, and it drives"
        return ""


def stands(reasons: frozenset[int]) -> Check:
    """Level STOP for one of these reasons, and commands 0."""

    def check(seen: Seen) -> str:
        states = of(STATE, seen)
        moves = [s for s in states if s.level != SeparationState.STOP or s.scale != 0.0]
        others = [s for s in states if s.reason not in reasons]
        driven = [c for c in of(COMMAND, seen) if c != Twist()]
        for count, what in (
            (not states, "no state"),
            (len(moves), f"of {len(states)} states are not STOP: {[s.text for s in moves[:1]]}"),
            (len(others), f"states have another reason: {[s.text for s in others[:1]]}"),
            (len(driven), "commands are not 0"),
        ):
            if count:
                return f"{count:d} {what}"
        return ""

    return check


def off_path(seen: Seen) -> str:
    """The command's arc counts instead."""
    states = of(STATE, seen)
    if not states:
        return "no state"
    return "the path is followed" if any(s.on_path for s in states) else ""
