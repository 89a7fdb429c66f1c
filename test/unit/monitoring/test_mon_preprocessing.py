import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.core.errors import ParameterError
from safe_passage.core.geometry import matrix
from safe_passage.monitoring.parameters import SourceParameters
from safe_passage.monitoring.preprocessing import (
    between_beams,
    cloud_points,
    outside,
    scan_points,
    shadowed,
    veiling,
)

PLAIN = SourceParameters("laser", veil_angle=0.0, glancing_gap=0.0)
HALF_DEGREE = math.radians(0.5)


def wall_ranges(distance: float, angles: np.ndarray) -> np.ndarray:
    """Ranges to the line x = distance."""
    return distance / np.cos(angles)


def test_scan_points_lie_where_the_laser_sees_them():
    ranges = np.array([1.0, 2.0, 3.0])
    points = scan_points(ranges, -math.pi / 2, math.pi / 2, matrix((1.0, 0.5, math.pi)), PLAIN)
    assert points[:, :3] == pytest.approx(
        np.array([[1.0, 1.5, 0.0], [-1.0, 0.5, 0.0], [1.0, -2.5, 0.0]]), abs=1e-12
    )


def test_a_laser_hung_upside_down_sees_left_and_right_exchanged():
    T = np.diag([1.0, -1.0, -1.0, 1.0])
    points = scan_points(np.array([1.0]), math.pi / 2, 0.1, T, PLAIN)
    assert points[0, :3] == pytest.approx([0.0, -1.0, 0.0], abs=1e-12)


def test_a_reversed_scan_is_the_same_scan():
    angles = np.linspace(-1.0, 1.0, 21)
    ranges = wall_ranges(2.0, angles)
    forth = scan_points(ranges, -1.0, 0.1, np.eye(4), PLAIN)
    back = scan_points(ranges[::-1], 1.0, -0.1, np.eye(4), PLAIN)
    assert back[::-1] == pytest.approx(forth)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 0.0, -1.0, 31.0])
def test_what_is_no_range_is_no_obstacle(bad):
    assert len(scan_points(np.array([bad, bad]), 0.0, 0.1, np.eye(4), PLAIN)) == 0


def test_margins_of_the_field_of_view_are_cut():
    source = SourceParameters("laser", veil_angle=0.0, glancing_gap=0.0, crop_margin=0.25)
    points = scan_points(np.ones(11), -0.5, 0.1, np.eye(4), source)
    assert len(points) == 11 - 2 * 3


def test_a_point_between_near_and_far_is_an_outlier():
    ranges = np.array([2.0, 2.0, 2.0, 3.1, 5.0, 5.0, 5.0])
    assert np.flatnonzero(veiling(ranges, HALF_DEGREE, 0.14, 2)).tolist() == [3]


def test_two_points_between_near_and_far_are_outliers():
    ranges = np.array([5.0, 5.0, 4.0, 3.0, 2.0, 2.0])
    assert np.flatnonzero(veiling(ranges, HALF_DEGREE, 0.14, 2)).tolist() == [2, 3]


def test_an_edge_without_a_point_between_is_left_alone():
    assert not veiling(np.array([2.0, 2.0, 5.0, 5.0]), HALF_DEGREE, 0.14, 2).any()


def test_a_thin_pole_is_left_alone():
    """Near for one beam, far on both sides: the steps lead in and out again."""
    assert not veiling(np.array([5.0, 5.0, 2.0, 5.0, 5.0]), HALF_DEGREE, 0.14, 2).any()


def test_a_wall_at_a_glancing_angle_is_left_alone():
    angles = np.radians(np.arange(60.0, 88.0, 0.5))
    ranges = 0.5 / np.cos(angles)  # along the beam in the end
    assert not veiling(ranges, HALF_DEGREE, 0.14, 2).any()


@given(st.lists(st.sampled_from([math.nan, math.inf, 0.0, 1.0, 1.5, 2.0, 4.0]), max_size=30))
def test_veiling_judges_any_scan_and_never_a_missing_return(values):
    ranges = np.array(values)
    found = veiling(ranges, HALF_DEGREE, 0.14, 2)
    assert found.shape == ranges.shape
    assert np.isfinite(ranges[found]).all()


@given(st.lists(st.sampled_from([1.0, 1.5, 2.0, 4.0]), max_size=30))
def test_veiling_is_the_same_from_left_and_from_right(values):
    ranges = np.array(values)
    back = veiling(ranges[::-1], HALF_DEGREE, 0.14, 2)[::-1]
    assert (veiling(ranges, HALF_DEGREE, 0.14, 2) == back).all()


def test_what_a_nearer_thing_or_the_scans_end_cuts_off_is_marked():
    ranges = np.array([4.0, 4.0, 4.0, 1.0, 1.0, 4.0, math.inf, 4.0, 4.0, 4.0])
    found = shadowed(ranges, np.isfinite(ranges))
    # both ends, and the wall on both sides of the near thing; that thing itself is whole, and
    # where nothing comes back nothing is hidden
    assert np.flatnonzero(found).tolist() == [0, 2, 5, 9]


def test_what_reaches_beyond_the_range_is_marked():
    source = SourceParameters("laser", veil_angle=0.0, glancing_gap=0.0, range_max=3.5)
    ranges = np.array([math.inf, 3.0, 3.2, 3.4, 3.6, 3.8])
    assert scan_points(ranges, 0.0, 0.01, np.eye(4), source)[:, 3].tolist() == [0, 0, 1]


def test_gaps_of_a_wall_at_a_glancing_angle_are_closed():
    x = np.array([1.0, 1.1, 1.25, 1.45, 1.7, 2.0])
    filled = between_beams(np.column_stack([x, np.full(6, 0.3)]), 0.5)
    along = np.sort(np.concatenate([x[1:-1], filled[:, 0]]))
    assert np.diff(along).max() < 0.13
    assert filled[:, 1] == pytest.approx(0.3)
    assert filled[:, 0].min() > 1.1
    assert filled[:, 0].max() < 1.7  # the last gaps have nothing beyond to judge them by


@pytest.mark.parametrize(
    "points",
    [
        [[1, 0], [1.1, 0], [1.3, 0.3], [1.4, 0.3]],  # a step
        [[1, 0], [1.01, 0], [1.4, 0], [1.41, 0]],  # two things in a line
        [[1, 0], [math.nan, 0], [1.2, 0], [1.3, 0]],  # nothing between
        [[1, 0], [1.6, 0], [2.2, 0], [2.8, 0]],  # too far apart
        [[1, 0], [1.1, 0], [1.2, 0]],  # too few
    ],
)
def test_what_is_no_surface_stays_open(points):
    assert len(between_beams(np.array(points, float), 0.5)) == 0


def test_a_cloud_keeps_what_stands_between_floor_and_ceiling():
    T = np.eye(4)
    T[2, 3] = 1.0  # the sensor hangs 1 m over the floor
    source = SourceParameters("camera", "PointCloud2", min_height=0.1, max_height=2.0)
    z = np.array([-1.0, -0.95, -0.85, 0.9, 1.1, math.nan, math.inf])
    points = np.column_stack([np.ones_like(z), np.zeros_like(z), z])
    assert cloud_points(points, T, source)[:, 2] == pytest.approx([0.15, 1.9])


def test_a_cloud_is_cut_at_its_range():
    source = SourceParameters("camera", "PointCloud2", range_min=0.5, range_max=3.0)
    points = np.array([[0.4, 0.0, 0.2], [1.0, 0.0, 0.2], [4.0, 0.0, 0.2]])
    assert len(cloud_points(points, np.eye(4), source)) == 1


@pytest.mark.parametrize("clockwise", [False, True])
def test_the_robot_itself_is_no_obstacle(clockwise):
    polygon = np.array([[0.5, 0.3], [-0.5, 0.3], [-0.5, -0.3], [0.5, -0.3]])
    polygon = polygon[::-1] if clockwise else polygon
    points = np.array([[0.0, 0.0, 0.1], [0.52, 0.0, 0.1], [0.56, 0.0, 0.1], [0.0, 0.4, 0.1]])
    assert outside(points, polygon, 0.05).tolist() == [False, False, True, True]


def test_without_a_footprint_everything_counts():
    assert outside(np.zeros((3, 3)), np.empty((0, 2)), 0.1).all()


@pytest.mark.parametrize(
    "wrong", [{"name": ""}, {"type": "Image"}, {"range_min": 5.0, "range_max": 4.0}]
)
def test_a_wrong_source_is_refused_by_name(wrong):
    with pytest.raises(ParameterError):
        SourceParameters(**{"name": "laser", **wrong})
