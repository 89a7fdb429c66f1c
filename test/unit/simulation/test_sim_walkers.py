"""Walkers go to and fro as planned, as a function of time alone."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.core.errors import ParameterError
from safe_passage.simulation.walkers import Walker
from safe_passage.simulation.worlds import PersonPlan

LINE = PersonPlan(waypoints=((0.0, 0.0), (4.0, 0.0)), speed=1.0, pause=2.0)


def test_there_a_pause_and_back():
    walker = Walker(LINE)
    there, pausing, back, paused, again = (walker.at(t) for t in (1.0, 5.0, 7.0, 11.0, 13.0))
    assert (there.x, there.yaw, there.velocity, there.stands) == (1.0, 0.0, (1.0, 0.0), False)
    assert (pausing.x, pausing.velocity, pausing.stands) == (4.0, (0.0, 0.0), True)
    assert back.x == pytest.approx(3.0) and abs(back.yaw) == pytest.approx(math.pi)
    assert back.velocity == pytest.approx((-1.0, 0.0))
    assert paused.x == pytest.approx(0.0) and paused.stands
    assert again.x == pytest.approx(1.0) and again.velocity == (1.0, 0.0)


@given(st.floats(0.0, 100.0))
def test_it_comes_round_again(time):
    now, later = Walker(LINE).at(time), Walker(LINE).at(time + 2 * (4.0 / 1.0 + 2.0))
    assert (later.x, later.y) == pytest.approx((now.x, now.y), abs=1e-6)


points = st.lists(
    st.tuples(st.integers(-5, 5).map(float), st.integers(-5, 5).map(float)), min_size=1, max_size=5
)


@given(points, st.floats(0.2, 2.0), st.floats(0.0, 3.0), st.floats(0.0, 8.0), st.floats(0.0, 60.0))
def test_it_never_leaps_and_its_velocity_is_its_motion(waypoints, speed, pause, start, time):
    walker = Walker(PersonPlan(waypoints=tuple(waypoints), speed=speed, pause=pause, start=start))
    dt = 1e-3
    now, soon = walker.at(time), walker.at(time + dt)
    moved = np.array([soon.x - now.x, soon.y - now.y])
    assert np.hypot(*moved) <= speed * dt + 1e-9
    assert soon.walked >= now.walked - 1e-9
    assert math.hypot(*now.velocity) == pytest.approx(0.0 if now.stands else speed)
    if not now.stands and now.velocity == pytest.approx(soon.velocity):
        assert moved / dt == pytest.approx(np.array(now.velocity), abs=1e-6)
        facing = (math.cos(now.yaw), math.sin(now.yaw))
        assert facing == pytest.approx(np.array(now.velocity) / speed, abs=1e-6)


def test_several_way_points_are_passed_in_order():
    walker = Walker(PersonPlan(waypoints=((0.0, 0.0), (2.0, 0.0), (2.0, 3.0)), speed=1.0))
    corner, after, back = walker.at(2.0), walker.at(3.0), walker.at(9.0)
    assert (corner.x, corner.y) == pytest.approx((2.0, 0.0))
    assert (after.x, after.y) == pytest.approx((2.0, 1.0))
    assert after.yaw == pytest.approx(math.pi / 2)
    assert (back.x, back.y) == pytest.approx((1.0, 0.0)) and abs(back.yaw) == pytest.approx(math.pi)


def test_one_way_point_or_the_same_twice_is_standing():
    for waypoints in (((1.0, 2.0),), ((1.0, 2.0), (1.0, 2.0))):
        state = Walker(PersonPlan(waypoints=waypoints, yaw=0.7)).at(12.3)
        assert (state.x, state.y, state.yaw, state.stands) == (1.0, 2.0, 0.7, True)


def test_a_way_point_named_twice_does_not_turn_the_walker():
    twice = PersonPlan(waypoints=((0.0, 0.0), (0.0, 3.0), (0.0, 3.0)), speed=1.0, pause=5.0)
    assert Walker(twice).at(4.0).yaw == pytest.approx(math.pi / 2)


def test_start_is_a_place_along_the_way():
    late = PersonPlan(waypoints=LINE.waypoints, speed=2.0, start=3.0)
    assert Walker(late).at(0.0).x == pytest.approx(3.0)
    assert Walker(late).at(0.25).x == pytest.approx(3.5)


@pytest.mark.parametrize(
    "values, named",
    [({"speed": 0.0}, "speed"), ({"pause": -1.0}, "pause"), ({"start": -1.0}, "start"),
     ({"waypoints": ()}, "waypoints"), ({"waypoints": ((1.0, 2.0, 3.0),)}, "waypoints")],
)  # fmt: skip
def test_a_plan_that_cannot_be_walked_is_refused(values, named):
    with pytest.raises(ParameterError, match=named):
        PersonPlan(**values)
