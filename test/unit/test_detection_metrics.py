"""The paper's detection metrics and the judging of frames with user masks."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from safe_passage.evaluation.detection_metrics import DetectionCounts
from safe_passage.evaluation.user_masks import judge, persons_in


def test_a_worked_example():
    counts = DetectionCounts(tp=8, fp=2, fn=4, tn=6)
    assert counts.precision == pytest.approx(0.8)
    assert counts.recall == pytest.approx(2 / 3)
    assert counts.accuracy == pytest.approx(0.7)
    assert counts.f1 == pytest.approx(2 * 0.8 * (2 / 3) / (0.8 + 2 / 3))
    assert counts.fp_rate == pytest.approx(0.25)


def test_nothing_to_judge_is_nan_not_zero():
    assert math.isnan(DetectionCounts().precision)
    assert math.isnan(DetectionCounts(tp=3).fp_rate)


@pytest.fixture
def mask():
    image = np.zeros((100, 200), np.uint8)
    image[10:90, 20:60] = 255
    image[10:90, 120:160] = 255
    image[0:3, 0:3] = 255  # a speck
    return image


def candidate(x, y, accepted):
    points = np.array([[x + dx, y + dy] for dx in range(10) for dy in range(10)])
    return SimpleNamespace(accepted=accepted), points


def verdict(mask, *candidates):
    detections, pixels = zip(*candidates) if candidates else ([], [])
    return judge(detections, pixels, persons_in(mask))


def test_regions_and_labels_are_persons_specks_are_not(mask):
    assert len(persons_in(mask)) == 2
    labelled = np.where(mask == 255, 1, 0).astype(np.uint8)
    labelled[:, 100:] *= 2
    assert len(persons_in(labelled)) == 2


def test_one_found_one_missed_one_false(mask):
    counts = verdict(
        mask, candidate(30, 30, True), candidate(80, 30, True), candidate(90, 30, False)
    )
    assert counts == DetectionCounts(tp=1, fp=1, fn=1, tn=1)


def test_a_person_seen_twice_is_once_false(mask):
    counts = verdict(mask, candidate(30, 30, True), candidate(35, 50, True))
    assert (counts.tp, counts.fp, counts.fn) == (1, 1, 1)


def test_nobody_and_nothing(mask):
    assert verdict(np.zeros_like(mask)) == DetectionCounts()
    assert verdict(mask) == DetectionCounts(fn=2)
