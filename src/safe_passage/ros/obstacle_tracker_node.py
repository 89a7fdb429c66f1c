"""Node `obstacle_tracker`: lidars and depth cameras -> every obstacle, and who is a person."""

from __future__ import annotations

import time

import rospy

from safe_passage.monitoring.persons import PersonLabels
from safe_passage.monitoring.pipeline import ObstacleTracker
from safe_passage.ros.clock import JumpDetector
from safe_passage.ros.diagnostics import NodeDiagnostics
from safe_passage.ros.live_tuning import LiveTuning
from safe_passage.ros.parameters import private_values
from safe_passage.ros.tracker_inputs import Taken, TrackerInputs
from safe_passage.ros.tracker_outputs import TrackerOutputs
from safe_passage.ros.tracker_parameters import LIVE, make_tracker_parameters
from safe_passage.ros.tracker_persons import PersonInputs

LOOK_ROUND = 0.2  # [s] of wall time without news, after which the clock is looked at
JITTER = 0.1  # share of a cycle by which measurements may come early


class ObstacleTrackerNode:
    """A cycle at the newest measurement's stamp, whenever something new can be placed by tf.

    Without measurements there is no cycle and no message: tracks of a blind robot would look fresh.
    """

    def __init__(self) -> None:
        self._p = make_tracker_parameters(private_values(), rospy.get_name())
        self._tracker, self._labels = ObstacleTracker(self._p), PersonLabels(self._p.person_labels)
        self._jumps, self._last = JumpDetector(), rospy.Time()
        self._taken: list[Taken] = []
        self._diagnostics = NodeDiagnostics(self._p.input_timeout)
        self._outputs = TrackerOutputs(self._p)
        self._inputs = TrackerInputs(self._p, self._diagnostics)
        self._persons = PersonInputs(self._p, self._inputs.tf, self._diagnostics)
        self._tuning = LiveTuning(self._p, LIVE)
        frames, topics = f"{self._p.odom_frame} -> {self._p.base_frame}", self._inputs.topics
        rospy.loginfo(f"obstacle tracker waits for tf {frames} and for {', '.join(topics)}")

    def spin(self) -> None:
        """Track until shutdown; in the main thread, so that a fault ends the node."""
        while not rospy.is_shutdown():
            self._inputs.wait(LOOK_ROUND)
            self._tune()
            if self._jumps.jumped_back(rospy.Time.now()):
                self._restart()
            self._taken += self._inputs.take(rospy.Time.now())
            if self._taken:
                self._cycle(max(self._taken, key=lambda taken: taken.stamp))

    def _tune(self) -> None:
        """Between two cycles; tracks and labels stay."""
        parameters = self._tuning.take()
        if parameters is None:
            return
        self._p = parameters
        self._tracker.tune(parameters)
        self._labels.tune(parameters.person_labels)
        self._outputs.tune(parameters)

    def _cycle(self, newest: Taken) -> None:
        if (newest.stamp - self._last).to_sec() * self._p.rate < 1.0 - JITTER:
            return  # not yet; or late, and taken along by the next
        taken, self._taken = sorted(self._taken, key=lambda one: one.stamp), []
        now = newest.measurement
        snapshot = self._tracker.update(now.stamp, now.pose, [one.measurement for one in taken])
        persons = self._labels.update(snapshot, self._persons.take(rospy.Time.now()))
        self._last = newest.stamp
        self._outputs.publish(snapshot, persons, newest.stamp, self._inputs.fields_of_view)
        self._diagnostics.latency(time.monotonic() - min(one.arrived for one in taken))

    def _restart(self) -> None:
        rospy.logwarn("the clock went back: the tracker starts anew")
        self._inputs.restart()
        self._persons.restart()
        self._outputs.restart()
        self._tracker.reset()
        self._labels.reset()
        self._taken, self._last = [], rospy.Time()


def main() -> None:
    """Run the node."""
    rospy.init_node("obstacle_tracker")
    ObstacleTrackerNode().spin()
