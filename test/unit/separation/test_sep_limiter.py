"""What is allowed, held back, released; ways out."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from safe_passage.separation import Level, Reason, RobotState, SeparationMonitor, no_obstacles
from safe_passage.separation.prediction import predict
from safe_passage.separation.zones import protective_distance
from sep_people import BODY, CELL, LENGTH, WIDTH, assess, parameters, people

AHEAD = (1.0, 0.0, 0.0)
KEPT = 0.33  # [m] min_distance and robot_uncertainty
speeds = st.floats(-1.5, 1.5)
commands = st.tuples(speeds, speeds, speeds)
states = st.lists(st.tuples(*[st.floats(-5.0, 5.0)] * 2, *[st.floats(-2.0, 2.0)] * 2), max_size=6)


@settings(max_examples=60, deadline=None)
@given(states, commands, commands, st.floats(0.0, 0.5))
def test_never_larger_and_never_in_another_direction(given_states, command, twist, deviation):
    monitor = SeparationMonitor(parameters())
    found = monitor.assess(
        0.0, people(*given_states, deviation=deviation), RobotState(twist), command
    )
    assert 0.0 <= found.scale <= 1.0
    limited, found = monitor.limit(command)
    assert limited == pytest.approx([found.scale * part for part in command])
    assert (found.level == Level.STOP) == (found.scale == 0.0)
    assert (found.level == Level.FREE) == (found.scale == 1.0)


@settings(max_examples=60, deadline=None)
@given(
    st.floats(1.0, 9.0), st.floats(0.0, 4.0), st.floats(0.0, 2.0), st.floats(0.2, 1.5),
    st.floats(-math.pi, math.pi),
)  # fmt: skip
def test_somebody_farther_away_never_slows_the_robot_more(near, more, human, robot, bearing):
    """Who comes straight at the robot, from ahead."""
    scales = []
    for distance in (near, near + more):
        scales.append(assess(people((distance, 0.0, -human, 0.0)), (robot, 0.0, 0.0)).scale)
    assert scales[0] <= scales[1] + 1e-9


@settings(max_examples=30, deadline=None)
@given(commands)
def test_without_obstacles_a_command_passes_unchanged(command):
    monitor = SeparationMonitor(parameters())
    monitor.assess(0.0, no_obstacles(), RobotState(), command)
    assert monitor.limit(command)[0] == command


@pytest.mark.parametrize("part", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("i", range(3))
def test_a_command_that_is_no_number_stops(part, i):
    monitor = SeparationMonitor(parameters())
    monitor.assess(0.0, no_obstacles(), RobotState(), AHEAD)
    command = [0.5, 0.0, 0.1]
    command[i] = part
    limited, found = monitor.limit(tuple(command))
    assert limited == (0.0, 0.0, 0.0)
    assert (found.level, found.reason) == (Level.STOP, Reason.BAD_COMMAND)


@settings(max_examples=80, deadline=None)
@given(
    st.floats(-math.pi, math.pi), st.floats(0.75, 1.0), st.floats(0.0, 1.5), st.floats(0.1, 1.2),
    st.floats(0.0, 0.2),
)  # fmt: skip
def test_a_robot_can_drive_away_from_who_is_too_near(bearing, distance, human, robot, deviation):
    """A round one that can drive sideways, so that away is away whatever the bearing."""
    towards = np.array([math.cos(bearing), math.sin(bearing)])
    monitor = SeparationMonitor(parameters(footprint=(), robot_radius=0.4))
    who = people((*(distance * towards), *(-human * towards)), deviation=deviation)
    command = (*(-robot * towards).tolist(), 0.0)
    found = monitor.assess(0.0, who, RobotState(), command)
    assume(found.present_distance < KEPT)
    into = monitor.limit((*(robot * towards).tolist(), 0.0))[0]
    assert into == (0.0, 0.0, 0.0)
    limited, found = monitor.limit(command)
    least = caught(found.present_distance, human, robot)
    if least > 0.07:  # it gets away
        assert found.reason is Reason.ESCAPE
        assert math.hypot(*limited) >= min(robot, 0.3) - 0.012 * robot
    elif least < 0.0 and found.reason is not Reason.ESCAPE:
        assert limited == (0.0, 0.0, 0.0)  # he walks into it all the same: it stands


def caught(gap, human, robot, acceleration=0.5):
    """[m] least distance to a robot that flees from standing for 3 s."""
    t = np.arange(0.0, 3.0, 0.01)
    rising = np.minimum(t, robot / acceleration)
    fled = robot * t - (robot * rising - 0.5 * acceleration * rising**2)
    return float((gap + fled - human * t).min())


def test_the_way_out_of_a_person_who_stands_is_slow_and_turning_is_one():
    who = people((0.6 + BODY + 0.1, 0.0, 0.0, 0.0))
    back = assess(who, (-1.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert back.scale == pytest.approx(0.3, abs=0.011)
    beside = people((0.0, 0.36 + BODY + 0.2, 0.0, 0.0))
    assert assess(beside, (0.0, 0.0, 0.4), (0.0,) * 3, footprint=(), robot_radius=0.36).scale == 1.0
    assert assess(beside, (0.0, 0.3, 0.0), (0.0,) * 3).scale == 0.0


def test_the_robot_does_not_creep_up_on_somebody():
    who = people((0.6 + BODY + KEPT - 0.05, 0.0, 0.0, 0.0))
    for speed in (0.005, 0.02, 0.1, 1.0):
        assert assess(who, (speed, 0.0, 0.0), (0.0,) * 3).scale == 0.0


def test_a_follower_who_would_be_there_before_it_has_braked_does_not_stop_the_robot():
    assert assess(people((-1.2, 0.0, 1.5, 0.0))).scale == 1.0


@pytest.mark.parametrize(
    "person",
    [
        (-2.6, 0.1, 1.1, 0.0),
        (-2.2, -0.3, 1.4, 0.1),
        (-0.7, -2.4, 0.25, 0.6),
        (-1.5, 2.5, 0.6, -0.7),
    ],
)
def test_who_walks_into_the_robot_from_behind_finds_it_standing(person):
    monitor, command = SeparationMonitor(parameters()), (0.5, 0.0, 0.0)
    x, speed = 0.0, 0.5
    for k in range(300):
        t = 0.05 * k
        px, py, vx, vy = person
        who = people((px + vx * t - x, py + vy * t, vx, vy))
        monitor.assess(t, who, RobotState((speed, 0.0, 0.0)), command)
        speed += np.clip(monitor.limit(command)[0][0] - speed, -0.03, 0.025)
        x += 0.05 * speed
        away = np.maximum(np.abs([px + vx * t - x, py + vy * t]) - [0.5 * LENGTH, 0.5 * WIDTH], 0.0)
        if np.hypot(*away) < BODY:
            assert speed < 0.05
            return


@pytest.mark.parametrize("seed", range(5))
def test_a_robot_gets_past_who_stands_beside_it_whatever_the_noise(seed):
    """It stopped with somebody 0.2 m beside its side; its way leads straight on."""
    rng = np.random.default_rng(seed)
    monitor, x, speed = SeparationMonitor(parameters()), 0.0, 0.0
    monitor.refuse(0.0, Reason.STALE_TRACKS)
    for k in range(1, 400):
        noise = rng.normal(0.0, [0.02, 0.02, 0.04, 0.04])
        who = people(np.array([0.5 - x, 0.36 + BODY + 0.2, 0.0, 0.0]) + noise)
        monitor.assess(0.05 * k, who, RobotState((speed, 0.0, 0.0)), (0.5, 0.0, 0.0))
        told = monitor.limit((0.5, 0.0, 0.0))[0][0]
        speed += np.clip(told - speed, -0.03, 0.025)
        x += 0.05 * speed
    assert x > 1.5


def test_a_foot_ahead_does_not_stay_there():
    """He passes before the robot; one foot is half a step ahead of him."""
    standing = people((2.0, 0.0, 0.0, 0.3))
    foot = np.array([[2.0, 0.5]])
    cells = [np.concatenate([standing.cells[0], foot])]
    in_stride = type(standing)(**{**vars(standing), "cells": cells})
    assert predict(in_stride, parameters()).radius[0] == pytest.approx(0.3)
    cart = type(standing)(**{**vars(standing), "cells": [cells[0] + [[0.0, 0.4]]]})
    assert predict(cart, parameters()).radius[0] > 0.9
    still = type(in_stride)(**{**vars(in_stride), "moving": np.zeros(1, bool)})
    everyone = parameters(stationary_obstacles=True)
    assert predict(still, everyone).radius[0] == pytest.approx(0.5 + CELL * math.sqrt(0.5))


def test_a_standing_robot_is_not_blocked_by_who_walks_past():
    for x in np.arange(-3.0, 3.1, 0.5):
        past = people((x, 0.36 + BODY + 0.6, 1.3, 0.0), deviation=0.05)
        assert assess(past, twist=(0.0, 0.0, 0.0)).scale == 1.0, x


def test_before_a_person_who_stands_it_slows_down_and_stops_in_time():
    monitor = SeparationMonitor(parameters())
    x, speed, scales = 0.0, 1.0, []
    for k in range(120):
        found = monitor.assess(
            0.1 * k, people((4.0 - x, 0.0, 0.0, 0.0)), RobotState((speed, 0, 0)), AHEAD
        )
        (told, _, _), _ = monitor.limit(AHEAD)
        speed += np.clip(told - speed, -0.06, 0.05)
        x += 0.1 * speed
        scales.append(found.scale)
    left = 4.0 - x - 0.5 * LENGTH - BODY
    assert KEPT - 0.05 <= left <= KEPT + 0.25
    assert max(np.diff(scales)) <= 0.0
    assert np.mean([0.0 < scale < 1.0 for scale in scales]) > 0.2


def test_protective_distance_is_the_sum_of_its_terms():
    p = parameters(reaction_time=0.5, min_distance=0.2, robot_uncertainty=0.05)
    assert protective_distance(1.6, 1.0, 2.0, 0.1, p) == pytest.approx(
        1.6 * 2.5 + 1.0 * 0.5 + 0.5 * 1.0 * 2.0 + 0.2 + 0.1 + 0.05
    )
    assert protective_distance(-1.0, -1.0, 0.0, 0.0, p) == pytest.approx(0.25)


@pytest.mark.parametrize("distance, free", [(0.0, False), (0.02, True)])
def test_the_protective_distance_is_what_is_kept_where_anybody_may_come(distance, free):
    """Of whom no speed is known S_p with v_h = human_speed decides."""
    p = parameters(worst_case=True, reaction_time=0.3, deceleration=1.0, horizon=4.0)
    S_p = protective_distance(1.6, 1.0, 1.0, 0.0, p)
    who = people((S_p + 0.5 * LENGTH + BODY + distance + (0.0 if free else -0.02), 0.0, 0.0, 0.0))
    found = SeparationMonitor(p).assess(0.0, who, RobotState(AHEAD), AHEAD)
    assert found.required_distance == pytest.approx(S_p)
    assert (found.scale > 0.99) == free


def test_released_after_a_while_and_not_at_once():
    monitor = SeparationMonitor(parameters(release_time=0.5, rise_rate=2.0))
    robot = RobotState()
    near, stamp = people((1.0, 0.0, 0.0, 0.0)), 0.0
    assert monitor.assess(stamp, near, robot, AHEAD).level is Level.STOP
    rise = []
    for k in range(1, 15):
        rise.append(monitor.assess(0.1 * k, no_obstacles(), robot, AHEAD).scale)
    assert rise[:5] == [0.0] * 5
    assert np.diff(rise[4:10]) == pytest.approx(0.2)
    assert rise[-1] == 1.0


def test_it_is_not_released_at_the_border():
    """What is just far enough to go on is too near to begin."""
    border = people((0.6 + BODY + KEPT + 0.09, 0.0, 0.0, 0.0))
    robot, slow = RobotState(), (0.1, 0.0, 0.0)
    assert assess(border, slow, (0.0,) * 3).scale > 0.3
    monitor = SeparationMonitor(parameters())
    monitor.assess(0.0, people((0.9, 0.0, 0.0, 0.0)), robot, slow)
    for k in range(1, 30):
        found = monitor.assess(0.1 * k, border, robot, slow)
    assert found.scale < 0.05


def test_backing_off_is_not_held_back_by_a_stop_ahead():
    monitor = SeparationMonitor(parameters())
    near = people((1.0, 0.0, 0.0, 0.0))
    assert monitor.assess(0.0, near, RobotState(), AHEAD).scale == 0.0
    assert monitor.limit((-0.3, 0.0, 0.0))[0][0] == pytest.approx(-0.3, abs=0.01)


def test_a_stop_for_another_reason_is_released_by_itself_and_slowly():
    monitor = SeparationMonitor(parameters())
    refused = monitor.refuse(0.0, Reason.STALE_TRACKS)
    assert (refused.level, refused.reason, refused.scale) == (Level.STOP, Reason.STALE_TRACKS, 0.0)
    assert math.isnan(refused.present_distance)
    assert monitor.limit(AHEAD)[0] == (0.0, 0.0, 0.0)
    scales = []
    for k in range(20):
        scales.append(monitor.assess(0.1 * k, no_obstacles(), RobotState(), AHEAD).scale)
    assert (scales[0], scales[-1]) == (0.0, 1.0)
    assert max(np.diff(scales)) <= 0.1 + 1e-9


def test_where_stopping_is_in_the_way_the_robot_clears_it():
    """He comes at a slant: a robot that brakes is where he will be, one that goes on is past."""
    comes, fast = people((3.6, -1.7, -0.6, 0.4)), (1.2, 0.0, 0.0)
    found = assess(comes, fast)
    assert (found.scale, found.time_to_collision) == (1.0, math.inf)
    assert 0.1 < found.predicted_distance < KEPT
    monitor = SeparationMonitor(parameters())
    monitor.refuse(0.0, Reason.STALE_TRACKS)
    assert monitor.assess(0.1, comes, RobotState(fast), fast).scale == 1.0  # no time to wait
    monitor = SeparationMonitor(parameters())
    monitor.assess(0.0, comes, RobotState(), fast)  # stands, and may wait for him
    assert monitor.limit(fast)[1].scale < 1.0


def test_what_only_its_uncertainty_brings_too_near_makes_it_slow():
    """He walks up to the robot's front; it is sure where he is, not where he will be."""
    near = people((0.6 + 3.0 + BODY + KEPT + 0.3, 0.0, -1.0, 0.0))
    covariance = np.tile(np.diag([0.0, 0.0, 0.04, 0.04]), (1, 1, 1))
    unsure = type(near)(**{**vars(near), "covariance": covariance})
    assert assess(near, twist=(0.0,) * 3, stop_horizon=3.0).scale == pytest.approx(0.45, abs=0.05)
    found = assess(unsure, twist=(0.0,) * 3, stop_horizon=3.0, max_growth=2.0)
    assert found.scale == pytest.approx(0.2, abs=0.01)
    sure_to_stop = assess(
        unsure, twist=(0.0,) * 3, stop_horizon=3.0, max_growth=2.0, cautious_speed=0.0
    )
    assert sure_to_stop.scale == 0.0


def test_a_place_to_stop_at_stays_clear():
    """Driving on meets him at once, stopping later; either way it must not drive on."""
    comes = people((6.5, 0.0, -1.0, 0.0))
    assert assess(comes, stop_horizon=3.0).scale > assess(comes, stop_horizon=6.0).scale
