"""The navigator in a hall: it arrives, docks, waits, and gives up."""

from __future__ import annotations

import math

import numpy as np
import pytest
from nav_hall import Drive, hall
from safe_passage.navigation import State

EMPTY = hall()
CORRIDOR = hall(walls=[{"points": [[-5, 0.8], [5, 0.8]]}, {"points": [[-5, -0.8], [5, -0.8]]}])


def somewhere(seed: int) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    rng = np.random.default_rng(seed)
    low, high = (-4.0, -3.0, -math.pi), (4.0, 3.0, math.pi)
    return tuple(rng.uniform(low, high)), tuple(rng.uniform(low, high))


@pytest.mark.parametrize("seed", range(5))
def test_it_reaches_any_pose_in_an_empty_hall_from_any(seed):
    start, goal = somewhere(seed)
    drive = Drive(EMPTY, start)
    drive.navigator.set_goal(goal)
    drive.until(90.0)
    p, pose = drive.parameters, drive.base.pose
    assert drive.navigator.state is State.SUCCEEDED and drive.touched == 0
    assert math.dist(pose[:2], goal[:2]) < 2 * p.xy_tolerance
    assert abs(math.remainder(pose[2] - goal[2], 2 * math.pi)) < 2 * p.yaw_tolerance


@pytest.mark.parametrize("yaw", [0.0, 0.5 * math.pi, math.pi, -0.5 * math.pi])
def test_it_docks_at_a_wall_and_does_not_touch_it(yaw):
    side = 5.0 if abs(math.cos(yaw)) > 0.5 else 4.0
    at = side - 0.36 - 0.10
    drive = Drive(EMPTY, (0.5, -0.3, 1.0))
    drive.navigator.set_goal((at * math.cos(yaw), at * math.sin(yaw), yaw))
    drive.until(90.0)
    gap = side - (drive.corners @ (math.cos(yaw), math.sin(yaw))).max()
    assert drive.navigator.state is State.SUCCEEDED and drive.touched == 0
    assert 0.0 < gap <= 0.15


def test_it_goes_around_a_wall():
    drive = Drive(hall(walls=[{"points": [[0, -4], [0, 1.5]]}]), (-3.0, -2.0, 0.0))
    drive.navigator.set_goal((3.0, -2.0, -1.5))
    drive.until(120.0)
    assert drive.navigator.state is State.SUCCEEDED and drive.touched == 0


def crowd_until(end: float):
    """People all across the corridor at x = 1 until `end` [s]."""
    y = np.arange(-0.8, 0.8, 0.04)
    people = np.stack([np.full_like(y, 1.0), y], axis=1)
    return lambda time: people if time < end else np.empty((0, 2))


@pytest.mark.parametrize("T_map_seen", [(0.0, 0.0, 0.0), (0.7, -0.4, 2.5)])
def test_it_waits_for_people_in_its_way_and_goes_on_when_they_leave(T_map_seen):
    drive = Drive(CORRIDOR, (-3.0, 0.0, 0.0), crowd_until(20.0), T_map_seen)
    drive.navigator.set_goal((3.5, 0.0, 0.0))
    drive.until(20.0)
    assert State.WAITING in drive.states
    assert -0.5 < drive.corners[:, 0].max() < 1.0
    drive.until(90.0)
    assert drive.navigator.state is State.SUCCEEDED and drive.touched == 0


def test_it_gives_up_when_its_patience_ends():
    drive = Drive(CORRIDOR, (-3.0, 0.0, 0.0), crowd_until(math.inf), patience=10.0)
    drive.navigator.set_goal((3.5, 0.0, 0.0))
    drive.until(90.0)
    assert drive.navigator.state is State.ABORTED
    assert 10.0 < drive.time < 40.0 and drive.corners[:, 0].max() < 1.0
    assert not drive.navigator.active


def test_a_goal_without_a_way_is_given_up():
    drive = Drive(hall(walls=[{"points": [[0, -4], [0, 4]]}]), (-3.0, 0.0, 0.0), patience=5.0)
    drive.navigator.set_goal((3.0, 0.0, 0.0))
    drive.until(60.0)
    assert drive.navigator.state is State.ABORTED and drive.touched == 0


@pytest.mark.parametrize("at", [0, 1, 2])
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_goal_that_is_not_finite_is_a_value_error_and_changes_nothing(bad, at):
    drive = Drive(EMPTY, (0.0, 0.0, 0.0))
    goal = [1.0, 1.0, 0.0]
    goal[at] = bad
    with pytest.raises(ValueError, match="must be finite"):
        drive.navigator.set_goal(tuple(goal))
    assert drive.navigator.state is State.IDLE


def test_a_new_goal_takes_the_place_of_the_old_and_cancel_stops():
    drive = Drive(EMPTY, (0.0, 0.0, 0.0))
    drive.navigator.set_goal((3.0, 0.0, 0.0))
    drive.until(3.0)
    drive.navigator.set_goal((-3.0, -1.0, 3.0))
    drive.until(6.0)
    assert drive.navigator.active
    drive.until(90.0)
    assert math.dist(drive.base.pose[:2], (-3.0, -1.0)) < 0.1
    drive.navigator.set_goal((3.0, 0.0, 0.0))
    drive.navigator.cancel()
    assert not drive.navigator.active and drive.navigator.state is State.IDLE
