"""A sensor's topic: what waits, what is given out, and what a node that is behind drops."""

import pytest
import rospy
import tf2_ros
from safe_passage.ros.diagnostics import Outcome
from safe_passage.ros.sensor_input import QUEUE, InputLimits, SensorInput
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header

PERIOD = 0.01  # [s]
LIMITS = InputLimits(max_age=0.5, max_future=0.1, transform_tolerance=0.1)


class Counts:
    """Stands in for the node's diagnostics."""

    def __init__(self):
        self.outcomes = []

    def expect(self, name):
        pass

    def count(self, name, outcome, detail=""):
        self.outcomes.append(outcome)

    def of(self, outcome):
        return self.outcomes.count(outcome)


class Topic:
    """An input, without a master; tf knows stamps up to `known` [s]."""

    def __init__(self, monkeypatch, **how):
        monkeypatch.setattr(rospy, "Subscriber", self.subscribe)
        monkeypatch.setattr(rospy, "resolve_name", lambda name: "/" + name)
        monkeypatch.setattr(rospy.Time, "now", lambda: rospy.Time.from_sec(self.now))
        self.counts, self.now, self.known = Counts(), 100.0, 1000.0
        self.input = SensorInput(
            "scan", LaserScan, LIMITS, self.counts, lambda message: None, self.place, **how
        )

    def subscribe(self, topic, kind, callback, **_):
        self.receive = callback

    def place(self, entry):
        if entry.stamp.to_sec() > self.known:
            raise tf2_ros.ExtrapolationException("not yet")
        return round(entry.stamp.to_sec(), 3)

    def come(self, number):
        """So many messages, PERIOD apart; returns their stamps."""
        stamps = [round(self.now + PERIOD * (i + 1), 3) for i in range(number)]
        for stamp in stamps:
            self.now = stamp
            self.receive(LaserScan(header=Header(stamp=rospy.Time.from_sec(stamp), frame_id="a")))
        return stamps

    def take(self):
        return [placed for placed, _ in self.input.take(rospy.Time.from_sec(self.now))]


def test_all_are_given_out_oldest_first(monkeypatch):
    topic = Topic(monkeypatch)
    stamps = topic.come(7)
    assert topic.take() == stamps
    assert topic.take() == []
    assert topic.counts.of(Outcome.OK) == 7


@pytest.mark.parametrize("most", [1, 2, 6])
def test_a_node_that_is_behind_drops_the_oldest_and_says_so(monkeypatch, most):
    topic = Topic(monkeypatch, most=most)
    stamps = topic.come(7)
    assert topic.take() == stamps[-most:]
    assert topic.counts.of(Outcome.CROWDED_OUT) == 7 - most
    assert topic.counts.of(Outcome.OK) == most
    assert topic.take() == [] and not topic.input.waits


def test_it_goes_on_without_loss_once_it_keeps_up(monkeypatch):
    topic = Topic(monkeypatch, most=1)
    topic.come(7)
    topic.take()
    before = topic.counts.of(Outcome.CROWDED_OUT)
    for _ in range(5):
        came = topic.come(1)
        assert topic.take() == came
    assert topic.counts.of(Outcome.CROWDED_OUT) == before


def test_what_waits_for_tf_crowds_nothing_out(monkeypatch):
    """The newest of which tf knows the place counts, and the others' turn comes."""
    topic = Topic(monkeypatch, most=1)
    stamps = topic.come(4)
    topic.known = stamps[1]
    assert topic.take() == [stamps[1]]
    assert topic.counts.of(Outcome.CROWDED_OUT) == 1
    topic.known = stamps[2]
    assert topic.take() == [stamps[2]]
    topic.known = stamps[3]
    assert topic.take() == [stamps[3]]
    assert topic.counts.of(Outcome.CROWDED_OUT) == 1


def test_those_that_wait_keep_their_order(monkeypatch):
    topic = Topic(monkeypatch)
    topic.known = 0.0
    stamps = topic.come(3)
    assert topic.take() == []
    stamps += topic.come(3)
    topic.known = 1000.0
    assert topic.take() == stamps


def test_without_tf_the_wait_ends(monkeypatch):
    topic = Topic(monkeypatch, most=1)
    topic.known = 0.0
    topic.come(3)
    topic.now += LIMITS.transform_tolerance + PERIOD
    assert topic.take() == []
    assert topic.counts.of(Outcome.NO_TF) == 3 and not topic.input.waits


def test_memory_is_bounded(monkeypatch):
    topic = Topic(monkeypatch)
    stamps = topic.come(QUEUE + 3)
    assert topic.counts.of(Outcome.CROWDED_OUT) == 3
    assert topic.take() == stamps[3:]
