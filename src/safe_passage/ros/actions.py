"""What actionlib's server lacks: it does not live through a clock that goes back."""

from __future__ import annotations

import actionlib
import rospy
from actionlib.server_goal_handle import ServerGoalHandle


def survive_clock_jumps(server: actionlib.SimpleActionServer) -> None:
    """actionlib's own timer ends for good when the clock goes back."""
    inner = server.action_server
    inner.status_timer.shutdown()
    period = rospy.Duration.from_sec(1.0 / inner.status_frequency)
    inner.status_timer = rospy.Timer(period, inner.publish_status_async, reset=True)


def forget_goals(server: actionlib.SimpleActionServer) -> None:
    """After a clock jump: the server would take every new goal for older than the last."""
    server.current_goal = ServerGoalHandle()
    server.next_goal = ServerGoalHandle()
