from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.costmap import project_scan, transform_points, yaw_quaternion


def test_beams_by_hand():
    points = project_scan(np.array([1.0, 2.0, 3.0]), -math.pi / 2, math.pi / 2, 0.1, 10.0)
    assert points == pytest.approx(np.array([[0, -1, 0], [2, 0, 0], [0, 3, 0]]), abs=1e-6)
    assert points.dtype == np.float32


def test_beams_that_mean_nothing_give_no_point():
    ranges = np.array([math.nan, math.inf, -math.inf, 0.0, 0.05, 10.0, 25.0, 9.9])
    assert len(project_scan(ranges, 0.0, 0.1, 0.1, 10.0)) == 1


def test_beam_without_return_lies_just_before_range_max():
    point = project_scan(np.array([math.inf]), 0.0, 0.1, 0.1, 10.0, inf_is_valid=True)[0]
    assert 9.999 < point[0] < 10.0
    assert not len(project_scan(np.array([math.nan]), 0.0, 0.1, 0.1, 10.0, inf_is_valid=True))


def test_scan_without_beams():
    assert project_scan(np.array([]), 0.0, 0.1, 0.1, 10.0).shape == (0, 3)


def test_moves_and_turns_points():
    moved = transform_points(
        np.array([[1.0, 0.0, 0.5]]), (10.0, 20.0, 1.0), yaw_quaternion(math.pi / 2)
    )
    assert moved[0] == pytest.approx([10.0, 21.0, 1.5], abs=1e-5)


@given(
    roll=st.floats(-3, 3),
    pitch=st.floats(-1.5, 1.5),
    yaw=st.floats(-3, 3),
    point=st.tuples(*[st.floats(-20, 20)] * 3),
)
def test_turning_in_space_agrees_with_scipy(roll, pitch, yaw, point):
    rotation = pytest.importorskip("scipy.spatial.transform").Rotation.from_euler(
        "xyz", [roll, pitch, yaw]
    )
    moved = transform_points(np.array([point]), (0.0, 0.0, 0.0), rotation.as_quat())
    assert moved[0] == pytest.approx(rotation.apply(point), abs=1e-4)


@given(st.lists(st.floats(width=32), max_size=30))
def test_any_scan_gives_finite_points_within_range(ranges):
    points = project_scan(np.array(ranges), -1.0, 0.1, 0.1, 10.0, inf_is_valid=True)
    assert np.isfinite(points).all()
    assert (np.hypot(points[:, 0], points[:, 1]) < 10.001).all()
