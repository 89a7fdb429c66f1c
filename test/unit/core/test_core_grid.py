"""A grid that knows where it lies."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.core.grid import GridMap

ORIGIN, CELL = (-1.0, 2.0), 0.25


def grid_of(*cells: tuple[int, int], shape: tuple[int, int] = (8, 12)) -> GridMap:
    occupied = np.zeros(shape, bool)
    for cell in cells:
        occupied[cell] = True
    return GridMap(occupied, ORIGIN, CELL)


anywhere = st.floats(-100.0, 100.0) | st.just(np.inf) | st.just(-np.inf)


@given(st.lists(st.tuples(anywhere, anywhere), min_size=1, max_size=20))
def test_a_point_is_inside_exactly_when_its_cell_is(points):
    xy = np.array(points)
    rows, columns, inside = grid_of().cells(xy)
    expected = (xy >= ORIGIN) & (xy < (2.0, 4.0))
    assert inside.tolist() == expected.all(axis=1).tolist()
    assert ((rows >= 0) & (rows < 8) & (columns >= 0) & (columns < 12)).all()
    assert not rows[~inside].any() and not columns[~inside].any()


def test_a_point_that_is_not_a_number_is_outside():
    *_, inside = grid_of().cells(np.array([[np.nan, 3.0], [0.0, np.nan]]))
    assert not inside.any()


cells = st.tuples(st.integers(0, 7), st.integers(0, 11))


@given(st.lists(cells, unique=True, max_size=20))
def test_centres_are_in_their_cells(chosen):
    grid = grid_of(*chosen)
    rows, columns, inside = grid.cells(grid.centres())
    assert inside.all() and sorted(zip(rows, columns)) == sorted(chosen)
    assert np.array_equal(grid.with_cells_of(grid.centres()).occupied, grid.occupied)


def test_outside_is_what_one_says():
    grid = grid_of((0, 0))
    points = np.array([[-0.9, 2.1], [0.0, 3.0], [9.0, 9.0]])
    assert grid.at(points, outside=True).tolist() == [True, False, True]
    assert grid.at(points, outside=False).tolist() == [True, False, False]
    assert grid.at(points.reshape(3, 1, 2), outside=False).shape == (3, 1)


@given(st.lists(cells, unique=True, max_size=20), st.sampled_from([0.25, 0.3, 0.5, 0.6, 1.0, 5.0]))
def test_a_coarser_grid_holds_every_part_and_nothing_far(chosen, resolution):
    fine = grid_of(*chosen)
    coarse = fine.coarser(resolution)
    for corner in ((-0.49, -0.49), (0.49, -0.49), (-0.49, 0.49), (0.49, 0.49)):
        assert coarse.at(fine.centres() + np.array(corner) * CELL, outside=False).all()
    away = np.abs(coarse.centres()[:, None] - fine.centres()).max(axis=2, initial=0.0)
    if len(away):
        assert away.min(axis=1).max() <= 0.5 * (resolution + CELL) + 1e-6
    assert not coarse.occupied.any() or chosen


@given(st.lists(cells, unique=True, min_size=1, max_size=10))
def test_distances_are_those_to_the_nearest_occupied_middle(chosen):
    grid = grid_of(*chosen)
    rows, columns = np.mgrid[:8, :12]
    by_hand = np.min([np.hypot(rows - r, columns - c) for r, c in chosen], axis=0) * CELL
    assert grid.distances() == pytest.approx(by_hand, abs=1e-5)


def test_distances_are_large_where_nothing_is():
    assert grid_of().distances().min() > 12 * CELL
