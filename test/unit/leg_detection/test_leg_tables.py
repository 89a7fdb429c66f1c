"""The tables' figures, against worked examples and scikit-learn; nobody is judged by itself."""

import math

import numpy as np
import pytest
import safe_passage.evaluation.leg_tables as leg_tables
from hypothesis import given
from hypothesis import strategies as st
from leg_world import look, walk
from safe_passage.core.errors import InputError
from safe_passage.evaluation.detection_metrics import DetectionCounts
from safe_passage.evaluation.leg_tables import (
    LegRow,
    as_markdown,
    cross_validate,
    judge,
    table_1,
    table_2,
)
from safe_passage.leg_detection.classifiers import train
from safe_passage.leg_detection.segmentation import SegmentationParameters
from safe_passage.leg_detection.training_data import (
    LEG,
    OTHER,
    UNKNOWN,
    LabelledSegments,
    from_recording,
    joined,
)
from sklearn import metrics

P = SegmentationParameters()


@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1))
def test_counts_are_scikit_learns(pairs):
    truth, accepted = np.array(pairs, dtype=bool).T
    counts = DetectionCounts.of(truth, accepted)
    matrix = metrics.confusion_matrix(truth, accepted, labels=[False, True])
    assert [[counts.tn, counts.fp], [counts.fn, counts.tp]] == matrix.tolist()
    assert counts.accuracy == pytest.approx(metrics.accuracy_score(truth, accepted))
    for ours, theirs in (
        (counts.precision, metrics.precision_score),
        (counts.recall, metrics.recall_score),
        (counts.f1, metrics.f1_score),
    ):
        if not math.isnan(ours):
            assert ours == pytest.approx(theirs(truth, accepted, zero_division=0))
    assert counts.person_share == pytest.approx(truth.mean())


def test_f1_at_another_share_of_persons():
    counts = DetectionCounts(tp=8, fp=9, fn=2, tn=81)  # recall 0.8, FP rate 0.1, share 0.1
    assert counts.f1_at(counts.person_share) == pytest.approx(counts.f1)
    # one half persons: of 100, 40 are found, 10 missed, 5 false
    assert counts.f1_at(0.5) == pytest.approx(DetectionCounts(40, 5, 10, 45).f1)
    assert math.isnan(DetectionCounts(tp=3).f1_at(0.5))


@pytest.mark.parametrize(
    ("accuracy", "precision", "recall", "f1", "fp_rate"),
    [(0.969, 0.895, 0.846, 0.870, 0.014), (0.962, 0.906, 0.766, 0.830, 0.011)],
)
def test_the_papers_table_1_has_the_share_of_legs_that_we_compare_at(
    accuracy, precision, recall, f1, fp_rate
):
    """Counts made from its recall, its FP rate and that share give its other figures."""
    legs, others = 120_000, 880_000
    assert legs / (legs + others) == leg_tables.PAPER_LEG_SHARE
    tp, fp = round(recall * legs), round(fp_rate * others)
    counts = DetectionCounts(tp, fp, legs - tp, others - fp)
    assert counts.accuracy == pytest.approx(accuracy, abs=0.002)
    assert counts.precision == pytest.approx(precision, abs=0.006)
    assert counts.f1 == pytest.approx(f1, abs=0.002)


@pytest.fixture(scope="module")
def walks():
    return [from_recording(walk(f"walk {seed}", seed)[0], P) for seed in range(3)]


@pytest.fixture(scope="module")
def model(walks):
    return train("random_forest", joined(walks), P)


class Oracle:
    """Says leg to all segments of at most so many points."""

    segmentation = P

    def __init__(self, most):
        self._most = most

    def probabilities(self, features):
        return (features[:, 0] <= self._most).astype(float)


def made(sizes, labels, group="a"):
    features = np.zeros((len(sizes), 14))
    features[:, 0] = sizes
    return LabelledSegments(features, np.array(labels), np.full(len(sizes), group))


def test_unknown_segments_are_not_judged():
    segments = made([5, 5, 50, 50, 5], [LEG, OTHER, LEG, OTHER, UNKNOWN])
    assert judge(Oracle(10), segments) == DetectionCounts(tp=1, fp=1, fn=1, tn=1)


def test_each_group_is_judged_once_by_a_model_of_the_others(monkeypatch):
    groups = {"a": made([1], [LEG], "a"), "b": made([2], [OTHER], "b"), "c": made([3], [LEG], "c")}
    seen = []

    def spy(name, segments, segmentation):
        seen.append(sorted(segments.groups))
        return Oracle(10)

    monkeypatch.setattr(leg_tables, "train", spy)
    assert cross_validate("svm", joined(groups.values()), P) == DetectionCounts(tp=2, fp=1)
    assert seen == [["b", "c"], ["a", "c"], ["a", "b"]]


def test_one_recording_cannot_judge_itself():
    alone = joined([made([1, 2], [LEG, OTHER], "a"), made([3], [OTHER], "b")])
    with pytest.raises(InputError, match="legs of one recording alone"):
        cross_validate("svm", alone, P)


def test_table_1_of_easy_walks(walks):
    said = []
    scans = walk("timed", 7)[0].scans[:10]
    rows = table_1(joined(walks), scans, P, progress=said.append)
    assert [row.classifier for row in rows] == ["adaboost", "svm", "random_forest"]
    assert said[0] == "adaboost: 3 models to train and judge"
    for row in rows:
        assert row.counts.f1 > 0.9
        assert row.hz == pytest.approx(1e3 / row.ms)
        assert 0.0 < row.ms < 1e3


def test_table_2_takes_all_runs_together(model):
    runs = [walk("run", seed)[1] for seed in (20, 21)]
    (both,) = table_2({"forest": model}, runs)
    first, second = (table_2({"forest": model}, [run])[0] for run in runs)
    assert both.counts == first.counts + second.counts
    assert both.classifier == "forest"
    assert both.counts.recall > 0.8


def test_a_leg_before_a_wall_is_missed_not_ignored():
    """One segment of wall and leg, as a long jump distance makes it: rejected, so missed."""
    parameters = SegmentationParameters(jump_distance=1.0)

    class Rejects:
        segmentation = parameters

        def probabilities(self, features):
            return np.zeros(len(features))

    (row,) = table_2({"none": Rejects()}, [[look([(2.9, 0.0)])]])
    assert row.counts == DetectionCounts(fn=1)
    assert row.ms > 0.0


def test_nobody_and_nothing(model):
    (row,) = table_2({"forest": model}, [[look([])]])
    assert row.counts.tp == row.counts.fn == 0
    (row,) = table_2({"forest": model}, [])
    assert row.counts == DetectionCounts()
    assert math.isnan(row.ms)


def test_markdown_is_the_papers_table():
    text = as_markdown([LegRow("svm", DetectionCounts(tp=8, fp=2, fn=4, tn=6), 4.0)])
    assert text.splitlines()[0] == (
        "| Method | Accuracy | Precision | Recall | F1 | FP rate | ms | Hz |"
    )
    assert text.splitlines()[2] == ("| svm | 0.700 | 0.800 | 0.667 | 0.727 | 0.250 | 4.00 | 250 |")
