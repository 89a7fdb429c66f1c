"""The way to the goal: around walls, around people if that is cheap, nowhere if there is none."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from nav_hall import hall, nothing
from safe_passage.navigation.global_planner import CELL, UNREACHABLE, GlobalPlanner

RADIUS = 0.35
DOOR = [{"points": [[0, -4], [0, 1.4]]}, {"points": [[0, 2.6], [0, 4]]}]  # at y = 2
CLOSED = [{"points": [[0, -4], [0, 4]]}]


def plan(goal, seen=None, area_cost=12.0, **elements) -> GlobalPlanner:
    planner = GlobalPlanner(hall(**elements), RADIUS, area_cost)
    planner.plan(np.array(goal), nothing(0.0) if seen is None else seen)
    return planner


def length(way: np.ndarray) -> float:
    return float(np.hypot(*np.diff(way, axis=0).T).sum())


def test_in_the_open_the_way_is_straight():
    way = plan((3.0, 1.0)).way((-3.0, 1.0))
    assert length(way) == pytest.approx(6.0, abs=0.2)
    assert way[0] == pytest.approx([-3.0, 1.0], abs=CELL)
    assert way[-1] == pytest.approx([3.0, 1.0], abs=CELL)


def test_it_goes_around_a_wall_through_its_door():
    planner = plan((3.0, -2.0), walls=DOOR)
    way = planner.way((-3.0, -2.0))
    through = way[np.argmin(np.abs(way[:, 0]))]
    assert through[1] == pytest.approx(2.0, abs=0.3)
    clearance = planner.static.distances()[planner.static.cells(way)[:2]]
    assert clearance.min() > RADIUS
    assert length(way) == pytest.approx(10.5, abs=0.7)


def test_a_gap_narrower_than_the_robot_is_no_door():
    gap = [{"points": [[0, -4], [0, -2.25]]}, {"points": [[0, -1.75], [0, 1.4]]}, DOOR[1]]
    way = plan((3.0, -2.0), walls=gap).way((-3.0, -2.0))
    assert way[np.argmin(np.abs(way[:, 0])), 1] == pytest.approx(2.0, abs=0.3)


@given(st.floats(-4.5, 4.5), st.floats(-3.5, 3.5))
def test_downhill_every_cell_is_nearer_to_the_goal(x, y):
    planner = PLANNER
    way = planner.way((x, y))
    costs = planner.cost(way)
    assert (np.diff(costs) < 0.0).all()
    if len(way):
        assert way[-1] == pytest.approx([3.0, -2.0], abs=CELL)


PLANNER = plan((3.0, -2.0), walls=DOOR)


def test_without_a_way_there_is_none():
    planner = plan((3.0, 0.0), walls=CLOSED)
    assert planner.way((-3.0, 0.0)).shape == (0, 2)
    assert planner.cost(np.array([[-3.0, 0.0]])) == UNREACHABLE
    assert len(planner.way((3.0, 2.0))) > 10


@pytest.mark.parametrize("goal", [(0.0, 0.0), (9.0, 0.0)], ids=["in a wall", "outside"])
def test_a_goal_that_cannot_be_is_unreachable(goal):
    planner = plan(goal, walls=CLOSED)
    assert planner.cost(np.array([[-3.0, 0.0]])) == UNREACHABLE
    assert planner.way((-3.0, 0.0)).shape == (0, 2)


def test_a_start_outside_the_map_has_no_way():
    assert plan((3.0, 0.0)).way((20.0, 0.0)).shape == (0, 2)


def row_of_people(low: float, high: float) -> np.ndarray:
    y = np.arange(low, high, 0.05)
    return np.stack([np.zeros_like(y), y], axis=1)


def test_people_are_gone_around_when_that_is_cheaper():
    way = plan((3.0, 0.0), row_of_people(-1.0, 1.0)).way((-3.0, 0.0))
    assert abs(way[np.argmin(np.abs(way[:, 0])), 1]) > 1.0 + RADIUS - CELL


def test_people_all_across_are_dear_and_not_impassable():
    free = plan((3.0, 0.0)).cost(np.array([[-3.0, 0.0]]))[0]
    barred = plan((3.0, 0.0), row_of_people(-4.0, 4.0)).cost(np.array([[-3.0, 0.0]]))[0]
    dearer = plan((3.0, 0.0), row_of_people(-4.0, 4.0), area_cost=24.0)
    assert len(dearer.way((-3.0, 0.0))) > 50
    more = dearer.cost(np.array([[-3.0, 0.0]]))[0] - barred
    assert barred - free > 12.0 * 2 * RADIUS * 0.8
    assert more == pytest.approx(12.0 * 2 * RADIUS, rel=0.3)


def test_from_a_place_too_near_a_wall_it_leads_out():
    way = plan((3.0, 0.0)).way((-4.9, 0.0))
    assert len(way) and way[0, 0] < -4.8 and way[-1] == pytest.approx([3.0, 0.0], abs=CELL)
