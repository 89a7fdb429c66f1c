"""The map of a world holds what a robot can touch, and nothing else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.simulation.static_map import FLAT, make_map
from safe_passage.simulation.worlds import load_world
from sim_hall import make_hall

WORLDS = Path(__file__).resolve().parents[3] / "config/worlds"


@given(
    st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-3.2, 3.2), st.floats(0.06, 2.0),
    st.floats(0.06, 2.0),
)  # fmt: skip
def test_a_block_is_mapped_where_it_stands_and_no_farther(x, y, yaw, length, width):
    block = {"x": x, "y": y, "yaw": yaw, "size": [length, width, 0.5]}
    world = make_hall(boxes=[block])
    grid = make_map(world, 1.2)
    corners = world.blocks[0].corners(inset=0.003)
    middle = np.array([x, y])
    assert grid.at(corners, outside=False).all() and grid.at(middle, outside=False)
    c, s = np.cos(yaw), np.sin(yaw)
    local = (grid.centres() - middle) @ np.array([[c, -s], [s, c]])
    inside_hall = (np.abs(grid.centres()) < (4.9, 3.9)).all(axis=1)
    beyond = np.abs(local[inside_hall]) - (0.5 * length, 0.5 * width)
    assert beyond.max() < 0.75 * grid.resolution  # half a cell's diagonal


@pytest.mark.parametrize("name", ["warehouse", "workshop", "crossing"])
def test_every_block_that_a_robot_reaches_is_in_the_map_of_each_world(name):
    world = load_world(WORLDS / f"{name}.yaml")
    grid = make_map(world, 1.7)
    half = 0.5 * np.array(world.size)
    for block in world.blocks:
        corners = block.corners(inset=0.003)
        inner = corners[(np.abs(corners) < half).all(axis=1)]
        if block.z < 1.7 and block.z + block.size[2] > FLAT:
            assert grid.at(inner, outside=True).all(), block


@pytest.mark.parametrize("name", ["warehouse", "workshop", "crossing"])
def test_robot_and_people_of_each_world_start_on_free_ground(name):
    world = load_world(WORLDS / f"{name}.yaml")
    grid = make_map(world, 1.7)
    clearance = grid.distances()
    row, column, inside = grid.cells(np.array(world.start[:2]))
    assert inside and clearance[row, column] > 0.72  # the omnirob's outer radius
    for person in world.people:
        points = np.array(person.waypoints)
        along = np.concatenate(
            [np.linspace(a, b, 50) for a, b in zip(points, points[1:])] or [points]
        )
        rows, columns, inside = grid.cells(along)
        assert inside.all() and clearance[rows, columns].min() > 0.2, person


def test_what_is_high_or_flat_is_not_in_the_way():
    shelf = {"x": 2.0, "y": 0.0, "z": 1.3}
    sill = {"x": -2.0, "y": 0.0, "size": [0.5, 0.5, 0.02]}
    grid = make_map(make_hall(boxes=[shelf, sill]), robot_height=1.2)
    assert not grid.at(np.array([[2.0, 0.0], [-2.0, 0.0]]), outside=True).any()
    assert make_map(make_hall(boxes=[shelf]), robot_height=1.4).at(np.array([2.0, 0.0]), False)


def test_all_around_the_hall_is_occupied_so_that_no_way_leads_outside():
    grid = make_map(make_hall(), 1.2)
    middles = (np.argwhere(~grid.occupied)[:, ::-1] + 0.5) * grid.resolution + grid.origin
    assert (np.abs(middles) < (5.0, 4.0)).all()


@pytest.mark.parametrize("x", [0.5, 2.05, -1.25])
def test_a_block_that_ends_with_a_cell_takes_no_other(x):
    grid = make_map(make_hall(boxes=[{"x": x, "y": x, "size": [0.5, 0.5, 1.0]}]), 1.2)
    inner = grid.centres()[(np.abs(grid.centres()) < 3.8).all(axis=1)]
    assert np.abs(inner - x).max() == pytest.approx(0.225)


def test_the_hall_is_free_to_its_walls_on_every_side():
    grid = make_map(make_hall(), 1.2)
    middles = (np.argwhere(~grid.occupied)[:, ::-1] + 0.5) * grid.resolution + grid.origin
    assert middles.min(axis=0) == pytest.approx([-4.975, -3.975])
    assert middles.max(axis=0) == pytest.approx([4.975, 3.975])
