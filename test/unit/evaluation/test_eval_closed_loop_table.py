"""Fig. 9's figures from runs that one can reckon by hand."""

import math

import numpy as np
import pytest
from eval_worlds import SETTING
from safe_passage.evaluation.closed_loop import TRACK, RunResult
from safe_passage.evaluation.closed_loop_table import (
    CAUSES,
    Outcome,
    Task,
    as_markdown,
    as_values,
    draw_scenario,
    summaries,
    summarise,
    time_lost,
    way_exists,
    why_near,
)
from safe_passage.evaluation.scenarios import KINDS, Scenario
from safe_passage.navigation import NavigatorParameters, State
from safe_passage.simulation.worlds import PersonPlan


def run(distances, method="yolo", kind="standing", seconds=30.0, state=State.SUCCEEDED, **columns):
    """A run of one cycle a second; `columns`: of its track, else 0."""
    track = np.zeros((len(distances), len(TRACK)))
    track[:, TRACK.index("time")] = np.arange(len(distances))
    track[:, TRACK.index("distance")] = distances
    for name, values in columns.items():
        track[:, TRACK.index(name)] = values
    least = min(distances)
    return RunResult(kind, method, state, seconds, least, least + 0.1, 0.1, 0, track)


def outcome(number, distances, way=True, **more):
    return Outcome(number, run(distances, **more), way)


@pytest.mark.parametrize(
    ("least", "way", "violates", "moving"),
    [
        (1.21, True, False, False),
        (1.19, True, True, False),  # run() lets it be 0.1 m farther while it moves
        (1.05, True, True, True),
        (1.05, False, False, False),
    ],
)
def test_a_violation_is_nearer_than_a_way_that_existed(least, way, violates, moving):
    one = outcome(0, [3.0, least, 2.0], way)
    assert one.violates is violates
    assert one.violates_moving is moving
    assert bool(one.cause) is violates


@pytest.mark.parametrize(
    ("visible", "seen", "remembered", "cause"),
    [
        # all come after the robot was near
        ([0, 0, 0, 0, 1, 1], [0, 0, 0, 0, 1, 1], [0, 0, 0, 0, 1, 1], "not in view"),
        ([0, 1, 1, 1, 1, 1], [0, 0, 0, 0, 1, 1], [0, 0, 0, 0, 1, 1], "not detected"),
        ([0, 1, 1, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 1, 1, 0, 0, 0], "forgotten"),
        ([0, 1, 1, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 1, 1, 1, 1, 1], "known"),
    ],
)
def test_why_a_run_was_near(visible, seen, remembered, cause):
    distances = [4.0, 3.0, 2.0, 1.0, 0.9, 2.0]
    found = run(distances, visible=visible, seen=seen, remembered=remembered)
    assert why_near(found) == cause


def test_time_lost_is_paired():
    runs = [
        outcome(0, [2.0], method="none", seconds=20.0),
        outcome(1, [2.0], method="none", seconds=30.0),
        outcome(2, [2.0], method="none", seconds=10.0, state=State.ABORTED),
        outcome(0, [2.0], seconds=25.0),
        outcome(1, [2.0], seconds=29.0),
        outcome(2, [2.0], seconds=60.0),  # its twin did not arrive
        outcome(0, [2.0], kind="walking", seconds=99.0),
    ]
    assert time_lost(runs, "standing", "yolo") == [5.0, -1.0]
    assert time_lost(runs, "walking", "yolo") == []


def test_a_summary():
    runs = [
        outcome(0, [3.0, 1.5], seen=[1, 0]),
        outcome(1, [3.0, 1.17], seconds=40.0, false=[2, 0]),
        outcome(2, [3.0, 0.5], state=State.ABORTED),
        outcome(3, [3.0, 0.4], way=False),
    ]
    found = summarise(runs, "standing", "yolo")
    assert (found.runs, found.reached_share, found.ways_existed) == (4, 0.75, 3)
    assert (found.violations, found.violations_within_cell, found.violations_moving) == (2, 1, 1)
    assert found.min_distance == 0.4
    assert found.min_distance_median == pytest.approx((0.5 + 1.17) / 2)
    assert found.time_median == 30.0
    assert (found.seen_share, found.false_share) == (1 / 8, 1 / 8)
    assert math.isnan(found.time_lost_median)


def test_what_was_not_run_is_not_listed():
    runs = [outcome(0, [2.0], method="none"), outcome(0, [1.0])]
    found = summaries(runs)
    assert [(s.kind, s.method) for s in found] == [("standing", "none"), ("standing", "yolo")]
    markdown = as_markdown(found, runs)
    assert "| standing, no areas | standing, yolo |" in markdown.replace("|  |", "|")
    assert all(name in markdown for name in CAUSES)
    assert as_values(runs[1])["cause"] == "not in view"


def test_scenarios_are_drawn_by_number_alone():
    world, robot = SETTING.load()
    navigator = NavigatorParameters()

    def draw(kind, number, method="yolo", seed=8):
        return draw_scenario(world, robot, navigator, Task(SETTING, kind, number, method, seed))

    assert draw("walking", 3) == draw("walking", 3, method="none")
    assert len({draw(kind, number).start for kind in KINDS for number in range(3)}) == 6
    assert draw("walking", 3) != draw("walking", 3, seed=9)


def test_whether_a_way_exists_in_the_warehouse():
    """Through an aisle 3 m wide: past a person at the rack, not past one in its middle."""
    world, robot = SETTING.load()
    start, goal = (-7.5, -2.05, 0.0), (7.5, -2.05, 0.0)

    def exists(*people):
        scenario = Scenario("standing", start, goal, goal, people)
        return way_exists(world, robot, NavigatorParameters(), scenario)

    beside = PersonPlan("tall_man", ((0.0, -0.9),))
    blocks = [PersonPlan("tall_man", ((0.0, y),)) for y in (-2.05, 2.05)]
    walls = [PersonPlan("tall_man", ((0.0, y),)) for y in (-5.2, 5.2)]
    assert exists(beside)
    assert exists(blocks[0])  # round through the other aisle
    assert not exists(*blocks, *walls)
