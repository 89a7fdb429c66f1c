"""Where a way exists and where none does, in halls that one can reckon by hand."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.core.grid import GridMap
from safe_passage.evaluation.oracle import STEP, earliest_arrival

SPEED = 0.8


def hall(width=8.0, length=10.0, resolution=0.05):
    """An empty hall: x from 0 to `length`, y from 0 to `width`, a wall of one cell around."""
    occupied = np.ones((round(width / resolution) + 2, round(length / resolution) + 2), bool)
    occupied[1:-1, 1:-1] = False
    return GridMap(occupied, (-resolution, -resolution), resolution)


def standing(x, y):
    return lambda time: (x, y)


def arrival(static, people, start=(1.0, 4.0), goal=(9.0, 4.0), within=60.0, **more):
    return earliest_arrival(static, start, goal, people, SPEED, within, **more)


def test_an_open_hall_takes_the_way_over_the_speed():
    assert arrival(hall(), []) == pytest.approx(8.0 / SPEED, abs=STEP)


def test_diagonals_take_an_eighth_longer_at_most():
    way = math.hypot(7.0, 6.0)
    found = arrival(hall(), [], start=(1.0, 1.0), goal=(8.0, 7.0))
    assert way / SPEED - STEP <= found <= way / 0.875 / SPEED + STEP


def test_too_late_is_never():
    assert arrival(hall(), [], within=9.0) == math.inf


def test_walls_are_not_crossed():
    static = hall()
    static.occupied[:, 100] = True
    assert arrival(static, []) == math.inf


@pytest.mark.parametrize(("width", "passes"), [(0.70, False), (0.90, True)])
def test_a_door_is_as_wide_as_the_disc(width, passes):
    static = hall()
    static.occupied[:, 100] = True
    door = round(0.5 * width / 0.05)
    static.occupied[81 - door : 81 + door, 100] = False
    assert (arrival(static, []) < math.inf) is passes


# A person in the middle of an aisle of width w leaves w / 2 to each side; needed are 1.2 m and the
# disc's diameter, 1.92 m.
@pytest.mark.parametrize(("width", "passes"), [(3.0, False), (3.7, False), (4.0, True)])
def test_a_person_blocks_an_aisle_or_not(width, passes):
    middle = 0.5 * width
    found = arrival(hall(width), [standing(5.0, middle)], start=(1.0, middle), goal=(9.0, middle))
    assert (found < math.inf) is passes


def test_beside_the_rack_a_person_leaves_room_in_an_aisle_of_3_m():
    people = [standing(5.0, 0.35)]
    assert arrival(hall(3.0), people, start=(1.0, 1.5), goal=(9.0, 1.5)) < math.inf


def test_a_person_who_walks_over_the_start_is_fled_from():
    """At 1 m/s along the aisle: the robot steps aside in a wide hall, not in a narrow one."""

    def walks(y):
        return lambda time: (max(12.0 - 1.0 * time, -5.0), y)

    wide = arrival(hall(8.0, 20.0), [walks(4.0)], start=(5.0, 4.0), goal=(19.0, 4.0))
    assert 14.0 / SPEED < wide < 14.0 / SPEED + 5.0
    narrow = arrival(hall(3.0, 20.0), [walks(1.5)], start=(5.0, 1.5), goal=(19.0, 1.5))
    assert narrow == math.inf


def test_it_waits_until_a_person_has_left():
    """The aisle is blocked for 20 s; then the person is gone."""
    people = [lambda time: (5.0, 1.5) if time < 20.0 else (5.0, 50.0)]
    found = arrival(hall(3.0), people, start=(1.0, 1.5), goal=(9.0, 1.5))
    reached_by_then = 5.0 - 1.56  # as near as it may wait
    assert found == pytest.approx(20.0 + (9.0 - reached_by_then) / SPEED, abs=2 * STEP)


def test_a_person_at_the_start_leaves_no_way():
    assert arrival(hall(), [standing(1.0, 5.5)]) == math.inf  # 1.14 m from the disc's edge
    assert arrival(hall(), [standing(1.0, 5.6)]) < math.inf


def test_a_fast_walker_is_not_jumped_over():
    """Between two steps a person of 3 m/s walks 0.75 m; its circle is 3.1 m wide."""
    people = [lambda time: (5.0, -1.0 + 3.0 * (time % 3.3))]
    alone = arrival(hall(), [])
    assert arrival(hall(), people) >= alone


def test_outside_of_the_map_there_is_no_way():
    assert arrival(hall(), [], goal=(30.0, 4.0)) == math.inf


@given(
    st.floats(1.0, 9.0), st.floats(0.5, 7.5), st.floats(0.3, 1.2), st.sampled_from([0.9, 1.2, 1.5])
)
def test_more_distance_never_helps(x, y, speed, keep):
    static = hall(resolution=0.1)
    times = [
        earliest_arrival(static, (1.0, 4.0), (9.0, 4.0), [standing(x, y)], speed, 60.0, k)
        for k in (keep, keep + 0.2)
    ]
    assert times[0] <= times[1]
