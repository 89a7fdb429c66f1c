"""Distances and times against what can be worked out by hand."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from safe_passage.core.geometry import outline, placed, rotation
from safe_passage.monitoring.motion import process_noise, transition
from safe_passage.separation import Part, RobotState, SeparationMonitor, no_obstacles
from safe_passage.separation.distances import exact, make_table, nearest_along
from safe_passage.separation.limiter import Courses
from safe_passage.separation.prediction import STANDS, carried_on, position_deviation, predict
from safe_passage.separation.robot_motion import make_shape, plan_motion
from sep_people import BODY, LENGTH, WIDTH, assess, parameters, people

FRONT = 0.5 * LENGTH + BODY  # [m] from base to a person whom the robot's front touches


@pytest.mark.parametrize("robot, human", [(1.0, 0.0), (1.0, 1.5), (0.5, 0.8), (0.0, 2.0)])
def test_head_on(robot, human):
    found = assess(people((3.0, 0.0, -human, 0.0)), (robot, 0.0, 0.0))
    assert found.present_distance == pytest.approx(3.0 - FRONT)
    assert found.time_to_collision == pytest.approx((3.0 - FRONT) / (robot + human), abs=1e-6)
    assert found.predicted_distance == 0.0
    assert found.obstacle_id == 1


def test_crossing():
    """Its side meets the robot's when both have come to x = 2, if both are there in time."""
    found = assess(people((2.0, -3.0, 0.0, 1.5)))
    assert found.time_to_collision == pytest.approx((3.0 - 0.5 * WIDTH - BODY) / 1.5, abs=1e-6)
    behind = assess(people((2.0, -0.1, 0.0, 1.5)))  # has crossed when the robot comes
    assert math.isinf(behind.time_to_collision)


def test_parallel_and_behind():
    beside = assess(people((0.0, 1.5, 1.0, 0.0)))
    assert math.isinf(beside.time_to_collision)
    assert beside.predicted_distance == pytest.approx(1.5 - 0.5 * WIDTH - BODY)
    follows = assess(people((-2.0, 0.0, 1.5, 0.0)))
    assert follows.time_to_collision == pytest.approx((2.0 - FRONT) / 0.5, abs=1e-6)
    falls_back = assess(people((-2.0, 0.0, 0.5, 0.0)))
    assert math.isinf(falls_back.time_to_collision)
    assert falls_back.predicted_distance == pytest.approx(2.0 - FRONT)


def test_the_one_who_comes_first_decides_among_many():
    far = [(20.0 + i, 15.0, 0.0, 0.0) for i in range(30)]
    found = assess(people(*far, (3.0, 0.0, 0.0, 0.0), (1.5, 2.5, 0.0, -1.5)))
    assert found.obstacle_id == 32
    assert found.present_distance == pytest.approx(math.hypot(0.8, 2.04) - 0.1 * math.sqrt(0.5))


def test_not_the_nearest_now_but_the_one_whom_it_will_meet_decides():
    assert assess(people((0.0, 1.0, 0.0, 0.0), (2.5, 0.0, 0.0, 0.0))).obstacle_id == 2


def test_nobody():
    found = assess(no_obstacles())
    assert math.isinf(found.present_distance) and math.isinf(found.predicted_distance)
    assert (found.obstacle_id, found.required_distance) == (0, 0.0)


def test_what_stands_counts_only_if_told_so_or_a_person():
    wall = people((2.0, 0.0, 0.0, 0.0), moving=False)
    assert math.isinf(assess(wall).present_distance)
    assert math.isfinite(assess(wall, stationary_obstacles=True).present_distance)
    somebody = people((2.0, 0.0, 0.0, 0.0), moving=False, person=True)
    assert math.isfinite(assess(somebody).present_distance)


def test_the_arm_counts():
    monitor = SeparationMonitor(parameters())
    robot = RobotState(parts=[Part((0.5, 0.0), (1.2, 0.0), 0.1)])
    found = monitor.assess(0.0, people((3.0, 0.0, 0.0, 0.0)), robot)
    assert found.present_distance == pytest.approx(3.0 - 1.3 - BODY)


def test_growth_is_that_of_white_acceleration_noise():
    P = np.tile(np.diag([0.04, 0.01, 0.09, 0.01]), (2, 1, 1))
    times = np.array([0.0, 1.0, 2.0])
    expected = np.sqrt(0.04 + 0.09 * times**2 + 0.6 * times**3 / 3.0)
    assert position_deviation(P, times, 0.6) == pytest.approx(np.stack([expected, expected]))


def test_shapes_grow_by_their_uncertainty_up_to_a_limit():
    one = people((3.0, 0.0, 0.0, 0.0), deviation=0.1)
    prediction = predict(one, parameters(sigmas=2.0, max_growth=0.5))
    assert prediction.growth[0, 0] == pytest.approx(0.2)
    assert prediction.growth[0, 10] == pytest.approx(0.2 * math.sqrt(2.0))
    assert predict(one, parameters(sigmas=2.0, max_growth=0.1)).growth.max() == 0.1


def test_of_whom_no_speed_is_known_may_come_from_anywhere():
    prediction = predict(people((3.0, 0.0, 1.0, 0.0), deviation=3.0), parameters(max_growth=0.25))
    assert prediction.unknown.all() and not prediction.velocity.any()
    assert prediction.growth[0] == pytest.approx(0.25 + 1.6 * prediction.times)


def test_large_shapes_are_covered_by_few_discs():
    cells = 0.1 * (np.stack(np.meshgrid(np.arange(40), np.arange(20)), -1).reshape(-1, 2) + 0.5)
    one = people((2.0, 1.0, 0.0, 0.0))
    prediction = predict(type(one)(**{**vars(one), "cells": [cells]}), parameters())
    assert len(prediction.discs) <= 32
    discs = prediction.discs[:, :2] + prediction.centre
    corners = (cells[:, None] + 0.05 * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])).reshape(
        -1, 2
    )
    away = np.linalg.norm(corners[:, None] - discs, axis=-1) - prediction.discs[:, 2]
    assert away.min(axis=1).max() <= 1e-9


places = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))


@given(places, st.floats(0.0, 0.3))
def test_shapes_that_are_not_convex_and_parts(place, padding):
    """Against thousands of points along the outline, and another rule for what is inside."""
    corners = ((1.0, 0.5), (0.2, 0.0), (1.0, -0.5), (-1.0, -0.5), (-1.0, 0.5))
    arm = Part((0.0, 0.0), (2.0, 1.0), 0.2)
    p = parameters(footprint=corners, footprint_padding=padding)
    shape = make_shape(p, [arm])
    along = outline(np.array(corners), 0.001)
    way = np.linspace(0.0, 1.0, 3000)[:, None] * np.array(arm.end)
    to_edge = np.linalg.norm(along - place, axis=1).min()
    x, y = place
    notch = x > 0.2 and abs(y) <= 0.5 * (x - 0.2) / 0.8
    inside = abs(x) < 1.0 and abs(y) < 0.5 and not notch
    platform = (-to_edge if inside else to_edge) - padding
    limb = np.linalg.norm(way - place, axis=1).min() - 0.2
    found = shape.distance(np.array([place]))[0]
    assert found == pytest.approx(min(platform, limb), abs=2e-3)


states = st.lists(
    st.tuples(*[st.floats(-4.0, 4.0)] * 2, *[st.floats(-2.0, 2.0)] * 2), min_size=1, max_size=12
)
commands = st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-1.5, 1.5))


@settings(max_examples=40, deadline=None)
@given(states, commands)
def test_bounds_never_hide_the_nearest(given_states, command):
    """All pairs at all times, one by one, with the shape turned the other way round."""
    p = parameters()
    prediction = predict(people(*given_states, deviation=0.05), p)
    shape, motion = make_shape(p), plan_motion(command, None, p.horizon, p)
    poses = motion.at(prediction.times)
    found = nearest_along(prediction, poses, shape)
    least, present = np.inf, np.inf
    for i, (x, y, vx, vy) in enumerate(given_states):
        vx, vy = (vx, vy) if math.hypot(vx, vy) >= STANDS else (0.0, 0.0)
        for k, t in enumerate(prediction.times):
            cells = people((x + vx * t, y + vy * t, 0, 0)).cells[0]
            in_robot = (cells - poses[k, :2]) @ rotation(poses[k, 2])
            outside = np.maximum(np.abs(in_robot) - [0.5 * LENGTH, 0.5 * WIDTH], 0.0)
            true = np.hypot(*outside.T).min() - 0.1 * math.sqrt(0.5)
            least = min(least, true - prediction.growth[i, k])
            present = min(present, true) if k == 0 else present
    assert found.least_predicted == pytest.approx(max(least, 0.0), abs=1e-9)
    assert found.least_present == pytest.approx(max(present, 0.0), abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(states, commands, st.floats(0.0, 1.0))
def test_the_table_is_exact_where_it_matters(given_states, command, scale):
    p = parameters()
    prediction = predict(people(*given_states, deviation=0.05), p)
    shape, motion = make_shape(p), plan_motion(command, None, p.horizon, p)
    courses = Courses(motion, 0.0, prediction.times, p)
    enough = 0.5
    table = make_table(prediction, motion, shape, courses.reach, enough)
    course = courses.go_on(np.array([scale]))
    low, poses = table.along(course)[:, 0], motion.at(course[0])
    for i in range(len(prediction)):
        where = np.full(len(poses), i)
        true = exact(prediction, where, np.arange(len(poses)), poses, shape) - prediction.growth[i]
        near = (true > 0.0) & (true < enough - 0.05) & (prediction.times <= p.horizon)
        if near.any():
            row = np.abs(low[:, near] - true[near]).max(axis=1)
            assert row.min() < 0.05


@settings(max_examples=40, deadline=None)
@given(states, st.floats(0.0, 1.0), commands)
def test_carried_on_is_the_same_seen_later(given_states, age, motion):
    """From where the robot then is, people are where they have walked to."""
    p = parameters(agility=0.3)
    before = people(*given_states, deviation=0.2)
    after = carried_on(before, age, motion, p)
    walked = before.position + age * before.velocity
    assert placed(after.position, motion) == pytest.approx(walked, abs=1e-9)
    assert after.velocity @ rotation(motion[2]).T == pytest.approx(before.velocity, abs=1e-9)
    assert placed(after.cells[0], motion) == pytest.approx(
        before.cells[0] + age * before.velocity[0], abs=1e-9
    )
    F = transition(age)
    expected = F @ before.covariance[0] @ F.T + process_noise(age, 0.3 * np.eye(2)[None])[0]
    found = after.covariance[0]
    turn = np.kron(np.eye(2), rotation(motion[2]))
    assert turn @ found @ turn.T == pytest.approx(expected, abs=1e-9)


def test_who_hardly_moves_stands():
    """Carried on for 3 s the noise of a thing that stands would hold a robot beside it."""
    slow = predict(people((1.0, 1.0, 0.06, -0.06), (2.0, 0.0, 0.3, 0.0)), parameters())
    assert slow.velocity == pytest.approx(np.array([[0.0, 0.0], [0.3, 0.0]]))
