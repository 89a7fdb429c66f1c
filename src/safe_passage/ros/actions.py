"""What goals are refused by, and what actionlib's server lacks: to live through clock jumps."""

from __future__ import annotations

from typing import Any

import actionlib
import rospy


class RefusedError(Exception):
    """Why a goal has no result.

    Args:
        reason: what the action's result calls it.
        why: the same in a sentence.
    """

    def __init__(self, reason: Any, why: str) -> None:
        super().__init__(why)
        self.reason = reason


def survive_clock_jumps(server: actionlib.SimpleActionServer) -> None:
    """actionlib's own timer ends for good when the clock goes back."""
    inner = server.action_server
    inner.status_timer.shutdown()
    period = rospy.Duration.from_sec(1.0 / inner.status_frequency)
    inner.status_timer = rospy.Timer(period, inner.publish_status_async, reset=True)


def forget_goals(server: actionlib.SimpleActionServer) -> None:
    """After a clock jump: the server would refuse every new goal as older than the last one.

    Or than the last that was cancelled. A goal that is being worked on is not ended by this.
    """
    inner = server.action_server
    with inner.lock, server.lock:
        inner.last_cancel = rospy.Time()
        for handle in (server.current_goal, server.next_goal):
            if handle.get_goal():
                handle.get_goal_id().stamp = rospy.Time()
