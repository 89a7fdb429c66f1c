"""Noise of the simulated sensors: its size, its steps, its shadows and its gaps."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.simulation.robots import CameraModel, LidarModel
from safe_passage.simulation.sensors import measured_colour, measured_depth, measured_ranges

CAMERA = CameraModel(width=320, height=240, focal=262.5)
QUIET = CameraModel(width=320, height=240, disparity_noise=0.0, disparity_step=0.0)


def flat(z: float) -> np.ndarray:
    return np.full((240, 320), z, np.float32)


def draw(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def test_range_noise_and_dropout_are_as_told():
    lidar = LidarModel(noise=0.02, dropout=0.05)
    ranges = measured_ranges(np.full(40000, 4.0), lidar, draw())
    met = np.isfinite(ranges)
    assert 1.0 - met.mean() == pytest.approx(0.05, abs=0.005)
    assert ranges[met].std() == pytest.approx(0.02, rel=0.03)
    assert ranges[met].mean() == pytest.approx(4.0, abs=5e-4)


@given(st.lists(st.floats(0.0, 50.0) | st.just(math.inf), min_size=1, max_size=50))
def test_a_range_is_within_the_limits_or_infinite(exact):
    lidar = LidarModel()
    ranges = measured_ranges(np.array(exact), lidar, draw())
    within = (ranges >= lidar.range_min) & (ranges <= lidar.range_max)
    assert (within | np.isposinf(ranges)).all()
    assert np.isinf(ranges[np.isinf(exact)]).all()


def test_an_exact_lidar_measures_exactly():
    exact = np.array([0.05, 0.07, 19.99, 20.01])
    ranges = measured_ranges(exact, LidarModel(noise=0.0, dropout=0.0), draw())
    assert ranges == pytest.approx([np.inf, 0.07, 19.99, np.inf])


def test_depth_noise_grows_with_the_square_of_the_depth():
    fine = CameraModel(width=320, height=240, disparity_step=0.0)
    near, far = (measured_depth(flat(z), fine, draw()).std() for z in (1.5, 4.5))
    assert far / near == pytest.approx(9.0, rel=0.05)
    predicted = 1.5**2 * fine.disparity_noise / (fine.focal * fine.baseline)
    assert near == pytest.approx(predicted, rel=0.05)


def test_depth_comes_in_steps_of_disparity():
    depth = measured_depth(flat(3.0), CAMERA, draw())
    steps = CAMERA.focal * CAMERA.baseline / depth / CAMERA.disparity_step
    assert steps == pytest.approx(np.rint(steps), abs=1e-3)
    assert len(np.unique(depth)) > 2


@pytest.mark.parametrize("z", [0.3, 12.0, np.inf])
def test_depth_outside_the_limits_is_nan(z):
    assert np.isnan(measured_depth(flat(z), CAMERA, draw())).all()


def test_a_near_thing_casts_its_shadow_to_the_right():
    exact = flat(4.0)
    exact[:, 100:140] = 1.5
    depth = measured_depth(exact, QUIET, draw())
    wide = QUIET.focal * QUIET.baseline * (1.0 / 1.5 - 1.0 / 4.0)  # [px] by similar triangles
    lost = np.isnan(depth).mean(axis=0)
    assert lost[:98].max() == 0.0
    assert lost[142 : 138 + int(wide)].min() == 1.0
    assert lost[144 + int(wide) :].max() == 0.0


def test_without_noise_depth_is_exact_but_for_frayed_edges():
    exact = flat(2.0)
    exact[120:] = 2.4
    depth = measured_depth(exact, QUIET, draw())
    off = ~(np.abs(depth - exact) < 1e-3)
    assert np.flatnonzero(off.any(axis=1)).tolist() == [119, 120]
    assert 0.15 < off[119].mean() < 0.35  # one neighbour of four lies beyond the edge


def test_colour_noise_is_that_of_all_channels_and_keeps_the_mean():
    grey = np.full((240, 320, 3), 120, np.uint8)
    noisy = measured_colour(grey, CAMERA, draw()).astype(float)
    assert noisy.std() == pytest.approx(CAMERA.colour_noise, rel=0.06)
    assert noisy.mean() == pytest.approx(120.0, abs=0.6)
    assert measured_colour(grey, CameraModel(colour_noise=0.0), draw()) is grey
