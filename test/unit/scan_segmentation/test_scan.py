"""Equations 1 to 5 of the paper, there and back."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.core.errors import InputError, ParameterError
from safe_passage.scan_segmentation import (
    OrganisedScan,
    Reason,
    RobotConfiguration,
    SegmentationError,
    SegmentationParameters,
)
from safe_passage.scan_segmentation.pipeline import usable
from safe_passage.scan_segmentation.scan import (
    Level,
    from_line_images,
    line_images,
    to_cartesian,
)

ALPHA = np.linspace(0.0, math.pi / 2, 45, endpoint=False)
BETA = np.linspace(0.0, 2.0 * math.pi, 60, endpoint=False)


def random_scan(seed=0, **values) -> OrganisedScan:
    ranges = np.random.default_rng(seed).uniform(0.5, 8.0, (len(BETA), len(ALPHA)))
    return OrganisedScan(to_cartesian(ranges, ALPHA, BETA), BETA, **values)


def test_points_lie_where_the_equations_say():
    points = to_cartesian(np.array([[2.0]]), np.array([math.pi / 6]), np.array([math.pi / 2]))
    np.testing.assert_allclose(points[0, 0], [0.0, math.sqrt(3.0), 1.0], atol=1e-12)


@pytest.mark.parametrize("nothing", [np.inf, -np.inf, np.nan])
def test_what_is_no_range_is_no_point(nothing):
    assert np.isnan(to_cartesian(np.array([[nothing]]), np.zeros(1), np.zeros(1))).all()


def test_every_line_lies_in_its_own_image():
    uv, y = line_images(random_scan())
    np.testing.assert_allclose(y, 0.0, atol=1e-9)  # equation 5
    np.testing.assert_allclose(np.arctan2(uv[..., 1], uv[..., 0]), np.tile(ALPHA, (60, 1)))


@given(st.tuples(*[st.floats(-3.0, 3.0)] * 3), st.integers(0, 100))
def test_the_way_back_from_the_images_is_the_way_there(axis, seed):
    length = math.hypot(*axis)
    if length < 0.1:
        return
    unit = tuple(value / length for value in axis)
    scan = random_scan(seed, axis=unit, origin=(0.3, -0.2, 0.5))
    uv, y = line_images(scan)
    beta = np.repeat(BETA, len(ALPHA))
    back = from_line_images(uv.reshape(-1, 2), y.ravel(), beta, scan)
    np.testing.assert_allclose(back, scan.points.reshape(-1, 3), atol=1e-9)


def test_the_level_frame_has_up_upward_and_keeps_distances():
    up = (math.sin(0.4), 0.0, math.cos(0.4))
    scan = random_scan(up=up, origin=(1.0, 2.0, 3.0))
    level = Level.of(scan)
    np.testing.assert_allclose(level.R_level_scan @ np.array(up), [0.0, 0.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(level.back(level.points(scan.points)), scan.points, atol=1e-12)


@pytest.mark.parametrize(
    "wrong",
    [
        {"points": np.zeros((60, 45))},
        {"beta": np.zeros(3)},
        {"remission": np.zeros((3, 4))},
        {"axis": (0.0, 0.0, 2.0)},
        {"up": (math.nan, 0.0, 0.0)},
    ],
)
def test_a_scan_that_does_not_fit_together_is_refused(wrong):
    with pytest.raises(InputError):
        OrganisedScan(**{"points": np.zeros((60, 45, 3)), "beta": BETA, **wrong})


def refusal(points, beta=None) -> Reason:
    beta = np.zeros(len(points)) if beta is None else beta
    with pytest.raises(SegmentationError) as caught:
        usable(OrganisedScan(np.asarray(points, float), beta), SegmentationParameters())
    return caught.value.reason


def test_too_little_is_refused_with_the_reason():
    assert refusal(np.zeros((0, 0, 3))) is Reason.TOO_FEW_POINTS
    assert refusal(np.full((60, 45, 3), np.nan)) is Reason.TOO_FEW_POINTS
    assert refusal(random_scan().points[:1]) is Reason.TOO_FEW_POINTS  # one line
    assert refusal(np.ones((60, 45, 3))) is Reason.DEGENERATE  # all the same
    assert refusal(np.linspace([0, 0, 0], [5, 0, 0], 2700).reshape(60, 45, 3)) is Reason.DEGENERATE
    assert refusal(np.full((60, 45, 3), 1e30)) is Reason.TOO_FEW_POINTS


def test_a_huge_scan_is_thinned_out_and_says_so():
    p = SegmentationParameters(max_points=1000)
    scan = usable(random_scan(remission=np.zeros((60, 45))), p)
    assert scan.points.shape[0] * scan.points.shape[1] <= 1000
    assert scan.remission is not None and scan.remission.shape == scan.points.shape[:2]
    assert "thinned out" in scan.notes[0]


@pytest.mark.parametrize(
    "wrong", [{"width": math.nan}, {"max_slope": 1.0}, {"max_obstacle": 9.0}, {"margin": -1.0}]
)
def test_a_robot_that_cannot_be_is_refused_by_the_name_of_the_field(wrong):
    with pytest.raises(ParameterError, match=next(iter(wrong))):
        RobotConfiguration(**wrong)


@pytest.mark.parametrize("wrong", [{"fine_cell": 0.03}, {"line_points": 2}, {"max_range": 0.0}])
def test_parameters_out_of_range_are_refused(wrong):
    with pytest.raises(ParameterError):
        SegmentationParameters(**wrong)


def test_a_sparse_scan_needs_fewer_segments():
    p = SegmentationParameters()
    assert (p.segments_for(430), p.segments_for(80)) == (25, 6)
