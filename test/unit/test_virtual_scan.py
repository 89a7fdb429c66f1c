"""The scan cut out of a cloud."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from safe_passage.replay.virtual_scan import virtual_scan

ANGLES = np.linspace(-np.pi / 2, np.pi / 2, 181)  # a beam a degree


def cut(points):
    return virtual_scan(np.array(points, float), ANGLES, 0.1, 0.4, 10.0)


def test_nearest_point_of_the_band_counts():
    ranges = cut([[2.0, 0.0, 0.2], [3.0, 0.0, 0.2], [1.0, 0.0, 0.9], [1.0, 0.0, 0.0]])
    assert ranges[90] == pytest.approx(2.0)


def test_seen_and_empty_is_inf_unseen_is_nan():
    ranges = cut([[2.0, 0.0, 1.0]])
    assert np.isinf(ranges[90])
    assert np.isnan(ranges[:90]).all()


def test_beyond_range_is_no_return():
    assert np.isinf(cut([[11.0, 0.0, 0.2]])[90])


def test_no_points_no_knowledge():
    assert np.isnan(cut(np.full((5, 3), np.nan))).all()


@given(hnp.arrays(float, (20, 3), elements=st.floats(allow_nan=True, allow_infinity=True)))
def test_any_cloud_gives_ranges_or_nothing(points):
    with np.errstate(over="ignore"):
        ranges = cut(points)
    assert ranges.shape == ANGLES.shape
    finite = ranges[np.isfinite(ranges)]
    assert ((finite >= 0.0) & (finite <= 10.0)).all()
