"""The fourteen features against shapes whose values are known."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.leg_detection.features import (
    FEATURE_NAMES,
    MAX_JUMP,
    MAX_RADIUS,
    beam_speeds,
    segment_features,
)
from safe_passage.leg_detection.scan import Scan
from safe_passage.leg_detection.segmentation import Segments, segment


def features(*pieces, all_round=False, speeds=None):
    """Name -> values (K,) of the segments whose points are given."""
    points = np.concatenate([np.asarray(piece, float) for piece in pieces])
    starts = np.cumsum([0] + [len(piece) for piece in pieces[:-1]])
    made = Segments(points, np.arange(len(points)), starts, all_round)
    return dict(zip(FEATURE_NAMES, segment_features(made, speeds).T))


def arc(radius=0.06, centre=(2.0, 0.0), half=1.2, count=15):
    """The side of a circle that a scanner at the origin sees, counter-clockwise about it."""
    angles = math.pi + np.linspace(half, -half, count)
    return np.c_[centre[0] + radius * np.cos(angles), centre[1] + radius * np.sin(angles)]


def line(length=0.8, count=9, angle=0.7, start=(2.0, -0.4)):
    along = np.linspace(0.0, length, count)
    return np.c_[start[0] + along * math.cos(angle), start[1] + along * math.sin(angle)]


def test_there_are_fourteen():
    assert len(FEATURE_NAMES) == len(set(FEATURE_NAMES)) == 14


def test_a_circle():
    found = features(arc())
    step = 2.4 / 14
    chord = 2 * 0.06 * math.sin(step / 2)
    assert found["number_of_points"] == 15
    assert found["radius"] == pytest.approx(0.06)
    assert found["circularity"] == pytest.approx(0.0, abs=1e-12)
    assert found["linearity"] > 1e-4
    assert found["mean_curvature"] == pytest.approx(1 / 0.06)
    assert found["mean_angular_difference"] == pytest.approx(-step)  # bulges to the scanner
    assert found["boundary_length"] == pytest.approx(14 * chord)
    assert found["boundary_regularity"] == pytest.approx(0.0, abs=1e-12)
    assert found["width"] == pytest.approx(2 * 0.06 * math.sin(1.2))


def test_a_hollow_turns_the_other_way():
    found = features(arc()[::-1])
    assert found["mean_angular_difference"] == pytest.approx(2.4 / 14)
    assert found["mean_curvature"] == pytest.approx(1 / 0.06)


def test_a_line():
    found = features(line())
    along = np.linspace(0.0, 0.8, 9)
    assert found["width"] == pytest.approx(0.8)
    assert found["boundary_length"] == pytest.approx(0.8)
    assert found["linearity"] == pytest.approx(0.0, abs=1e-12)
    assert found["circularity"] == pytest.approx(0.0, abs=1e-12)
    assert found["radius"] == MAX_RADIUS
    assert found["mean_curvature"] == pytest.approx(0.0, abs=1e-6)
    assert found["mean_angular_difference"] == pytest.approx(0.0, abs=1e-6)
    assert found["standard_deviation"] == pytest.approx(along.std(ddof=1))
    assert found["mean_deviation_from_median"] == pytest.approx(np.abs(along - 0.4).mean())


def test_scatter_about_a_line_is_its_linearity():
    """Points 0.01 m to either side in turn: the sum of squares of the paper, not a mean."""
    points = line(count=8, angle=0.0, start=(1.0, 1.0))
    points[[0, 3, 4, 7], 1] += 0.01
    points[[1, 2, 5, 6], 1] -= 0.01  # balanced, so that the best line is not tilted
    assert features(points)["linearity"] == pytest.approx(8 * 0.01**2)


def test_scatter_about_a_circle_is_its_circularity():
    angles = np.arange(12) * math.pi / 6
    radii = np.where(np.arange(12) % 2, 0.11, 0.09)
    found = features(np.c_[radii * np.cos(angles), 2.0 + radii * np.sin(angles)])
    assert found["radius"] == pytest.approx(math.sqrt((0.11**2 + 0.09**2) / 2))
    assert found["circularity"] == pytest.approx(((radii - found["radius"]) ** 2).sum())


def test_a_right_angle():
    found = features([(1.0, 0.0), (1.0, 0.3), (0.6, 0.3)])
    assert found["mean_angular_difference"] == pytest.approx(math.pi / 2)
    assert found["mean_curvature"] == pytest.approx(1 / 0.25)  # circumscribed circle
    assert found["radius"] == pytest.approx(0.25)
    assert found["boundary_length"] == pytest.approx(0.7)
    assert found["boundary_regularity"] == pytest.approx(0.05)
    assert found["mean_deviation_from_median"] == pytest.approx((0.3 + 0.0 + 0.4) / 3)


def test_an_even_number_has_the_median_between_its_middle_two():
    found = features([(0.0, 1.0), (1.0, 1.0), (2.0, 1.0), (7.0, 5.0)])
    away = 1.5 + 0.5 + 0.5 + math.hypot(5.5, 4.0)
    assert found["mean_deviation_from_median"] == pytest.approx(away / 4)


def test_jumps_are_to_the_neighbours_ends():
    pieces = [(2.0, -1.0), (2.0, -0.5)], [(1.0, -0.5), (1.0, 0.5)], [(1.5, 0.5), (1.5, 2.0)]
    found = features(*pieces)
    assert found["jump_from_preceding"].tolist() == [MAX_JUMP, 1.0, 0.5]
    assert found["jump_to_succeeding"].tolist() == [1.0, 0.5, MAX_JUMP]
    found = features(*pieces, all_round=True)
    round_the_back = math.hypot(0.5, 3.0)
    assert found["jump_from_preceding"] == pytest.approx([round_the_back, 1.0, 0.5])
    assert found["jump_to_succeeding"] == pytest.approx([1.0, 0.5, round_the_back])


def test_long_jumps_are_all_the_same():
    found = features([(20.0, 0.0)], [(1.0, 0.0)])
    assert found["jump_to_succeeding"].tolist() == [MAX_JUMP, MAX_JUMP]


def test_alone_in_the_world_there_is_no_neighbour():
    for all_round in (True, False):
        found = features(arc(), all_round=all_round)
        assert found["jump_from_preceding"] == found["jump_to_succeeding"] == MAX_JUMP


def test_segments_do_not_touch_each_others_features():
    """Each piece has, among others, what it has alone; but for the jumps."""
    pieces = [arc(), line(), arc(0.2, (1.0, 3.0), count=7), [(4.0, 4.0)], [(5.0, 4.0), (5.0, 4.1)]]
    together = features(*pieces)
    for k, piece in enumerate(pieces):
        alone = features(piece)
        for name in FEATURE_NAMES:
            if not name.startswith("jump"):
                assert together[name][k] == pytest.approx(alone[name][0], abs=1e-9), name


@pytest.mark.parametrize("points", [[(1.0, 2.0)], [(1.0, 2.0)] * 2, [(1.0, 2.0)] * 5])
def test_points_in_one_place_have_finite_features(points):
    found = features(points)
    assert found["radius"] == MAX_RADIUS
    assert all(np.isfinite(value).all() for value in found.values())
    assert found["width"] == found["linearity"] == found["mean_curvature"] == 0.0


def test_nothing_seen():
    nothing = segment(Scan(np.full(9, np.inf), 0.0, 0.01), 0.1)
    assert segment_features(nothing).shape == (0, 14)


def scan(ranges, stamp, **changes):
    return Scan(
        np.asarray(ranges, float), **{"angle_min": 0.0, "angle_increment": 0.01, **changes},
        range_max=10.0, stamp=stamp,
    )  # fmt: skip


def test_speed_along_the_beam():
    before, after = scan([2.0, 2.0, 3.0], 1.0), scan([2.1, 2.2, 2.9], 1.1)
    assert beam_speeds(after, before, 0.5) == pytest.approx([1.0, 2.0, -1.0])
    found = features([(2.1, 0.0), (2.2, 0.0)], [(2.9, 0.0)], speeds=np.array([1.0, 2.0, -1.0]))
    assert found["mean_speed"] == pytest.approx([1.5, -1.0])


def test_speed_only_of_beams_that_returned_twice():
    before = scan([np.nan, 2.0, 2.0, 2.0, 0.0, 11.0], 1.0)
    after = scan([2.0, 2.1, np.inf, 11.0, 2.0, 2.0], 1.1)
    expected = [np.nan, 1.0, np.nan, np.nan, np.nan, np.nan]
    assert beam_speeds(after, before, 0.5) == pytest.approx(expected, nan_ok=True)
    speeds = np.array([np.nan, 1.0, np.nan])
    found = features([(1.0, 0.0), (1.0, 0.1)], [(3.0, 0.0)], speeds=speeds)
    assert found["mean_speed"].tolist() == [1.0, 0.0]


@pytest.mark.parametrize(
    "before",
    [
        None,
        scan([2.0, 2.0], 1.1),  # the same time
        scan([2.0, 2.0], 1.2),  # later: out of order, or a clock that went back
        scan([2.0, 2.0], 0.5),  # too long ago
        scan([2.0, 2.0, 2.0], 1.0),
        scan([2.0, 2.0], 1.0, angle_min=0.1),
        scan([2.0, 2.0], 1.0, angle_increment=0.02),
    ],
)
def test_no_speed_without_a_scan_before(before):
    assert np.isnan(beam_speeds(scan([2.1, 2.2], 1.1), before, 0.5)).all()


ranges = st.lists(
    st.one_of(st.floats(0.01, 20.0), st.sampled_from([math.nan, math.inf, 0.0])), max_size=60
).map(np.array)


@given(ranges, st.floats(0.01, 3.0), st.booleans())
def test_features_are_always_finite(values, jump, all_round):
    step = 2 * math.pi / max(len(values), 1) if all_round else 0.02
    found = segment(Scan(values, -1.0, step), jump)
    assert np.isfinite(segment_features(found, np.full(len(values), np.nan))).all()


@given(ranges, st.floats(-3.0, 3.0))
def test_features_do_not_depend_on_the_bearing(values, turn):
    """But for the paper's median of x and of y, which does by its definition."""
    here = segment_features(segment(Scan(values, -1.0, 0.02), 0.5))
    there = segment_features(segment(Scan(values, -1.0 + turn, 0.02), 0.5))
    settled = here[:, FEATURE_NAMES.index("radius")] < 0.9 * MAX_RADIUS
    turnable = [name != "mean_deviation_from_median" for name in FEATURE_NAMES]
    expected = here[settled][:, turnable]
    assert there[settled][:, turnable] == pytest.approx(expected, rel=1e-5, abs=1e-6)
