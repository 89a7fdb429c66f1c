"""Poses and outlines in the plane."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.core.geometry import compose, inverse, matrix, outline, placed, rotation

metres = st.floats(-50.0, 50.0)
pose = st.tuples(metres, metres, st.floats(-10.0, 10.0))


def same(a, b) -> bool:
    turned = math.remainder(a[2] - b[2], 2 * math.pi)
    return np.allclose(a[:2], b[:2], atol=1e-8) and abs(turned) < 1e-9


def test_compose_by_hand():
    assert compose((1.0, 2.0, math.pi / 2), (3.0, 1.0, 0.5)) == pytest.approx(
        (0.0, 5.0, math.pi / 2 + 0.5)
    )


@given(pose, pose, pose)
def test_composing_is_associative_and_inverse_undoes_it(a, b, c):
    assert same(compose(compose(a, b), c), compose(a, compose(b, c)))
    assert same(compose(a, inverse(a)), (0.0, 0.0, 0.0))
    assert same(compose(inverse(a), compose(a, b)), b)
    assert -math.pi <= compose(a, b)[2] <= math.pi


@given(pose, pose)
def test_poses_are_their_matrices(a, b):
    assert matrix(compose(a, b)) == pytest.approx(matrix(a) @ matrix(b), abs=1e-8)
    assert matrix(a)[:2, :2] == pytest.approx(rotation(a[2]))


@given(st.lists(st.tuples(metres, metres), min_size=1, max_size=5), st.lists(pose, min_size=1))
def test_placed_points_are_those_of_the_matrix_for_many_poses_at_once(points, poses):
    body = np.array(points)
    by_matrix = [body @ rotation(p[2]).T + p[:2] for p in poses]
    assert placed(body, np.array(poses)) == pytest.approx(np.array(by_matrix), abs=1e-8)
    assert placed(body, poses[0]) == pytest.approx(by_matrix[0], abs=1e-8)
    grid = np.array(poses)[:, None].repeat(3, axis=1)
    assert placed(body, grid).shape == (len(poses), 3, len(body), 2)


polygon = st.lists(st.tuples(metres, metres), min_size=3, max_size=6, unique=True)


@given(polygon, st.floats(0.05, 5.0))
def test_an_outline_keeps_the_corners_and_leaves_no_gap(corners, spacing):
    shape = np.array(corners)
    points = outline(shape, spacing)
    gaps = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    assert gaps.max() <= spacing + 1e-9
    for corner in shape:
        assert np.hypot(*(points - corner).T).min() < 1e-9
    around = np.hypot(*(np.roll(shape, -1, axis=0) - shape).T).sum()
    assert gaps.sum() == pytest.approx(around)  # on the edges, once around
