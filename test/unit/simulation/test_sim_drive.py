"""The base follows commands within its limits; its odometry drifts as told."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.core.geometry import compose
from safe_passage.simulation.drive import Base, Twist, moved
from safe_passage.simulation.robots import DriveModel

STEP = 0.025
speed = st.floats(-3.0, 3.0)


def base_of(seed: int = 0, **values) -> Base:
    return Base(DriveModel(**values), (0.0, 0.0, 0.0), np.random.default_rng(seed))


def go(base: Base, twist: Twist, seconds: float, start: float = 0.0) -> None:
    """Command `twist` all the time."""
    for i in range(round(seconds / STEP)):
        time = start + i * STEP
        base.command(twist, time)
        base.accept(*base.next(time, STEP), STEP)


@given(st.lists(st.tuples(speed, speed, speed), min_size=1, max_size=8), st.booleans())
def test_speed_and_acceleration_keep_their_limits(commands, omni):
    base = base_of(omni=omni)
    m = base.model
    for i in range(20 * len(commands)):  # half a second of each
        before = base.twist
        base.command(Twist(*commands[i // 20]), i * STEP)
        base.accept(*base.next(i * STEP, STEP), STEP)
        now = base.twist
        assert math.hypot(now.forward, now.left) <= m.max_speed + 1e-9
        assert abs(now.turn) <= m.max_turn_rate + 1e-9
        change = math.hypot(now.forward - before.forward, now.left - before.left)
        assert change <= m.acceleration * STEP + 1e-9
        assert abs(now.turn - before.turn) <= m.turn_acceleration * STEP + 1e-9
        assert omni or now.left == 0.0


def test_it_reaches_what_is_commanded():
    base = base_of(omni=True)
    go(base, Twist(0.3, -0.2, 0.5), 2.0)
    assert vars(base.twist) == pytest.approx({"forward": 0.3, "left": -0.2, "turn": 0.5})


def test_too_much_is_as_much_as_it_can_in_that_direction():
    base = base_of(omni=True)
    go(base, Twist(3.0, 4.0, 9.0), 3.0)
    most = base.model.max_speed
    assert vars(base.twist) == pytest.approx(
        {"forward": 0.6 * most, "left": 0.8 * most, "turn": 0.8}
    )


@given(st.floats(-1, 1), st.floats(-1, 1), st.floats(-2, 2), st.floats(0.01, 3.0))
def test_an_arc_is_exact_it_may_be_cut_anywhere(forward, left, turn, seconds):
    twist, start = Twist(forward, left, turn), (1.0, -2.0, 0.7)
    whole = moved(start, twist, seconds)
    halves = moved(moved(start, twist, 0.3 * seconds), twist, 0.7 * seconds)
    assert whole[:2] == pytest.approx(halves[:2], abs=1e-7)
    assert math.remainder(whole[2] - halves[2], 2 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_a_quarter_circle_by_hand():
    end = moved((0.0, 0.0, 0.0), Twist(0.5, 0.0, 0.5), math.pi)  # radius 1 m
    assert end == pytest.approx((1.0, 1.0, math.pi / 2))
    aside = moved((0.0, 0.0, 0.0), Twist(0.0, 0.5, 0.5), math.pi)
    assert aside == pytest.approx((-1.0, 1.0, math.pi / 2))


def test_without_commands_it_brakes_after_the_timeout():
    base = base_of()
    go(base, Twist(0.5), 2.0)
    last = 2.0 - STEP
    while base.twist.forward > 0.0 and last < 10.0:
        last += STEP
        fresh = last - (2.0 - STEP) <= base.model.command_timeout
        base.accept(*base.next(last, STEP), STEP)
        assert (base.twist.forward == pytest.approx(0.5)) == fresh
    assert last < 2.0 + base.model.command_timeout + 0.5 / base.model.acceleration + 2 * STEP


@pytest.mark.parametrize("bad", [Twist(math.nan), Twist(0.5, math.inf), Twist(0.5, 0.0, -math.inf)])
def test_a_command_that_is_not_finite_stops_it(bad):
    base = base_of()
    go(base, Twist(0.5), 1.0)
    go(base, bad, 1.0, start=1.0)
    assert base.twist == Twist()
    assert all(map(math.isfinite, base.pose))


def test_refused_it_stands_where_it_was():
    base = base_of()
    go(base, Twist(0.5), 1.0)
    pose = base.pose
    base.refuse()
    assert (base.pose, base.twist, base.bumped) == (pose, Twist(), True)


def error_after(seed: int, seconds: float, **values) -> float:
    base = base_of(seed, **values)
    go(base, Twist(0.5), seconds)
    return base.odometry[0] - base.pose[0]


def test_odometry_noise_is_that_share_of_a_seconds_way_whatever_the_step():
    errors = np.array([error_after(seed, 4.0, odometry_noise=0.04) for seed in range(300)])
    way = 0.5**2 * sum(min(1.0, (i + 1) * STEP * 0.8 / 0.5) ** 2 * STEP for i in range(160))
    assert errors.mean() == pytest.approx(0.0, abs=0.006)
    assert errors.std() == pytest.approx(0.04 * math.sqrt(way), rel=0.15)


def test_odometry_without_errors_is_the_way():
    base = Base(DriveModel(odometry_noise=0.0), (2.0, 1.0, 0.5), np.random.default_rng(0))
    go(base, Twist(0.4, 0.0, 0.3), 3.0)
    assert compose((2.0, 1.0, 0.5), base.odometry) == pytest.approx(base.pose)


def test_scale_and_drift_overrate_the_way():
    base = base_of(odometry_noise=0.0, odometry_scale=0.05)
    base.drift = 0.10
    go(base, Twist(0.5), 4.0)
    assert base.odometry[0] / base.pose[0] == pytest.approx(1.15)
