"""Where the robot will be: arcs, paths, and when a path is not followed."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.core.geometry import compose
from safe_passage.separation.limiter import Courses
from safe_passage.separation.robot_motion import plan_motion
from sep_people import assess, parameters, people

P = parameters()
U = np.arange(0.0, 3.01, 0.5)
twists = st.floats(-1.5, 1.5)


@given(twists, twists, twists)
def test_an_arc_is_many_small_steps(vx, vy, w):
    pose, n = (0.0, 0.0, 0.0), 2000
    for _ in range(n):
        half = 0.5 * w * 2.0 / n
        step = (
            vx * math.cos(half) - vy * math.sin(half),
            vx * math.sin(half) + vy * math.cos(half),
        )
        pose = compose(pose, (step[0] * 2.0 / n, step[1] * 2.0 / n, w * 2.0 / n))
    found = plan_motion((vx, vy, w), None, 2.0, P).at(np.array([2.0]))[0]
    assert found[:2] == pytest.approx(pose[:2], abs=1e-3)
    assert math.remainder(found[2] - pose[2], 2 * math.pi) == pytest.approx(0.0, abs=1e-6)


def test_along_a_path_at_the_commanded_speed_and_no_farther_than_its_end():
    path = np.array([[-1.0, 0.0], [0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    motion = plan_motion((1.0, 0.0, 0.0), path, 3.0, P)
    assert motion.on_path
    found = motion.at(np.array([0.5, 1.5, 2.0, 3.0]))
    assert found[:, :2] == pytest.approx(np.array([[0.5, 0], [1, 0.5], [1, 1], [1, 1]]), abs=0.08)
    assert found[-1, 2] == pytest.approx(math.pi / 2)


def test_a_path_with_yaw_keeps_it_and_one_behind_is_driven_backwards():
    sideways = np.array([[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
    found = plan_motion((0.0, 1.0, 0.0), sideways, 2.0, P)
    assert found.on_path and not found.poses[:, 2].any()
    behind = np.array([[0.0, 0.0], [-2.0, 0.0]])
    found = plan_motion((-1.0, 0.0, 0.0), behind, 2.0, P)
    assert found.on_path and np.cos(found.poses[:, 2]) == pytest.approx(1.0)


@pytest.mark.parametrize("aside", [1.0, -1.0])
def test_who_drives_sideways_along_a_path_goes_on_sideways(aside):
    angle = np.linspace(0.0, math.pi / 2, 20)
    curve = np.stack([np.cos(angle) - 1.0, aside * np.sin(angle)], axis=1)
    motion = plan_motion((0.0, aside, 0.0), curve, 3.0, P)
    assert motion.on_path
    assert motion.poses[0, 2] == pytest.approx(0.0, abs=0.05)
    assert motion.poses[-1, 2] == pytest.approx(aside * math.pi / 2, abs=0.05)


@pytest.mark.parametrize(
    "command, path",
    [
        ((1.0, 0.0, 0.0), [[0.0, 0.8], [3.0, 0.8]]),  # left by more than path_tolerance
        ((-1.0, 0.0, 0.0), [[0.0, 0.0], [3.0, 0.0]]),  # backs off
        ((0.0, 0.0, 1.0), [[0.0, 0.0], [3.0, 0.0]]),  # turns on the spot
        ((1.0, 0.0, 0.0), [[-3.0, 0.0], [0.0, 0.0]]),  # has arrived
        ((1.0, 0.0, 0.0), [[0.0, 0.0]]),
        ((1.0, 0.0, 0.0), [[math.nan, 0.0], [math.nan, 1.0]]),
    ],
)
def test_a_path_that_is_not_followed_does_not_count(command, path):
    motion = plan_motion(command, np.array(path), 3.0, P)
    assert not motion.on_path
    assert motion.at(U) == pytest.approx(plan_motion(command, None, 3.0, P).at(U), abs=1e-3)


def test_somebody_beside_a_curve_does_not_brake():
    """Straight on the robot would run into him; its path turns off before."""
    angle = np.linspace(0.0, math.pi / 2, 20)
    curve = 1.2 * np.stack([np.sin(angle), 1.0 - np.cos(angle)], axis=1)
    path = np.concatenate([curve, curve[-1:] + [[0.0, 3.0]]])
    him = people((2.0, 0.0, 0.0, 0.0))
    assert assess(him).scale < 1.0
    found = assess(him, path=path)
    assert (found.scale, found.on_path) == (1.0, True)
    assert math.isinf(found.time_to_collision)


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_courses_begin_at_the_present_speed_and_end_at_the_scale(scale, now):
    motion = plan_motion((1.0, 0.0, 0.0), None, 3.0, P)
    times = np.arange(0.0, 6.0, 0.01)
    courses = Courses(motion, now, times, P)
    on = np.gradient(courses.go_on(np.array([scale]))[0], times)
    assert on[1] == pytest.approx(now, abs=0.02)
    assert on[-2] == pytest.approx(scale, abs=1e-3)
    stop = courses.stop(np.array([scale]))[0]
    way = scale * P.reaction_time + scale**2 / (2.0 * P.deceleration)
    assert stop[-1] == pytest.approx(way)
    assert courses.stands(np.array([scale]))[0] == pytest.approx(0.3 + scale / P.deceleration)
