"""The classifiers learn, repeat themselves, and come back from their files or say why not."""

import json
import shutil

import numpy as np
import pytest
import safe_passage.leg_detection.classifiers as classifiers
from leg_world import walk
from safe_passage.core.errors import InputError, ParameterError
from safe_passage.leg_detection.classifiers import CLASSIFIERS, load, save, train
from safe_passage.leg_detection.segmentation import SegmentationParameters
from safe_passage.leg_detection.training_data import (
    LEG,
    UNKNOWN,
    LabelledSegments,
    from_recording,
    joined,
)

P = SegmentationParameters(jump_distance=0.11)


@pytest.fixture(scope="module")
def segments():
    return joined(from_recording(walk(f"walk {i}", seed=i)[0], P) for i in range(3))


@pytest.fixture(scope="module", params=CLASSIFIERS)
def model(request, segments):
    return train(request.param, segments, P, "walks 0 to 2")


def test_learns_what_it_was_shown_and_more(model, segments):
    for shown in (segments.known, from_recording(walk("new", seed=9)[0], P).known):
        found = model.probabilities(shown.features) >= 0.5
        assert (found == (shown.labels == LEG)).mean() > 0.95


def test_the_boundary_is_the_classifiers_own(model, segments):
    verdicts = model.estimator.predict(segments.features) == 1
    assert ((model.probabilities(segments.features) > 0.5) == verdicts).all()


def test_probabilities_lie_between_0_and_1(model, segments):
    strange = np.concatenate([segments.features, 1e6 * segments.features, 0 * segments.features])
    found = model.probabilities(strange)
    assert found.min() >= 0.0
    assert found.max() <= 1.0
    assert model.probabilities(np.zeros((0, 14))).shape == (0,)


def test_the_same_data_make_the_same_model(model, segments):
    again = train(model.name, segments, P)
    expected = model.probabilities(segments.features)
    assert np.array_equal(again.probabilities(segments.features), expected)


def test_unknown_segments_are_not_learnt(segments):
    unsure = LabelledSegments(segments.features, segments.labels.copy(), segments.groups)
    unsure.labels[::3] = UNKNOWN
    expected = train("random_forest", unsure.known, P).probabilities(segments.features)
    found = train("random_forest", unsure, P).probabilities(segments.features)
    assert np.array_equal(found, expected)


def test_many_others_are_thinned_evenly_and_no_leg_is_lost(segments, monkeypatch):
    learnt = []

    class Spy:
        def fit(self, features, labels, sample_weight):
            learnt.append((features, labels, sample_weight))

    monkeypatch.setattr(classifiers, "MAX_OTHERS", 100)
    monkeypatch.setattr(classifiers, "_make", lambda name: Spy())
    train("svm", segments, P)
    features, labels, weights = learnt[0]
    assert labels.sum() == segments.count(LEG)
    assert (labels == 0).sum() == 100
    assert weights[labels == 1].sum() / weights.sum() == pytest.approx(classifiers.LEG_WEIGHT)
    others = segments.features[segments.labels == 0]
    assert np.array_equal(features[labels == 0][1], others[len(others) // 100])


def test_comes_back_from_its_file(model, segments, tmp_path):
    file = tmp_path / "new folder" / "legs.model"
    save(model, file)
    found = load(file)
    assert (found.name, found.segmentation) == (model.name, P)
    assert found.trained_on == "walks 0 to 2"
    expected = model.probabilities(segments.features)
    assert np.array_equal(found.probabilities(segments.features), expected)


def test_the_forest_is_the_papers(segments):
    forest = train("random_forest", segments, P).estimator
    assert len(forest.estimators_) == 15
    assert forest.max_depth == 10


def test_a_classifier_that_is_not_known_is_named(segments):
    with pytest.raises(ParameterError, match="classifier is 'knn', must be one of adaboost, svm"):
        train("knn", segments, P)


def test_training_needs_both_kinds(segments):
    for label in (0, 1):
        with pytest.raises(InputError, match="training needs both"):
            train("svm", segments.where(segments.labels == label), P)
    with pytest.raises(InputError, match="0 legs and 0 other"):
        train("svm", joined([]), P)


@pytest.fixture(scope="module")
def saved(segments, tmp_path_factory):
    file = tmp_path_factory.mktemp("models") / "legs.model"
    save(train("random_forest", segments, P), file)
    return file


@pytest.fixture
def copy(saved, tmp_path):
    return shutil.copy(saved, tmp_path / "legs.model")


def change(file, **header):
    first, _, rest = file.read_bytes().partition(b"\n")
    file.write_bytes(json.dumps({**json.loads(first), **header}).encode() + b"\n" + rest)


def test_its_first_line_is_for_people(saved):
    header = json.loads(saved.read_bytes().partition(b"\n")[0])
    assert header["classifier"] == "random_forest"
    assert header["segmentation"] == {
        "jump_distance": 0.11, "min_points": 3, "max_scan_gap": 0.5
    }  # fmt: skip


@pytest.mark.parametrize(
    ("header", "complaint"),
    [
        ({"format": "safe_passage leg model 0"}, "is no leg model, or one of another format"),
        ({"features": ["width", "mean_speed"]}, "trained on the features width, mean_speed; here"),
        ({"scikit_learn": "0.22.2"}, "was made by scikit-learn 0.22.2, here is .*train it anew"),
        ({"segmentation": {"jump": 0.1}}, "segmentation/jump is not known"),
        ({"segmentation": {"jump_distance": -0.1}}, "jump_distance is -0.1"),
        ({"segmentation": 7}, "is no leg model"),
        ({"classifier": "knn"}, "classifier is 'knn'"),
    ],
)
def test_a_model_for_something_else_is_refused_unread(copy, monkeypatch, header, complaint):
    monkeypatch.setattr(classifiers.joblib, "load", lambda file: pytest.fail("was unpickled"))
    change(copy, **header)
    with pytest.raises(InputError, match=complaint):
        load(copy)


def test_a_model_without_all_of_its_header_is_refused(copy):
    first, _, rest = copy.read_bytes().partition(b"\n")
    for name in json.loads(first):
        header = {key: value for key, value in json.loads(first).items() if key != name}
        copy.write_bytes(json.dumps(header).encode() + b"\n" + rest)
        with pytest.raises(InputError, match="is no leg model"):
            load(copy)


def test_a_bugfix_release_of_scikit_learn_is_no_other(copy):
    change(copy, scikit_learn=".".join([*classifiers.sklearn.__version__.split(".")[:2], "99"]))
    assert load(copy).name == "random_forest"


@pytest.mark.parametrize("content", [b"", b"\n", b"{}\n", b"[1]\n", b"7\n", b"\x80\x04K\x01.\n"])
def test_a_file_that_is_no_model_is_refused(tmp_path, content):
    file = tmp_path / "legs.model"
    file.write_bytes(content)
    with pytest.raises(InputError, match="legs.model: is no leg model"):
        load(file)


def test_a_file_cut_off_is_refused(copy):
    copy.write_bytes(copy.read_bytes()[:-1000])
    with pytest.raises(InputError, match="its estimator cannot be read"):
        load(copy)


def test_no_file_and_a_folder_are_refused(tmp_path):
    with pytest.raises(InputError, match="none.model: No such file"):
        load(tmp_path / "none.model")
    with pytest.raises(InputError, match="directory"):
        load(tmp_path)
