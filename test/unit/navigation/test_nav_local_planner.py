"""The velocity chosen is reachable, free for the horizon, and leads on."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.core.geometry import outline, placed
from safe_passage.navigation.local_planner import PERIOD, LocalPlanner, Velocity, trajectories
from safe_passage.navigation.parameters import NavigatorParameters

PARAMETERS = NavigatorParameters()
PLANNER = LocalPlanner(PARAMETERS)
CLOSE = outline(np.array(PARAMETERS.footprint), spacing=0.02)
near = st.floats(-2.5, 2.5)


def apart_from(obstacles: np.ndarray, radius: float = 0.1):
    """Free is what is `radius` [m] from all obstacles (N, 2)."""

    def is_free(points: np.ndarray) -> np.ndarray:
        gaps = np.hypot(*np.moveaxis(points[..., None, :] - obstacles, -1, 0))
        return gaps.min(axis=-1, initial=np.inf) > radius

    return is_free


def distance_to(goal):
    return lambda points: np.hypot(*np.moveaxis(points - np.array(goal), -1, 0))


OPEN = apart_from(np.empty((0, 2)))


@given(
    st.lists(st.tuples(near, near), max_size=6), st.tuples(near, near), st.floats(0.0, 0.8),
    st.floats(-0.8, 0.8),
)  # fmt: skip
def test_what_is_chosen_never_hits_and_can_be_reached(obstacles, goal, forward, turn):
    """Judged on finer steps and with the outline itself, of which the planner's is a grown one."""
    spots = np.array(obstacles).reshape(-1, 2)
    p = PARAMETERS
    chosen = PLANNER.choose(Velocity(forward, turn), apart_from(spots), distance_to(goal))
    if chosen is None:
        return
    assert abs(chosen.forward - forward) <= p.acceleration * PERIOD + 1e-9
    assert 0.0 <= chosen.forward <= p.max_speed and abs(chosen.turn) <= p.max_turn_rate
    poses = trajectories(np.array([chosen.forward]), np.array([chosen.turn]), p.horizon)
    assert apart_from(spots, 0.07)(placed(CLOSE, poses)).all()


def test_in_the_open_it_speeds_up_towards_the_goal():
    ahead = PLANNER.choose(Velocity(0.4, 0.0), OPEN, distance_to((4.0, 0.0)))
    assert ahead.forward == pytest.approx(0.4 + PARAMETERS.acceleration * PERIOD)
    assert ahead.turn == pytest.approx(0.0, abs=1e-9)
    left = PLANNER.choose(Velocity(0.4, 0.0), OPEN, distance_to((1.0, 3.0)))
    right = PLANNER.choose(Velocity(0.4, 0.0), OPEN, distance_to((1.0, -3.0)))
    assert left.turn > 0.1 and right.turn == pytest.approx(-left.turn)


def test_before_a_wall_there_is_nothing_to_choose():
    y = np.linspace(-3.0, 3.0, 121)
    wall = np.stack([np.full(121, 0.49), y], axis=1)
    assert PLANNER.choose(Velocity(), apart_from(wall), distance_to((4.0, 0.0))) is None


def test_at_the_goal_there_is_nothing_to_gain():
    assert PLANNER.choose(Velocity(), OPEN, distance_to((0.0, 0.0))) is None


def test_it_makes_room_away_from_what_touches_it():
    assert PLANNER.make_room(apart_from(np.array([[0.36, 0.1]]), 0.05)).forward < 0.0
    assert PLANNER.make_room(apart_from(np.array([[-0.36, 0.1]]), 0.05)).forward > 0.0


def test_boxed_in_it_makes_no_room():
    x = np.linspace(-0.5, 0.5, 41)
    ends = np.concatenate([[(side, y) for y in x] for side in (0.42, -0.42)])
    assert PLANNER.make_room(apart_from(ends, 0.03)) is None


def test_turning_needs_room_for_the_corners():
    assert PLANNER.can_turn(0.5, OPEN)
    assert not PLANNER.can_turn(0.8, apart_from(np.array([[0.30, 0.45]]), 0.06))
    assert PLANNER.can_turn(0.8, apart_from(np.array([[0.0, 0.60]]), 0.06))


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_trajectories_are_arcs(forward, turn):
    poses = trajectories(np.array([forward]), np.array([turn]), 2.0)[0]
    steps = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    assert steps == pytest.approx(steps[0], abs=1e-9) and steps[0] <= abs(forward) * 0.1 + 1e-9
    assert poses[:, 2] == pytest.approx(turn * 0.1 * np.arange(1, 21))
    if abs(turn) > 0.05:
        radius = forward / turn
        from_centre = np.hypot(poses[:, 0], poses[:, 1] - radius)
        assert from_centre == pytest.approx(abs(radius), abs=1e-9)
