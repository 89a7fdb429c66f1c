"""Other parameters while a monitor runs: they count, and what it remembers stays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from safe_passage.separation import (
    Inputs,
    Reason,
    RobotState,
    SeparationMonitor,
    SeparationParameters,
    Supervisor,
)
from sep_people import people


def standing(x):
    """Somebody before the robot."""
    return people((x, 0.0, 0.0, 0.0))


class TestSeparation:
    parameters = SeparationParameters(
        robot_radius=0.3, release_time=1.0, rise_rate=0.5, release_margin=0.0
    )
    ahead = (0.5, 0.0, 0.0)

    def test_a_new_distance_counts_at_once(self):
        monitor = SeparationMonitor(self.parameters)
        robot, someone = RobotState(twist=self.ahead), standing(2.0)
        near = monitor.assess(0.0, someone, robot, self.ahead)
        monitor.tune(replace(self.parameters, min_distance=2.5))
        far = monitor.assess(0.1, someone, robot, self.ahead)
        assert far.scale < near.scale

    def test_the_release_goes_on_where_it_is(self):
        monitor = SeparationMonitor(self.parameters)
        robot = RobotState(twist=(0.0, 0.0, 0.0))
        assert monitor.assess(0.0, standing(0.7), robot, self.ahead).scale == 0.0
        monitor.tune(replace(self.parameters, release_time=0.5))
        scales = [
            monitor.assess(0.1 * k, standing(50.0), robot, self.ahead).scale for k in range(1, 9)
        ]
        assert scales[:5] == [0.0] * 5  # held for half a second since it was clear
        assert 0.0 < scales[-1] < 1.0  # and not let go at once

    def test_the_supervisor_knows_the_tracker_still(self):
        supervisor = Supervisor(replace(self.parameters, settle_time=0.5))
        ids, ages = np.array([1]), np.array([2.0])
        supervisor.saw_tracks(10.0, ids, ages)
        inputs = Inputs(10.3, 10.0, 10.3)
        assert supervisor.judge(inputs) is Reason.OK
        supervisor.tune(replace(self.parameters, settle_time=0.5, tracks_timeout=0.2))
        assert supervisor.judge(inputs) is Reason.STALE_TRACKS
        supervisor.tune(replace(self.parameters, settle_time=0.5))
        assert supervisor.judge(inputs) is Reason.OK
