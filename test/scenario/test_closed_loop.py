"""The whole system in one run: a robot goes past a standing person to a pallet (paper, fig. 9)."""

from __future__ import annotations

from pathlib import Path

import pytest
from safe_passage.core.geometry import compose
from safe_passage.evaluation.closed_loop import run_scenario
from safe_passage.evaluation.closed_loop_table import HOLD_TIME, way_exists
from safe_passage.evaluation.oracle import KEEP
from safe_passage.evaluation.scenarios import GAP, PALLET_LENGTH, Scenario
from safe_passage.evaluation.setting import Setting
from safe_passage.navigation import NavigatorParameters
from safe_passage.simulation.worlds import PersonPlan

SETTING = Setting.of(Path(__file__).resolve().parents[2] / "config")
START = (-7.8, -2.05, 0.0)  # at the aisle's end, looking along it
PERSON = PersonPlan("vest_woman", ((-1.0, -1.1),), yaw=2.0)  # half a metre before the rack
FRONT = 0.36  # [m] of the robot


def run(method):
    world, robot = SETTING.load()
    navigator = NavigatorParameters()
    pallet = next(p for p in world.pallets if p[0] > 1.0 and -4.5 < p[1] < -3.5)
    goal = compose(pallet, (-0.5 * PALLET_LENGTH - GAP - FRONT, 0.0, 0.0))
    scenario = Scenario("standing", START, goal, pallet, (PERSON,))
    assert way_exists(world, robot, navigator, scenario)
    costmap = SETTING.load_costmap()
    return run_scenario(
        world, robot, scenario, method, costmap, navigator, HOLD_TIME, 1, detect_every=2
    )


@pytest.fixture(scope="module")
def without():
    return run("none")


@pytest.fixture(scope="module")
def found():
    return run("yolo")


def test_without_safety_areas_it_passes_near_the_person(without):
    """Else what the areas do could not be seen."""
    assert without.reached
    assert without.min_distance < KEEP


def test_the_person_keeps_its_distance(found):
    assert found.min_distance >= KEEP


def test_the_robot_stops_before_the_pallet(found):
    assert found.reached
    assert 0.0 < found.pallet_gap <= 0.15
    assert found.bumps == 0


def test_the_person_is_seen_and_nobody_else(found):
    in_view = found.column("visible") > 0.65
    assert in_view.sum() > 20
    assert found.column("seen")[in_view].mean() > 0.8
    assert (found.column("false") > 0).mean() < 0.05


def test_safety_costs_little_time(without, found):
    assert found.seconds < without.seconds + 20.0
