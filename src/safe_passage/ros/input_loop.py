"""The main thread of a node that waits for messages."""

from __future__ import annotations

import threading
from typing import Callable, Iterator

import rospy

from safe_passage.ros.clock import JumpDetector

LOOK_ROUND = 0.2  # [s] of wall time without news, after which the clock is looked at
WAITING = 0.005  # [s] the same while a message waits for tf or something else


def rounds(
    news: threading.Event, waits: Callable[[], bool], restart: Callable[[], None]
) -> Iterator[rospy.Time]:
    """The time now, whenever something may have come, until shutdown.

    In the main thread, so that a fault in what is done with it ends the node.

    Args:
        news: is set when something has come.
        waits: whether a message is there that lacks something else.
        restart: is called when the clock went back, before that time is given out.
    """
    jumps = JumpDetector()
    rospy.on_shutdown(news.set)
    while not rospy.is_shutdown():
        news.wait(WAITING if waits() else LOOK_ROUND)
        news.clear()
        now = rospy.Time.now()
        if jumps.jumped_back(now):
            restart()
        yield now
