"""Clock jumps, as a bag that starts over makes them; twin of include/safe_passage/ros/clock.h."""

from __future__ import annotations

import rospy


class JumpDetector:
    """Tells when the ROS clock went back, so that what was remembered has no meaning any more.

    A few milliseconds are no jump: wall clocks are set back by so much.
    """

    SLEW = rospy.Duration.from_sec(0.1)

    def __init__(self) -> None:
        self._last = rospy.Time()

    def jumped_back(self, now: rospy.Time) -> bool:
        """Compare `now` with the last call's time."""
        jumped = now + self.SLEW < self._last
        self._last = now
        return jumped
