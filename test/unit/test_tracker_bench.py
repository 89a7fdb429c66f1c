"""What bench/tracker.py measures with: the field of objects, the peers, the stages' shares."""

import numpy as np
import pytest
from safe_passage.monitoring.pipeline import ObstacleTracker

from bench.tracker_cost import shares
from bench.tracker_field import Field, parameters, prepare
from bench.tracker_peers import Held, MovingRule, make_peer


def test_every_object_of_the_field_is_a_track():
    tracker = ObstacleTracker(parameters())
    for stamp, pose, raw in Field(60, 1).cycles(12):
        snapshot = tracker.update(stamp, pose, prepare(stamp, pose, raw))
    assert abs(int(snapshot.confirmed.sum()) - 60) <= 1


def test_objects_of_the_field_keep_apart():
    field = Field(300, 1)
    for time in (0.0, 1.0, 2.5):
        at = field.objects(time)
        apart = np.hypot(*np.moveaxis(at[:, None] - at[None], -1, 0)) + 9.0 * np.eye(300)
        assert apart.min() > 0.3


def test_a_field_is_the_same_every_time():
    first, again = (list(Field(50, 2).cycles(2)) for _ in range(2))
    assert (first[1][2][0] == again[1][2][0]).all()


@pytest.mark.parametrize("name", ["norfair", "stonesoup"])
def test_peers_follow_one_who_walks(name):
    pytest.importorskip(name)
    period = 0.08
    peer = make_peer(name, parameters(), period)
    for cycle in range(40):
        stamp = cycle * period
        positions = np.array([[1.2 * stamp, 1.0], [4.0, -2.0]])
        held = peer.update(stamp, positions)
    assert len(held) == 2
    walker = min(held, key=lambda one: np.hypot(*(one.position - positions[0])))
    assert walker.velocity == pytest.approx([1.2, 0.0], abs=0.15)
    assert walker.position == pytest.approx(positions[0], abs=0.1)
    assert walker.seen == pytest.approx(stamp)


def test_moving_is_latched():
    p = parameters()
    rule = MovingRule(p, 0.1)

    def at(x: float, speed: float) -> bool:
        return rule.moves(Held(1, np.array([x, 0.0]), np.array([speed, 0.0]), 1e3, 0.0))

    assert not any(at(0.0, 1.0) for _ in range(10))  # fast, but where it was
    assert [at(1.0, 1.0) for _ in range(round(p.moving_time / 0.1) + 1)][-1]
    assert at(1.0, 0.0)


def test_shares_are_those_of_what_update_calls():
    update = ("monitoring/pipeline.py", 1, "update")
    stats = {
        update: (1, 1, 0.1, 0.8, {}),
        ("x.py", 1, "prepare"): (1, 1, 0.2, 0.2, {}),
        ("y.py", 1, "_observe"): (1, 1, 0.5, 0.7, {update: (1, 1, 0.5, 0.6)}),
        ("y.py", 2, "deep"): (1, 1, 0.5, 0.5, {("y.py", 1, "_observe"): (1, 1, 0.5, 0.5)}),
    }
    found = shares(stats)
    assert found["observe"] == pytest.approx(0.6)
    assert found["preprocessing"] == pytest.approx(0.2)
    assert found["other"] == pytest.approx(0.2)
