"""Table 3: who must be found, who found whom, recall in bins; the same by any number of workers."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
import safe_passage.evaluation.detector_table as detector_table
from eval_worlds import SETTING
from safe_passage.evaluation.detection_metrics import DetectionCounts
from safe_passage.evaluation.detector_report import (
    Batch,
    DetectorReport,
    as_markdown,
    as_values,
    judge_batch,
    judge_detectors,
)
from safe_passage.evaluation.detector_table import (
    STANDARDS,
    DetectorScore,
    PersonOutcome,
    recall_by,
    score_view,
)
from safe_passage.evaluation.parallel import Workers
from safe_passage.simulation.robots import CameraModel
from safe_passage.simulation.truth import PersonTruth

CAMERA = CameraModel()


def person(number=0, distance=4.0, visible=1.0, height=200.0, y=0.0):
    box = (100.0, 50.0, 60.0, height)
    return PersonTruth(number, "tall_man", (distance, y), (0.0, 0.0), distance, box, visible)


@pytest.mark.parametrize(
    ("truth", "reasonable", "half"),
    [
        (person(), True, True),
        (person(visible=0.65), True, True),
        (person(visible=0.64), False, True),
        (person(visible=0.49), False, False),
        (person(height=49.0), False, True),
        (person(distance=1.4), False, False),
        (person(distance=8.1), False, False),
    ],
)
def test_who_must_be_found(truth, reasonable, half):
    assert STANDARDS["reasonable"].wants(truth) is reasonable
    assert STANDARDS["half_visible"].wants(truth) is half


def candidate(x, y, accepted, confidence=0.5):
    head = np.array([x, y, 1.7])
    return SimpleNamespace(
        candidate=SimpleNamespace(head=head), accepted=accepted, confidence=confidence
    )


def score(monkeypatch, persons, candidates):
    monkeypatch.setattr(
        detector_table, "detect", lambda *args: SimpleNamespace(detections=candidates)
    )
    view = SimpleNamespace(persons=persons, pose=(0.0, 0.0, 0.0))
    return score_view(None, view, CAMERA, 7)


def test_a_worked_example(monkeypatch):
    """One found, one missed, one barely visible found all the same, a pallet accepted, two not."""
    persons = [person(0, 3.0), person(1, 5.0), person(2, 6.0, visible=0.55)]
    candidates = [
        candidate(3.1, 0.0, True),
        candidate(5.0, 0.1, False),
        candidate(6.0, 0.0, True),
        candidate(4.0, 2.0, True),
        candidate(7.0, 2.0, False),
        candidate(7.0, 3.0, False),
    ]
    found = score(monkeypatch, persons, candidates)
    assert found.counts["reasonable"] == DetectionCounts(tp=1, fp=1, fn=1, tn=2)
    assert found.counts["half_visible"] == DetectionCounts(tp=2, fp=1, fn=1, tn=2)
    assert [p.found for p in found.persons] == [True, False, True]
    assert found.errors == pytest.approx([0.1, 0.0])


def test_a_second_one_on_the_same_person_is_false(monkeypatch):
    twice = [candidate(3.1, 0.0, True, 0.9), candidate(2.9, 0.2, True, 0.8)]
    found = score(monkeypatch, [person(0, 3.0)], twice)
    assert found.counts["reasonable"] == DetectionCounts(tp=1, fp=1)


def test_beyond_the_gate_it_is_nobody(monkeypatch):
    found = score(monkeypatch, [person(0, 3.0)], [candidate(3.6, 0.0, True)])
    assert found.counts["reasonable"] == DetectionCounts(fp=1, fn=1)


def test_scores_add_up():
    one = DetectorScore(persons=[PersonOutcome(1, 3.0, 1.0, True)], errors=[0.1])
    one.counts = dict.fromkeys(STANDARDS, DetectionCounts(1, 2, 3, 4))
    both = one + one
    assert both.counts["reasonable"] == DetectionCounts(2, 4, 6, 8)
    assert len(both.persons) == len(both.errors) == 2


def test_bins():
    persons = [PersonOutcome(0, d, 1.0, d < 5.0) for d in (1.5, 2.9, 3.0, 6.0, 8.0, 8.1)]
    assert recall_by(persons, "distance", (1.5, 3.0, 5.0, 8.0)) == [
        (1.5, 3.0, 2, 1.0),
        (3.0, 5.0, 1, 1.0),
        (5.0, 8.0, 2, 0.0),
    ]
    assert math.isnan(recall_by([], "visible", (0.0, 1.0))[0][3])


@pytest.fixture(scope="module")
def report():
    return judge_detectors(SETTING, 4_200_000, 6, ["hog"], Workers())


def test_any_number_of_processes_gives_the_same(report):
    again = judge_detectors(SETTING, 4_200_000, 6, ["hog"], Workers(2))
    assert again.scores == report.scores


def test_what_is_written(report):
    markdown = as_markdown(report)
    assert "| hog |" in markdown
    assert "0.718" in markdown, "the paper's figures stand beside ours"
    values = as_values(report)["methods"]["hog"]
    assert values["counts"]["reasonable"]["tp"] == report.scores["hog"].counts["reasonable"].tp
    assert len(values["ms"]) == 6


def test_a_report_without_anybody_is_written():
    assert "| hog | - |" in as_markdown(DetectorReport(1, {"hog": DetectorScore()}, {"hog": [5.0]}))


def test_neither_does_what_was_judged_before(report):
    found = judge_batch(Batch(SETTING, range(4_200_000, 4_200_006), ("hog",)))
    assert found["hog"] == report.scores["hog"]
