"""Crossings and what is said of them, on runs whose truth is plain."""

import math
from dataclasses import replace

import numpy as np
import pytest
from safe_passage.evaluation.separation_crossings import SETTLE, STEP, Crossing, crossing
from safe_passage.evaluation.separation_crowd import crowd, cycle_times
from safe_passage.evaluation.separation_follow import make_round
from safe_passage.evaluation.separation_runs import Run, gaps, standing, undisturbed
from safe_passage.evaluation.separation_scores import (
    could_avoid,
    false_stops,
    touch_speed,
    verdict,
)
from safe_passage.separation import SeparationParameters
from safe_passage.simulation.drive import Twist
from safe_passage.simulation.worlds import PersonPlan

FOOTPRINT = ((0.6, 0.36), (-0.6, 0.36), (-0.6, -0.36), (0.6, -0.36))
P = SeparationParameters(footprint=FOOTPRINT)


def stands_at(x, y, speed=1.0, seconds=6.0):
    """The robot drives along x from the origin; somebody stands there."""
    plan = PersonPlan(waypoints=((x, y),))
    return Crossing(0, 1, (0.0, 0.0, 0.0), Twist(speed), plan, 4.0, seconds)


def driven(one, poses, seen=0, scale=1.0, danger=False):
    """A run along `poses` (S, 3)."""
    poses = np.asarray(poses, float)
    speed = np.diff(poses[:, 0], prepend=poses[0, 0]) / STEP
    twists = np.column_stack([speed, 0.0 * speed, 0.0 * speed])
    stamps = (np.arange(len(poses)) + 1) * STEP
    every = np.ones(len(poses))
    track = np.tile([0.1, 0.1, 1.0, 0.3, 7.0], (len(poses), 1))
    people = np.tile(one.person.waypoints[0], (len(poses), 1))
    return Run(one, poses, twists, people, seen, stamps, scale * every,
               np.logical_and(every, danger), 7.0 * every, track, every)  # fmt: skip


def along(*x):
    return np.column_stack([x, np.zeros(len(x)), np.zeros(len(x))])


@pytest.fixture(scope="module")
def some():
    return [crossing(number, 3, np.array(FOOTPRINT)) for number in range(25)]


def test_a_crossing_is_the_same_every_time(some):
    assert crossing(4, 3, np.array(FOOTPRINT)) == some[4]
    assert crossing(4, 5, np.array(FOOTPRINT)) != some[4]


def test_about_half_of_the_crossings_would_be_collisions(some):
    least = np.array([gaps(*undisturbed(one, one.seconds), P).min() for one in some])
    assert 0.2 < (least < 0.0).mean() < 0.8
    assert (least > 0.3).any()


def test_gaps_are_between_outline_and_body():
    poses = np.array([(0.0, 0.0, 0.0), (0.0, 0.0, math.pi / 2), (0.0, 0.0, 0.0)])
    people = np.array([(1.35, 0.0), (1.35, 0.0), (0.5, 0.0)])
    assert gaps(poses, people, P) == pytest.approx([0.5, 0.74, -0.35])


def test_the_speed_at_the_first_touch_counts():
    gap = np.array([0.2, 0.1, -0.1, -0.2])
    assert touch_speed(gap, np.array([1.0, 0.5, 0.0, 0.7])) == 0.0
    assert touch_speed(gap, np.array([1.0, 0.5, 0.3, 0.0])) == 0.3
    assert touch_speed(np.abs(gap), np.ones(4)) == 0.0


def test_who_drives_on_into_a_person_is_to_blame():
    one = stands_at(2.0, 0.0)
    result = verdict(driven(one, along(*np.arange(0.0, 1.3, STEP))), P)
    assert result.contact
    assert result.avoidable
    assert result.speed == pytest.approx(1.0)
    assert result.least < 0.0
    assert not result.bumped


def test_who_stands_when_somebody_walks_into_it_is_not():
    run = driven(stands_at(2.0, 0.0), along(*np.zeros(80)))
    run = replace(run, people=np.column_stack([np.linspace(2.0, 0.7, 80), np.zeros(80)]))
    result = verdict(run, P)
    assert (result.contact, result.bumped, result.speed) == (False, True, 0.0)


def test_what_nobody_could_avoid_is_no_contact():
    """Somebody appears a hand's breadth before a robot at full speed."""
    waits = np.zeros(round(SETTLE / STEP))
    poses = along(*waits, *np.arange(0.0, 1.3, STEP))
    seen = len(waits) + 52
    run = driven(stands_at(2.0, 0.0), poses, seen=seen)
    assert run.poses[seen, 0] + 0.85 == pytest.approx(1.9, abs=0.02)
    result = verdict(run, P)
    assert (result.contact, result.avoidable) == (False, False)
    assert could_avoid(replace(run, seen=10), P)
    assert not could_avoid(replace(run, seen=len(poses)), P)


def test_of_harmless_runs_the_stopped_ones_are_false_stops():
    far, near = stands_at(2.0, 2.0), stands_at(2.0, 0.5)
    poses = along(*np.zeros(200))
    verdicts = [
        verdict(driven(one, poses, scale=scale), P)
        for one, scale in ((far, 1.0), (far, 0.5), (far, 0.0), (near, 0.0))
    ]
    assert [one.stopped for one in verdicts] == [False, False, True, True]
    assert false_stops(verdicts, 0.3) == [verdicts[2]]
    assert false_stops(verdicts, 50.0) == []


def test_times_begin_and_end_with_the_danger():
    run = driven(stands_at(2.0, 2.0), along(*np.zeros(300)))
    danger, scale = np.zeros(300, bool), np.ones(300)
    danger[110:160], scale[115:200] = True, 0.0
    result = verdict(replace(run, danger=danger, scale=scale), P)
    assert result.reaction == pytest.approx(5 * STEP)
    assert result.resume == pytest.approx(41 * STEP)
    never = verdict(replace(run, danger=danger), P)
    assert math.isinf(never.reaction)


@pytest.mark.parametrize(
    ("column", "value", "why"),
    [
        (0, math.nan, "no track of its own"),
        (2, 0.0, "not called moving"),
        (1, 2.0, "velocity is wrong"),
        (1, 0.1, "well tracked"),
    ],
)
def test_a_contact_names_what_was_wrong_with_the_track(column, value, why):
    run = driven(stands_at(2.0, 0.0), along(*np.arange(0.0, 1.3, STEP)))
    track = run.track.copy()
    track[:, column] = value
    assert verdict(replace(run, track=track), P).why == why


def test_a_crowd_is_as_many_as_asked_for():
    obstacles = crowd(50, 0.1, np.random.default_rng(1))
    assert len(obstacles) == 50
    assert 0 < obstacles.moving.sum() < 20
    assert len(cycle_times(20, 1.0, 3, P, 1)) == 3
    still = standing(obstacles)
    assert not still.velocity.any()
    assert not still.covariance.any()


def test_rounds_begin_in_the_cameras_view():
    for number in range(6):
        x, y = make_round(number, 2).plan.waypoints[0]
        assert abs(math.atan2(y, x)) < 0.5
        assert 1.0 < math.hypot(x, y) < 5.0
