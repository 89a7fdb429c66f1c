"""Walkers' noise has an axis, their way; whatever else moves, or stands, has none."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mon_people import Thing, scene
from safe_passage.core.geometry import rotation
from safe_passage.monitoring.gait import agilities, follow
from safe_passage.monitoring.motion import predict, update
from safe_passage.monitoring.parameters import TrackerParameters

P = TrackerParameters()
DT, AGE = 0.04, 0.2  # [s] a cycle; since measurements that are put together were taken
STEP = 0.7  # [m]
speeds = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))


def tracks(**changes):
    values = {"x": 2.0, "y": 0.0, "vx": 1.2, "vy": 0.0, "size": 0.5, "moving": True, **changes}
    return scene(0.0, Thing(1, **values)).tracks


def carried(own, parameters=P):
    """(2, 2) agility of the body."""
    return agilities(own, parameters)[1][0]


@pytest.mark.parametrize("changes", [{"moving": False}, {"size": 2.5}, {"vx": 0.0}])
def test_what_does_not_walk_is_where_it_is_seen(changes):
    own = tracks(**changes)
    seen, bodies = agilities(own, P)
    density = P.moving_agility if own.moving[0] else P.agility
    assert seen[0] == pytest.approx(density * np.eye(2))
    assert bodies == pytest.approx(seen)
    away = own.with_(body=own.body + np.array([0.1, 0.1, 0.0, 0.0]))
    body, covariance = observed(away, own.x[:, :2])
    assert body == pytest.approx(own.x) and covariance == pytest.approx(own.P)


def test_who_walks_keeps_his_pace_and_may_turn():
    assert carried(tracks()) == pytest.approx(np.diag([P.pace_agility, P.moving_agility]))


def test_of_who_hardly_moves_the_way_says_little():
    slow = carried(tracks(vx=0.05))
    assert slow[0, 0] == pytest.approx((5.0 * P.moving_agility + P.pace_agility) / 6.0)


def test_a_pace_that_is_set_livelier_than_turns_is_not_taken_so():
    odd = TrackerParameters(moving_agility=0.1, pace_agility=0.5)
    assert carried(tracks(), odd) == pytest.approx(0.1 * np.eye(2))


@given(speeds, st.floats(-math.pi, math.pi), st.floats(0.1, 4.0))
def test_agility_is_a_covariance_and_turns_with_the_way(velocity, turn, size):
    own = tracks(vx=velocity[0], vy=velocity[1], size=size)
    R = rotation(turn)
    turned = own.with_(body=np.hstack([own.body[:, :2], own.body[:, 2:] @ R.T]))
    assert np.linalg.eigvalsh(carried(own)).min() > 0.0
    assert carried(turned) == pytest.approx(R @ carried(own) @ R.T, abs=1e-12)


def test_a_place_says_less_along_the_way_than_across_it():
    own = tracks()
    for ahead, side in ((0.1, 0.0), (0.0, 0.1)):
        body, _ = observed(own, own.x[:, :2] + (ahead, side), age=0.0)
        moved = np.hypot(*(body - own.body)[0, :2])
        assert (moved < 0.03) if ahead else (moved > 0.03)


@pytest.mark.parametrize("steps, most", [(0.19, 0.05), (0.25, 0.25)])
def test_legs_farther_off_than_a_step_brings_them_take_the_body_along(steps, most):
    own = tracks()
    body, _ = observed(own, own.x[:, :2] + (steps, 0.0), age=0.0)
    assert most / 3.0 < body[0, 0] - own.body[0, 0] < most


def observed(own, place, age=AGE):
    noise = P.position_noise**2 * np.eye(2)[None]
    return follow(own, np.array([0]), place, noise, np.array([age]), P)


def filtered(places):
    """(K, 4) bodies of a track whose legs' middle is in `places` (K, 2) one cycle after another."""
    first = (places[1] - places[0]) / DT
    own = tracks(x=places[0, 0], y=places[0, 1], vx=first[0], vy=first[1])
    spread = np.diag([0.02, 0.02, 0.3, 0.3])[None]
    own, states = own.with_(P=spread, body_covariance=spread), []
    for place in places:
        seen, bodies = agilities(own, P)
        x, legs = predict(own.x, own.P, DT, seen)
        x, legs = update(x, legs, place[None], P.position_noise**2 * np.eye(2), np.array([AGE]))
        body, covariance = predict(own.body, own.body_covariance, DT, bodies)
        own = own.with_(x=x, P=legs, body=body, body_covariance=covariance)
        body, covariance = observed(own, place[None])
        own = own.with_(body=body, body_covariance=covariance)
        states.append(body[0])
    return np.array(states)


def walk(velocities, swing_of=0.0):
    """Where the legs' middle was AGE before each cycle; it swings by so much [m] with each step."""
    v = np.array(velocities, float)
    way = np.cumsum(v * DT, axis=0) - v * AGE
    speed = np.hypot(*v.T)
    phase = 2.0 * math.pi * np.cumsum(speed * DT) / STEP
    u = v / np.maximum(speed, 1e-9)[:, None]
    return way + swing_of * np.sin(phase)[:, None] * u


@settings(max_examples=20)
@given(st.floats(0.8, 2.0), st.floats(-math.pi, math.pi))
def test_the_swing_of_legs_hardly_shows(speed, heading):
    """As simulated scans show it once they are put together: the less, the faster the steps."""
    v = speed * np.array([math.cos(heading), math.sin(heading)])
    legs = 0.1 / speed  # [m]
    swings = 2.0 * math.pi * speed / STEP * legs  # [m/s]
    late = filtered(walk([v] * 200, swing_of=legs))[75:]
    assert np.hypot(*(late[:, 2:] - v).T).max() < 0.35 * swings
    at = np.cumsum([v * DT] * 200, axis=0)[75:]
    assert np.hypot(*(late[:, :2] - at).T).max() < legs


def test_who_turns_or_stops_is_told_soon():
    turned = filtered(walk([(1.2, 0.0)] * 50 + [(0.0, 1.2)] * 50))
    assert turned[50 + 25, 2:] == pytest.approx([0.0, 1.2], abs=0.35)
    stopped = filtered(walk([(1.2, 0.0)] * 50 + [(0.0, 0.0)] * 50))
    assert np.hypot(*stopped[50 + 25, 2:]) < 0.35
