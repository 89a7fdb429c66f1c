from __future__ import annotations

import math

import numpy as np
import pytest
from safe_passage.costmap.footprint import (
    fill_polygon,
    footprint_polygon,
    inscribed_radius,
    place_polygon,
)
from safe_passage.costmap.grid import RollingGrid
from safe_passage.costmap.parameters import FootprintParameters

RECTANGLE = FootprintParameters(
    footprint=((0.36, 0.31), (0.36, -0.31), (-0.36, -0.31), (-0.36, 0.31)), footprint_padding=0.0
)


def test_padding_moves_coordinates_away_from_zero():
    padded = FootprintParameters(
        footprint=((0.5, 0.0), (0.0, 0.25), (-0.5, -0.25)), footprint_padding=0.125
    )
    assert footprint_polygon(padded).tolist() == [[0.625, 0.0], [0.0, 0.375], [-0.625, -0.375]]


def test_circle_has_sixteen_vertices():
    circle = footprint_polygon(FootprintParameters(robot_radius=0.5, footprint_padding=0.0))
    assert circle.shape == (16, 2)
    assert inscribed_radius(circle) == pytest.approx(0.5 * math.cos(math.pi / 16))


def test_inscribed_radius_of_a_rectangle():
    assert inscribed_radius(footprint_polygon(RECTANGLE)) == pytest.approx(0.31, abs=1e-6)


def test_cell_exactly_at_the_inscribed_radius_counts_as_in_costmap_2d():
    square = ((0.3, 0.3), (0.3, -0.3), (-0.3, -0.3), (-0.3, 0.3))
    radius = inscribed_radius(footprint_polygon(FootprintParameters(square, 0.0, 0.0)))
    assert radius >= 6 * 0.05  # 6 * 0.05 is 0.30000000000000004


def test_placed_at_a_quarter_turn():
    placed = place_polygon(np.array([[1.0, 0.0]]), (2.0, 3.0, math.pi / 2))
    assert placed[0] == pytest.approx([2.0, 4.0])


def test_fills_a_rectangle_with_its_outline():
    grid = RollingGrid((10, 10), 0.1, (0.0, 0.0), default=9)
    assert fill_polygon(grid, np.array([[0.25, 0.35], [0.55, 0.35], [0.55, 0.65], [0.25, 0.65]]), 0)
    expected = np.full((10, 10), 9)
    expected[3:7, 2:6] = 0
    assert grid.cells.tolist() == expected.tolist()


def test_fills_a_turned_square_by_columns():
    grid = RollingGrid((7, 7), 1.0, (0.0, 0.0), default=9)
    fill_polygon(grid, np.array([[3.5, 0.5], [6.5, 3.5], [3.5, 6.5], [0.5, 3.5]]), 0)
    assert [(row == 0).sum() for row in grid.cells] == [1, 3, 5, 7, 5, 3, 1]


def test_sets_nothing_when_a_vertex_is_outside():
    grid = RollingGrid((10, 10), 0.1, (0.0, 0.0), default=9)
    assert not fill_polygon(grid, np.array([[0.2, 0.2], [1.2, 0.2], [0.2, 0.8]]), 0)
    assert (grid.cells == 9).all()


def test_robot_within_one_cell():
    grid = RollingGrid((10, 10), 0.1, (0.0, 0.0), default=9)
    fill_polygon(grid, np.array([[0.51, 0.51], [0.52, 0.51], [0.52, 0.52]]), 0)
    assert np.argwhere(grid.cells == 0).tolist() == [[5, 5]]
