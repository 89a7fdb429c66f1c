"""Median over time, edges, where to begin, what is determined."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst
from safe_passage.calibration import CalibrationParameters, temporal_median
from safe_passage.calibration.arm_surface import VisibleSurface
from safe_passage.calibration.edges import away_from_edges
from safe_passage.calibration.quality import observability, residual
from safe_passage.calibration.start import agreement, laid_on, moving
from safe_passage.core.errors import InputError, ParameterError
from scipy.spatial.transform import Rotation

DEPTHS = st.one_of(st.just(np.nan), st.floats(0.5, 5.0, width=32))


@given(
    npst.arrays(np.float32, st.tuples(st.integers(1, 9), st.just(2), st.just(3)), elements=DEPTHS)
)
def test_the_median_is_that_of_what_was_measured(images: np.ndarray) -> None:
    known = np.isfinite(images).sum(axis=0)
    found = temporal_median(list(images), 0.0)
    assert (np.isfinite(found) == (known > 0)).all()
    for at in zip(*np.nonzero(known)):
        column = images[(slice(None), *at)]
        assert found[at] == pytest.approx(np.median(column[np.isfinite(column)]), rel=1e-6)


def test_a_pixel_that_is_mostly_lost_has_no_depth() -> None:
    images = [np.full((1, 2), 1.0, np.float32) for _ in range(4)]
    for image in images[1:]:
        image[0, 1] = np.nan
    assert np.isnan(temporal_median(images, 0.5)).tolist() == [[False, True]]
    with pytest.raises(InputError, match="no depth image"):
        temporal_median([], 0.5)
    with pytest.raises(InputError, match="depth images of"):
        temporal_median([images[0], np.zeros((2, 2), np.float32)], 0.5)


def test_pixels_beside_an_edge_or_a_hole_are_left_out() -> None:
    depth = np.ones((9, 20), np.float32)
    depth[:, 10:] = 2.0
    depth[4, 3] = np.nan
    inner = away_from_edges(depth, 2, 0.05)
    assert not inner[:, 8:12].any()
    assert not inner[2:7, 1:6].any()
    assert inner[0, 7] and inner[4, 6] and inner[4, 12]
    np.testing.assert_array_equal(away_from_edges(depth, 0, 0.05), np.isfinite(depth))


def test_what_moves_between_the_poses_is_the_arm() -> None:
    room = np.full((4, 6), 3.0, np.float32)
    room[0, 0] = np.nan
    one, two = room.copy(), room.copy()
    one[1:3, 0:2], two[1:3, 4:6] = 1.0, 1.2
    found = moving([one, two])
    np.testing.assert_array_equal(np.isfinite(found[0]), one == 1.0)
    np.testing.assert_array_equal(np.isfinite(found[1]), two == np.float32(1.2))
    np.testing.assert_array_equal(moving([one])[0], one)


def test_the_same_in_a_model_where_nothing_is_behind_the_arm() -> None:
    one, two = np.full((2, 3), np.inf, np.float32), np.full((2, 3), np.inf, np.float32)
    one[0, 0], two[1, 2] = 1.0, 1.0
    one[0, 1] = two[0, 1] = 1.0  # the arm's foot, which stands still
    assert np.argwhere(np.isfinite(moving([one, two])[0])).tolist() == [[0, 0]]


def test_middles_of_three_poses_place_the_camera() -> None:
    rng = np.random.default_rng(5)
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix()
    T[:3, 3] = 0.4, -0.2, 1.0
    clouds = [rng.normal(middle, 0.05, (40, 3)) for middle in rng.normal(0.0, 0.4, (4, 3))]
    found = laid_on(clouds, [cloud @ T[:3, :3].T + T[:3, 3] for cloud in clouds])
    assert found is not None
    np.testing.assert_allclose(found, T, atol=0.05)
    assert laid_on(clouds[:2], clouds[:2]) is None


def test_agreement_counts_the_models_pixels() -> None:
    model = np.array([[1.0, 1.0, np.inf]], np.float32)
    sensor = np.array([[1.01, np.nan, 1.0]], np.float32)
    assert agreement([sensor], [model], 0.05) == 0.5
    assert agreement([sensor], [np.full((1, 3), np.inf)], 0.05) == 0.0


def plane(normal: tuple[float, float, float], count: int = 400) -> VisibleSurface:
    rng = np.random.default_rng(1)
    n = np.array(normal)
    points = rng.uniform(-0.5, 0.5, (count, 3))
    points -= (points @ n)[:, None] * n
    return VisibleSurface(points, np.tile(n, (count, 1)))


def test_a_plane_leaves_three_directions_free_and_a_corner_none() -> None:
    floor = observability([plane((0.0, 0.0, 1.0))])
    assert (floor.eigenvalues[:3] < 1e-9).all()
    assert (floor.eigenvalues[3:] > 0.05).all()
    assert "shift in z" not in floor.weakest
    corner = observability([plane((1.0, 0.0, 0.0)), plane((0.0, 1.0, 0.0)), plane((0.0, 0.0, 1.0))])
    assert corner.eigenvalues[0] > 0.05
    assert corner.eigenvalues.sum() == pytest.approx(1.0)


def test_residuals_are_distances_and_shares() -> None:
    model = plane((0.0, 0.0, 1.0), 20000)
    sensor = model.points[:10000] + [0.0, 0.0, 0.01]
    half = residual(sensor, model, 0.03, 0.02)
    assert half.rms == pytest.approx(0.01, abs=2e-3)
    assert half.median == pytest.approx(0.01, abs=1e-3)
    assert half.points == 10000
    assert half.inliers > 0.95  # the other half's points have neighbours
    none = residual(sensor + 1.0, model, 0.03, 0.02)
    assert (none.points, none.inliers) == (0, 0.0)
    assert residual(sensor[:0], model, 0.03, 0.02).points == 0


@pytest.mark.parametrize(
    "bad", [{"method": "NDT"}, {"distances": ()}, {"last_distance": 0.0}, {"least_share": 1.5}]
)
def test_wrong_parameters_are_refused(bad: dict) -> None:
    with pytest.raises(ParameterError):
        CalibrationParameters(**bad)
