from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.costmap.grid import Box, RollingGrid

anything = st.floats(allow_nan=True, allow_infinity=True)
nearby = st.floats(-30, 30)


def numbered() -> RollingGrid:
    grid = RollingGrid((4, 6), 0.5, (0.0, 0.0), default=255)
    grid.cells[:] = np.arange(24).reshape(4, 6)
    return grid


def test_rolls_by_whole_cells_rounded_towards_zero():
    grid = numbered()
    # cell-centre half sizes 1.375 and 0.875 m: corner wanted at (0.625, -0.375) -> cells (1, 0)
    grid.roll_around(2.0, 0.5)
    assert (grid.origin_x, grid.origin_y) == (0.5, 0.0)
    assert grid.cells[0].tolist() == [1, 2, 3, 4, 5, 255]


def test_first_corner_of_an_eight_metre_window_is_that_of_costmap_2d():
    grid = RollingGrid((160, 160), 0.05, (0.0, 0.0), default=0)
    grid.roll_around(0.0, 0.0)
    assert grid.origin_x == pytest.approx(-3.95)


def test_forgets_everything_when_it_rolls_past_itself():
    grid = numbered()
    grid.roll_around(100.0, -100.0)
    assert (grid.cells == 255).all()


@given(x=nearby, y=nearby)
def test_rolling_keeps_overlapping_cells_at_their_place(x, y):
    before, after = numbered(), numbered()
    after.roll_around(x, y)
    shift = round((after.origin_x - before.origin_x) / 0.5), round(after.origin_y / 0.5)
    for row in range(4):
        for column in range(6):
            old_row, old_column = row + shift[1], column + shift[0]
            inside = 0 <= old_row < 4 and 0 <= old_column < 6
            expected = before.cells[old_row, old_column] if inside else 255
            assert after.cells[row, column] == expected


@given(points=st.lists(st.tuples(anything, anything), max_size=20))
def test_any_point_is_inside_exactly_when_its_cell_is(points):
    grid = RollingGrid((4, 6), 0.5, (-1.0, 2.0), default=0)
    x, y = np.array(points, dtype=np.float64).reshape(-1, 2).T
    columns, rows, inside = grid.columns_and_rows(x, y)
    assert ((columns >= 0) & (columns < 6) & (rows >= 0) & (rows < 4)).all()
    expected = (x >= -1.0) & (x < 2.0) & (y >= 2.0) & (y < 4.0)
    assert inside.tolist() == expected.tolist()


def test_box_of_cells_is_cut_to_the_window():
    grid = RollingGrid((4, 6), 0.5, (0.0, 0.0), default=0)
    assert grid.cell_box(Box(0.6, -5.0, 1.4, 0.9)) == (1, 3, 0, 2)
    assert grid.cell_box(Box.everywhere()) == (0, 6, 0, 4)


def test_empty_box_has_no_cells():
    first, end, *_ = RollingGrid((4, 6), 0.5, (0.0, 0.0), default=0).cell_box(Box())
    assert end < first


def test_boxes_join_and_grow():
    box = Box().touching(np.array([1.0, 2.0]), np.array([3.0, -1.0])).padded(0.5)
    assert (box.min_x, box.min_y, box.max_x, box.max_y) == (0.5, -1.5, 2.5, 3.5)
    assert Box().touching(np.array([]), np.array([])).min_x == math.inf


def test_cell_distance_rounds_up():
    grid = RollingGrid((1, 1), 0.1, (0.0, 0.0), default=0)
    assert [grid.cell_distance(d) for d in (0.0, 0.01, 0.1, 0.11)] == [0, 1, 1, 2]
