"""The simulator is deterministic, stops at walls and starts anew."""

from __future__ import annotations

import math

import numpy as np
import pytest
from safe_passage.simulation.drive import Twist
from safe_passage.simulation.simulator import Simulator
from safe_passage.simulation.worlds import PersonPlan
from sim_hall import BOXES, make_cart, make_hall

PEOPLE = (PersonPlan(waypoints=((2.0, -1.0), (2.0, 1.0)), speed=1.0),)
ROBOT = make_cart()


def simulate(seed: int = 0, **values) -> Simulator:
    return Simulator(make_hall(boxes=BOXES), ROBOT, seed, PEOPLE, **values)


@pytest.fixture()
def sim():
    made = simulate()
    yield made
    made.close()


def drive(sim: Simulator, steps: int, look_every: int = 0) -> None:
    for i in range(steps):
        if i % 8 == 0:
            sim.command(Twist(0.4, 0.0, 0.3))
        sim.step()
        if look_every and i % look_every == 0:
            sim.frame(ROBOT.cameras[0])


def measured(sim: Simulator) -> list[np.ndarray]:
    scan, frame = sim.scan(ROBOT.lidars[0]), sim.frame(ROBOT.cameras[0])
    odometry = np.array(sim.base.odometry)
    return [scan.ranges, scan.persons, frame.depth, frame.bgr, odometry, np.array(sim.base.pose)]


def test_same_seed_and_commands_give_the_same_bits_whatever_was_asked_before(sim):
    drive(sim, 30)
    once = measured(sim)
    other = simulate()
    drive(other, 30, look_every=3)
    other.frame(ROBOT.cameras[0])  # asked in another order, and twice
    twice = measured(other)
    other.close()
    for a, b in zip(once, twice):
        assert np.array_equal(a, b, equal_nan=a.dtype.kind == "f")


def test_another_seed_gives_other_noise_on_the_same_truth(sim):
    other = simulate(seed=1)
    here, there = (one.scan(ROBOT.lidars[0]) for one in (sim, other))
    other.close()
    assert np.array_equal(here.exact, there.exact)
    assert not np.array_equal(here.ranges, there.ranges)


def test_noise_differs_from_step_to_step(sim):
    first = sim.scan(ROBOT.lidars[0])
    sim.step()
    again = sim.scan(ROBOT.lidars[0])
    still = (first.exact == again.exact) & np.isfinite(first.ranges) & np.isfinite(again.ranges)
    assert still.sum() > 300
    assert (first.ranges[still] != again.ranges[still]).mean() > 0.9


def test_restart_is_as_if_made_anew(sim):
    drive(sim, 30)
    before = measured(sim)
    sim.restart()
    assert sim.time == 0.0 and sim.base.pose == (0.0, 0.0, 0.0)
    drive(sim, 30)
    for a, b in zip(before, measured(sim)):
        assert np.array_equal(a, b, equal_nan=a.dtype.kind == "f")


def test_time_goes_by_steps(sim):
    for _ in range(7):
        sim.step()
    assert sim.time == pytest.approx(7 * Simulator.STEP)


def test_a_wall_stops_the_robot_and_lets_it_back_off():
    sim = Simulator(make_hall(), ROBOT, people=(), start=(4.0, 0.0, 0.0))
    bumped = False
    for _ in range(120):
        sim.command(Twist(0.8))
        sim.step()
        bumped |= sim.base.bumped
    front = sim.base.pose[0] + 0.3
    assert bumped and 4.9 < front <= 5.0
    for _ in range(40):
        sim.command(Twist(-0.5))
        sim.step()
    sim.close()
    assert not sim.base.bumped and sim.base.pose[0] < 4.6


def test_distance_to_people_is_from_the_outline(sim):
    middles = np.array([(state.x, state.y) for state in sim.people()])
    assert middles.tolist() == [[2.0, -1.0]]
    assert sim.distance_to_people() == pytest.approx(math.hypot(1.7, 0.75), abs=0.02)


def test_without_people_they_are_infinitely_far():
    sim = Simulator(make_hall(), ROBOT, people=())
    assert sim.distance_to_people() == math.inf and sim.people() == []
    assert (sim.scan(ROBOT.lidars[0]).persons == -1).all()
    sim.close()


def test_a_scan_tells_its_persons_and_the_exact_ranges(sim):
    scan = sim.scan(ROBOT.lidars[0])
    assert 3 <= (scan.persons == 0).sum() <= 40
    assert scan.exact[scan.persons == 0] == pytest.approx(math.hypot(2.0, 1.0), abs=0.35)
    met = np.isfinite(scan.ranges)
    assert np.abs(scan.ranges[met] - scan.exact[met]).max() < 6 * ROBOT.lidars[0].noise
