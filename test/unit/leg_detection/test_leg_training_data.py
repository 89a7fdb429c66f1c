"""Which segments are legs, which are not, and which nobody knows."""

import numpy as np
import pytest
from leg_world import ANGLES, LEG_RADIUS, look, walk
from safe_passage.leg_detection.scan import Scan
from safe_passage.leg_detection.segmentation import SegmentationParameters, Segments, segment
from safe_passage.leg_detection.training_data import (
    LEG,
    OTHER,
    UNKNOWN,
    LabelledScan,
    LegRecording,
    background_beams,
    from_labelled_scans,
    from_recording,
    joined,
    label_by_legs,
)

P = SegmentationParameters()


def segments_at(*places, size=4):
    """A segment of `size` points, 1 cm apart, at each place (x, y)."""
    steps = np.c_[np.zeros(size), 0.01 * np.arange(size)]
    points = np.concatenate([np.add(place, steps) for place in places])
    return Segments(points, np.arange(len(points)), size * np.arange(len(places)))


def labels(places, legs, furniture=()):
    made = segments_at(*places)
    background = np.isin(made.owners, furniture)
    return label_by_legs(made, np.array(legs).reshape(-1, 2), background).tolist()


def test_the_nearest_segment_is_the_leg():
    assert labels([(1.0, 0.0), (1.0, 2.0)], [(1.0, 0.05)], furniture=[1]) == [LEG, OTHER]


def test_a_leg_position_away_from_every_segment_makes_no_leg():
    assert labels([(1.0, 0.0)], [(1.0, 0.2)], furniture=[0]) == [UNKNOWN]


def test_what_is_near_a_leg_is_unknown_even_where_furniture_is():
    assert labels([(1.0, 0.0), (1.0, 0.3)], [(1.0, 0.0)], furniture=[1]) == [LEG, UNKNOWN]


def test_two_legs_side_by_side_are_both_legs():
    legs = [(1.0, 0.0), (1.0, 0.3)]
    assert labels(legs, legs) == [LEG, LEG]
    assert labels(legs, legs[::-1]) == [LEG, LEG]


def test_what_came_and_went_far_from_the_legs_is_unknown():
    assert labels([(1.0, 0.0), (3.0, 0.0)], [(1.0, 0.0)]) == [LEG, UNKNOWN]


def test_no_legs_and_no_segments():
    assert labels([(1.0, 0.0)], [], furniture=[0]) == [OTHER]
    empty = Segments(np.zeros((0, 2)), np.zeros(0, int), np.zeros(0, int))
    assert len(label_by_legs(empty, np.array([(1.0, 0.0)]), np.zeros(0, bool))) == 0


def test_background_is_what_is_seen_in_most_scans():
    ranges = np.full((10, 3), 3.0)
    ranges[:4, 0] = 1.0  # something stood there for four scans of ten
    ranges[:6, 1] = np.inf  # four returns of ten
    ranges[:, 2] += 0.04 * np.arange(10) % 0.08  # noise
    scans = [Scan(row, 0.0, 0.1, 0.05, 10.0, 0.1 * i) for i, row in enumerate(ranges)]
    found = background_beams(scans)
    assert found[:, 0].tolist() == [False] * 4 + [True] * 6
    assert not found[:, 1].any()
    assert found[:, 2].all()


def test_a_recording_has_its_legs_its_walls_and_nothing_wrong():
    recording, _ = walk("walk", seed=3)
    found = from_recording(recording, P)
    assert found.count(LEG) >= 0.8 * 2 * len(recording.scans)  # some hide each other
    assert found.count(OTHER) > found.count(LEG)
    assert set(found.groups) == {"walk"}
    widths = found.features[:, 5]
    assert widths[found.labels == LEG].max() < 2 * LEG_RADIUS + 0.31  # two that touch at most
    assert found.known.count(UNKNOWN) == 0


def test_somebody_unmarked_who_walks_by_is_neither():
    """Two walk, one is marked: the segments of the other are not taken for furniture."""
    scans, marked = [], []
    for i in range(20):
        one, other = (1.0 + 0.08 * i, 1.0), (2.6 - 0.08 * i, -1.5)
        scans.append(look([one, other], stamp=0.1 * i).scan)
        marked.append(np.array([one]))
    found = from_recording(LegRecording("two", scans, marked), P)
    narrow = found.features[:, 5] < 0.2
    assert found.count(LEG) == 20
    assert (found.labels[narrow] == UNKNOWN).sum() >= 15
    assert not (found.labels[narrow] == OTHER).any()


def test_where_nobody_is_everything_is_other_in_blocks_of_time():
    scans = [look([(1.5, 0.0)], stamp=0.1 * i).scan for i in range(7)]
    found = from_recording(LegRecording("empty", scans, None), P, blocks=3)
    assert found.count(OTHER) == len(found.labels)
    assert list(dict.fromkeys(found.groups)) == ["empty 1", "empty 2", "empty 3"]
    assert found.groups.tolist() == sorted(found.groups)


def test_small_segments_are_left_out_but_are_neighbours():
    ranges = np.full(20, 5.0)
    ranges[8:10] = 2.0
    ranges[10:] = 1.0
    scan = Scan(ranges, 0.0, 0.01, 0.05, 10.0)
    found = from_recording(LegRecording("few", [scan], None), P)
    assert found.features[:, 0].tolist() == [8, 10]
    assert found.features[1, 3] == pytest.approx(1.0, abs=0.01)  # jump from the small one


def test_mean_speed_is_from_the_scan_before():
    scans = [look([(2.0 - 0.1 * i, 0.0)], stamp=0.1 * i).scan for i in range(3)]
    found = from_recording(LegRecording("come", scans, None), P)
    narrow = found.features[:, 5] < 0.2
    assert found.features[narrow, 13] == pytest.approx([0.0, -1.0, -1.0], abs=0.2)


def labelled(person, count=30):
    ranges = np.full(count, 2.0)
    return LabelledScan(Scan(ranges, 0.0, 0.01, 0.05, 10.0), np.isin(np.arange(count), person))


@pytest.mark.parametrize(
    ("person_beams", "to_train", "to_judge"),
    [
        (range(0), OTHER, OTHER),
        (range(2), UNKNOWN, OTHER),  # too few to be found
        (range(3), UNKNOWN, LEG),  # hidden in a wall: to be found, not to learn from
        (range(15), LEG, LEG),
        (range(30), LEG, LEG),
    ],
)
def test_labels_by_beams(person_beams, to_train, to_judge):
    scans = [labelled(person_beams)]
    assert from_labelled_scans(scans, P, "sim", judging=False).labels.tolist() == [to_train]
    assert from_labelled_scans(scans, P, "sim", judging=True).labels.tolist() == [to_judge]


def test_both_ways_of_labelling_agree():
    """Where both know: by the position of a leg, and by the beams that meet it."""
    recording, scans = walk("walk", seed=5)
    by_place = from_recording(recording, P)
    by_beam = from_labelled_scans(scans, P, "walk", judging=False)
    both = (by_place.labels != UNKNOWN) & (by_beam.labels != UNKNOWN)
    assert both.mean() > 0.7
    assert (by_place.labels[both] == by_beam.labels[both]).mean() > 0.99


def test_nothing_joined_is_nothing():
    nothing = joined([])
    assert nothing.features.shape == (0, 14)
    assert nothing.count(LEG) == 0


def test_the_world_is_as_it_says():
    one = look([(2.0, 0.0)])
    seen = np.flatnonzero(one.person_beams)
    assert one.scan.ranges[seen].min() == pytest.approx(2.0 - LEG_RADIUS, abs=1e-3)
    assert np.abs(ANGLES[seen]).max() == pytest.approx(np.arcsin(LEG_RADIUS / 2.0), abs=0.01)
    assert len(segment(one.scan, 0.13)) == 3
