from __future__ import annotations

import heapq
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from safe_passage.costmap.costs import LETHAL_OBSTACLE, NO_INFORMATION
from safe_passage.costmap.grid import Box, RollingGrid
from safe_passage.costmap.inflation_layer import InflationLayer, inflation_costs
from safe_passage.costmap.parameters import InflationLayerParameters

ALL = (0, 40, 0, 40)


def inflate(lethal, radius=0.5, factor=3.0, inscribed=0.2, default=0, **options):
    master = RollingGrid((40, 40), 0.05, (0.0, 0.0), default)
    for row, column in lethal:
        master.cells[row, column] = LETHAL_OBSTACLE
    parameters = InflationLayerParameters(
        inflation_radius=radius, cost_scaling_factor=factor, **options
    )
    InflationLayer(parameters, 0.05, inscribed).inflate(master, ALL)
    return master.cells


def test_costs_by_hand():
    cells = inflate([(20, 20)])
    assert cells[20, 20] == 254
    assert cells[20, 24] == 253  # 0.20 m, just the inscribed radius
    assert cells[20, 25] == 216  # 0.25 m: 252 exp(-3 * 0.05) = 216.9
    assert cells[23, 24] == 216  # 3, 4 cells: 0.25 m too
    assert cells[20, 30] == 102  # 0.50 m: 252 exp(-3 * 0.3) = 102.5
    assert cells[20, 31] == 0  # beyond the inflation radius


def test_radius_is_rounded_up_to_cells():
    assert inflate([(20, 20)], radius=0.21, inscribed=0.0)[20, 25] > 0


def test_costs_of_a_steep_decay_reach_zero():
    assert inflation_costs(InflationLayerParameters(cost_scaling_factor=100.0), 0.05, 0.1)[100] == 0


def test_robot_wider_than_the_inflation_radius_is_inscribed_only():
    cells = inflate([(20, 20)], radius=0.1, inscribed=0.46)
    assert cells[20, 18:23].tolist() == [253, 253, 254, 253, 253]
    assert cells[20, 23] == 0


def test_unknown_takes_inscribed_costs_only():
    cells = inflate([(20, 20)], default=NO_INFORMATION)
    assert cells[20, 24] == 253
    assert cells[20, 25] == NO_INFORMATION


def test_unknown_takes_all_costs_where_told_so():
    cells = inflate([(20, 20)], default=NO_INFORMATION, inflate_unknown=True)
    assert cells[20, 25] == 216
    assert cells[20, 31] == NO_INFORMATION


def test_obstacles_beside_the_box_reach_into_it():
    master = RollingGrid((40, 40), 0.05, (0.0, 0.0), 0)
    master.cells[20, 5] = LETHAL_OBSTACLE
    layer = InflationLayer(InflationLayerParameters(inflation_radius=0.2), 0.05, 0.1)
    layer.inflate(master, (8, 40, 0, 40))
    assert master.cells[20, 9] > 0
    master.cells[:, 6:] = 0
    layer.inflate(master, (12, 40, 0, 40))
    assert not master.cells[:, 6:].any()


def test_area_holds_this_and_the_last_touch():
    layer = InflationLayer(InflationLayerParameters(inflation_radius=0.5), 0.05, 0.1)
    assert layer.grow(Box(0, 0, 1, 1)) == Box.everywhere()
    assert layer.grow(Box(2, 2, 3, 3)) == Box(-0.5, -0.5, 3.5, 3.5)
    assert layer.grow(Box(2, 2, 3, 3)) == Box(1.5, 1.5, 3.5, 3.5)


places = st.lists(st.tuples(st.integers(0, 39), st.integers(0, 39)), min_size=1, max_size=12)


@given(places)
def test_costs_never_rise_with_distance(lethal):
    cells = inflate(lethal).astype(int).ravel()
    rows, columns = np.mgrid[:40, :40]
    squared = np.min([(rows - r) ** 2 + (columns - c) ** 2 for r, c in lethal], axis=0).ravel()
    ordered = cells[np.argsort(squared, kind="stable")]
    assert (np.diff(ordered) <= 0).all()


def spread_from_cell_to_neighbour(lethal, costs, radius):
    """costmap_2d's way: each cell takes the source of the neighbour that reached it first."""
    found = np.zeros((40, 40), dtype=np.uint8)
    seen = np.zeros((40, 40), dtype=bool)
    queue = [(0, i, r, c, r, c) for i, (r, c) in enumerate(sorted(set(lethal)))]
    order = len(queue)
    while queue:
        squared, _, row, column, from_row, from_column = heapq.heappop(queue)
        if seen[row, column]:
            continue
        seen[row, column] = True
        found[row, column] = costs[squared]
        for r, c in ((row, column - 1), (row - 1, column), (row, column + 1), (row + 1, column)):
            away = (r - from_row) ** 2 + (c - from_column) ** 2
            if 0 <= r < 40 and 0 <= c < 40 and not seen[r, c] and away <= radius**2:
                heapq.heappush(queue, (away, order, r, c, from_row, from_column))
                order += 1
    return found


@settings(max_examples=30, deadline=None)
@given(places)
def test_is_never_below_costmap_2d_and_rarely_above(lethal):
    parameters = InflationLayerParameters(inflation_radius=0.5, cost_scaling_factor=3.0)
    costs = inflation_costs(parameters, 0.05, 0.2)
    theirs = spread_from_cell_to_neighbour(lethal, costs, math.isqrt(len(costs) - 2))
    ours = inflate(lethal)
    assert (ours >= theirs).all()
    assert (ours != theirs).mean() <= 0.002


@pytest.mark.parametrize("radius", [0.0, 0.5])
def test_nothing_lethal_changes_nothing(radius):
    assert not inflate([], radius=radius).any()
