"""Scans cut into segments: where they should be, whatever the scanner."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.core.errors import InputError, ParameterError
from safe_passage.leg_detection.scan import Scan
from safe_passage.leg_detection.segmentation import SegmentationParameters, segment

STEP = math.radians(1.0)
any_range = st.one_of(
    st.floats(0.0, 12.0), st.sampled_from([math.nan, math.inf, -math.inf, 0.0, -1.0])
)
some_ranges = st.lists(any_range, max_size=60).map(np.array)


def scan(ranges, **changes):
    geometry = {"angle_min": -1.0, "angle_increment": STEP, "range_min": 0.05, "range_max": 10.0}
    return Scan(np.asarray(ranges, float), **{**geometry, **changes})


def test_two_steps_make_three_segments():
    found = segment(scan([2.0] * 5 + [1.0] * 4 + [3.0] * 6), 0.13)
    assert found.sizes.tolist() == [5, 4, 6]
    assert found.starts.tolist() == [0, 5, 9]
    assert found.owners.tolist() == [0] * 5 + [1] * 4 + [2] * 6
    assert np.hypot(*found.centres()[1]) == pytest.approx(1.0, abs=1e-2)


def test_points_lie_on_their_beams():
    found = segment(scan([1.0, 1.0, 2.0]), 0.13)
    angles = -1.0 + STEP * np.arange(3)
    expected = np.array([1.0, 1.0, 2.0])[:, None] * np.c_[np.cos(angles), np.sin(angles)]
    assert found.points == pytest.approx(expected)


@pytest.mark.parametrize("nothing", [math.nan, math.inf, -math.inf, 0.0, 0.04, 10.0, 11.0, -1.0])
def test_no_return_gives_no_point_and_cuts_only_where_there_is_a_jump(nothing):
    found = segment(scan([1.0, 1.0, nothing, 1.0, 1.0]), 0.13)
    assert found.sizes.tolist() == [4]
    assert found.beams.tolist() == [0, 1, 3, 4]
    found = segment(scan([1.0, 1.0] + [nothing] * 10 + [1.0, 1.0]), 0.13)
    assert found.sizes.tolist() == [2, 2]


@pytest.mark.parametrize("ranges", [[], [math.nan], [math.inf] * 7])
def test_nothing_seen_is_no_segment(ranges):
    found = segment(scan(ranges), 0.13)
    assert len(found) == 0
    assert found.sizes.tolist() == found.owners.tolist() == []
    assert found.centres().shape == (0, 2)


def full_circle(ranges, **changes):
    return scan(ranges, angle_min=-math.pi, angle_increment=2 * math.pi / len(ranges), **changes)


def test_a_segment_across_the_seam_stays_whole():
    ranges = np.full(360, 4.0)
    ranges[:3] = ranges[-4:] = 2.0
    found = segment(full_circle(ranges), 0.13)
    assert found.sizes.tolist() == [7, 353]
    assert found.beams[:7].tolist() == [356, 357, 358, 359, 0, 1, 2]
    assert np.diff(found.points[:7, 1]).max() < 0.0  # behind the scanner, counter-clockwise
    partial = segment(scan(ranges[:-2], angle_min=-math.pi, angle_increment=math.pi / 180), 0.13)
    assert partial.sizes.tolist() == [3, 353, 2]


def test_first_and_last_beam_may_have_the_same_angle():
    ranges = np.full(361, 4.0)
    ranges[:3] = ranges[-3:] = 2.0
    found = segment(scan(ranges, angle_min=-math.pi, angle_increment=math.pi / 180), 0.13)
    assert found.sizes.tolist() == [6, 355]


def test_one_wall_all_round_is_one_segment():
    assert segment(full_circle(np.full(360, 2.0)), 0.13).sizes.tolist() == [360]


@given(some_ranges, st.floats(0.01, 1.0), st.booleans())
def test_every_return_is_in_exactly_one_segment(ranges, jump, all_round):
    made = full_circle if all_round and len(ranges) else scan
    one = made(ranges)
    found = segment(one, jump)
    assert sorted(found.beams) == np.flatnonzero(one.returns()).tolist()
    assert found.sizes.sum() == len(found.points)
    assert (found.sizes > 0).all()


@given(some_ranges, st.floats(0.01, 1.0))
def test_jumps_lie_between_segments_and_nowhere_else(ranges, jump):
    found = segment(scan(ranges), jump)
    gaps = np.linalg.norm(np.diff(found.points, axis=0), axis=1)
    assert (gaps > jump).tolist() == (np.diff(found.owners) > 0).tolist()


@given(some_ranges, st.floats(0.01, 1.0))
def test_a_scanner_that_turns_clockwise_sees_the_same(ranges, jump):
    forth = segment(scan(ranges), jump)
    last = -1.0 + STEP * (len(ranges) - 1)
    back = segment(scan(ranges[::-1], angle_min=last, angle_increment=-STEP), jump)
    assert back.points == pytest.approx(forth.points, abs=1e-9)
    assert back.starts.tolist() == forth.starts.tolist()


@pytest.mark.parametrize(
    "changes",
    [
        {"angle_min": math.nan},
        {"angle_increment": math.inf},
        {"angle_increment": 0.0},
        {"range_max": 0.01},
        {"range_min": math.nan},
        {"range_min": -1.0},
    ],
)
def test_a_scan_without_geometry_is_refused(changes):
    with pytest.raises(InputError, match=r"angle|range"):
        scan([1.0, 2.0], **changes)
    with pytest.raises(InputError, match="dimensions"):
        scan([[1.0, 2.0]])


def test_parameters_are_checked():
    with pytest.raises(ParameterError, match="jump_distance"):
        SegmentationParameters(jump_distance=0.0)
    with pytest.raises(ParameterError, match="min_points"):
        SegmentationParameters(min_points=1)
