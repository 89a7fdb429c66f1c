from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from safe_passage.monitoring.aggregation import Points
from safe_passage.monitoring.clustering import cluster
from safe_passage.monitoring.fusion_grid import Fusion
from scipy import ndimage


def points(xyz, sensor=None, age=None) -> Points:
    xyz = np.array(xyz, np.float32).reshape(-1, 3)
    sensor = np.zeros(len(xyz), int) if sensor is None else np.array(sensor)
    age = np.zeros(len(xyz)) if age is None else np.array(age)
    return Points(xyz, age > 0.25, sensor, age, age < 0.15)


def clustered(grid, min_points: int = 1, body: float = 1.0, walkers=()):
    return cluster(grid, min_points, body, 1.3 * body, np.array(walkers, float).reshape(-1, 2))


def fusion(sensors=(False, True)) -> Fusion:
    return Fusion(2.0, 0.1, np.array(sensors))


def test_a_cell_knows_its_points():
    grid = fusion().fuse(
        points(
            [(0.02, 0.03, 0.5), (0.04, 0.05, 0.9), (0.06, 0.07, 0.1), (1.05, -1.05, 0.0)],
            sensor=[1, 1, 0, 0],
            age=[0.0, 0.1, 0.2, 0.3],
        )
    )
    assert len(grid.cell) == 2
    far, near = 0, 1  # row by row from the lower left
    assert grid.counts.tolist() == [[1, 0], [1, 2]]
    assert grid.position[near] == pytest.approx([0.04, 0.05])
    assert grid.position[far] == pytest.approx([1.05, -1.05])
    assert grid.height[near] == pytest.approx([0.5, 0.9])  # the 2D sensor tells none
    assert np.isnan(grid.height[far]).all()
    assert grid.age == pytest.approx([0.3, 0.1])
    assert grid.density == pytest.approx([100.0, 300.0])
    assert grid.fresh[near] == pytest.approx([0.03, 0.04, 0.05])  # of the first two
    assert np.isnan(grid.fresh[far]).all()
    assert grid.shadowed.tolist() == [True, False]


def test_what_is_at_the_border_may_go_on_beyond_it():
    grid = fusion().fuse(points([(1.95, 0, 0), (-1.85, 0, 0), (0, 1.75, 0), (0, 0, 0)]))
    shadowed = {round(float(x), 2): bool(s) for (x, _), s in zip(grid.position, grid.shadowed)}
    assert shadowed[1.95]
    assert shadowed[-1.85]
    assert not shadowed[0.0]


def test_what_is_beyond_the_border_is_left_out():
    grid = fusion().fuse(points([(2.01, 0, 0), (-2.01, 0, 0), (0, 5, 0), (np.nan, 0, 0)]))
    assert len(grid.cell) == 0
    assert grid.counts.shape == (0, 2)


def test_the_last_cycle_leaves_no_trace():
    fuse = fusion()
    fuse.fuse(points([(0.0, 0.0, 0.0), (1.0, 1.0, 0.0)]))
    grid = fuse.fuse(points([(0.5, 0.5, 0.0)]))
    assert (grid.label >= 0).sum() == 1
    assert grid.label[grid.cell].tolist() == [0]


@given(arrays(np.float32, (20, 3), elements=st.floats(-2.5, 2.5, width=32)))
def test_no_point_is_lost_and_none_counted_twice(xyz):
    grid = fusion().fuse(points(xyz))
    inside = ((xyz[:, :2] >= -2.0) & (xyz[:, :2] < 2.0)).all(axis=1)
    assert grid.counts.sum() == pytest.approx(inside.sum(), abs=0)
    assert (np.diff(grid.cell) > 0).all()


def test_diagonal_neighbours_are_one_cluster():
    grid = fusion().fuse(points([(0.05, 0.05, 0), (0.15, 0.15, 0), (0.35, 0.35, 0)]))
    assert clustered(grid).tolist() == [0, 0, 1]


def test_too_few_points_are_no_cluster():
    grid = fusion().fuse(points([(0.05, 0.05, 0), (1.05, 0.05, 0), (1.06, 0.05, 0)]))
    assert clustered(grid, 2).tolist() == [-1, 0]


def test_an_empty_grid_has_no_clusters():
    assert len(clustered(fusion().fuse(points([])))) == 0


@given(arrays(bool, (12, 12)))
def test_clusters_are_the_connected_components(cells):
    row, column = np.nonzero(cells)
    xyz = np.column_stack([(column + 0.5) * 0.1, (row + 0.5) * 0.1, np.zeros(len(row))])
    grid = fusion().fuse(points(xyz))
    found = clustered(grid)
    truth, count = ndimage.label(cells, np.ones((3, 3)))
    assert found.max(initial=-1) + 1 == count
    pairs = set(zip(found.tolist(), truth[row, column].tolist()))
    assert len(pairs) == count


WALL = [(0.05 + 0.1 * i, 0.05) for i in range(15)]
BESIDE = [(0.65 + 0.1 * i, 0.15 + 0.1 * j) for i in range(2) for j in range(2)]


def grid_where(new, xy, age=0.0):
    """Grid of points, those of `new` where nothing was before."""
    xyz = np.column_stack([np.array(xy), np.zeros(len(xy))])
    grid = fusion().fuse(points(xyz, age=np.full(len(xyz), age)))
    came = {int(i) for i in grid.cells_of(np.array(new).reshape(-1, 2))}
    return replace(grid, new=np.array([int(cell) in came for cell in grid.cell]))


def labels_of(grid, found, xy) -> list:
    return found[np.searchsorted(grid.cell, grid.cells_of(np.array(xy)))].tolist()


def test_who_comes_to_a_wall_is_not_the_wall():
    grid = grid_where(BESIDE, WALL + BESIDE)
    found = clustered(grid)
    (wall,) = set(labels_of(grid, found, WALL))
    (walker,) = set(labels_of(grid, found, BESIDE))
    assert wall != walker


def test_a_cell_or_two_beside_a_wall_are_noise():
    assert set(clustered(grid_where(BESIDE[:2], WALL + BESIDE)).tolist()) == {0}


def test_what_is_no_larger_than_a_body_is_not_taken_apart():
    grid = grid_where(BESIDE, WALL[4:9] + BESIDE)
    assert set(clustered(grid).tolist()) == {0}


LEGS = [(0.05, 0.05), (0.15, 0.05)], [(0.35, 0.05), (0.45, 0.05)]


def test_two_legs_that_come_are_one():
    left, right = LEGS
    assert len(set(clustered(grid_where(left + right, left + right)).tolist())) == 1
    assert len(set(clustered(grid_where([], left + right)).tolist())) == 2  # chairs stand


def test_two_who_are_known_stay_two():
    left, right = LEGS
    grid = grid_where(left + right, left + right)
    assert len(set(clustered(grid, walkers=[(0.1, 0.05), (0.4, 0.05)]).tolist())) == 2
    assert len(set(clustered(grid, walkers=[(0.1, 0.05), (9.0, 0.0)]).tolist())) == 1


def test_a_crowd_that_comes_is_not_one():
    crowd = [(0.05 + 0.3 * i, 0.05) for i in range(6)]
    assert len(set(clustered(grid_where(crowd, crowd)).tolist())) == 6


def test_who_has_come_and_gone_is_no_cluster():
    left, _ = LEGS
    assert clustered(grid_where(left, left, age=0.3)).tolist() == [-1, -1]
    assert clustered(grid_where([], left, age=0.3)).tolist() == [0, 0]  # it may be hidden
