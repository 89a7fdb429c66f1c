"""What is remembered of the costmap: as long as nobody looks there again, and not for ever."""

import numpy as np
from safe_passage.core.grid import GridMap
from safe_passage.navigation.memory import KEEP, ObstacleMemory

HERE, BACK = (0.0, 0.0, 0.0), (0.0, 0.0, np.pi)
THERE = np.array([[2.05, 0.05]])
NOTHING = np.empty((0, 2))


def memory(wall=False):
    occupied = np.zeros((100, 100), bool)
    if wall:
        occupied[:, 60] = True  # x = 1.0 to 1.1 m
    return ObstacleMemory(GridMap(occupied, (-5.0, -5.0), 0.1))


def test_what_lies_behind_the_robot_is_remembered_for_a_while():
    kept = memory()
    assert np.allclose(kept.update(0.0, BACK, THERE), THERE)
    assert np.allclose(kept.update(KEEP - 1.0, BACK, NOTHING), THERE)
    assert not len(kept.update(KEEP + 1.0, BACK, NOTHING))


def test_what_the_robot_looks_at_is_as_the_costmap_has_it():
    kept = memory()
    kept.update(0.0, BACK, THERE)
    assert not len(kept.update(1.0, HERE, NOTHING))
    assert len(kept.update(2.0, HERE, THERE)) == 1


def test_a_wall_hides_what_is_behind_it():
    kept = memory(wall=True)
    kept.update(0.0, HERE, THERE)
    assert np.allclose(kept.update(1.0, HERE, NOTHING), THERE)


def test_a_clock_that_goes_back_forgets():
    kept = memory()
    kept.update(100.0, BACK, THERE)
    assert not len(kept.update(5.0, BACK, NOTHING))
