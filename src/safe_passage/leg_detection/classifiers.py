"""The paper's three classifiers of segments, and the files that they are kept in.

Paper 002, section 3.1: AdaBoost, SVM, random forest with 15 trees of depth 10.
"""

from __future__ import annotations

import dataclasses
import io
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import joblib
import numpy as np
import sklearn
from sklearn.ensemble import AdaBoostClassifier, RandomForestClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import QuantileTransformer
from sklearn.svm import SVC
from sklearn.tree import DecisionTreeClassifier

from safe_passage.core.errors import InputError, ParameterError
from safe_passage.core.parameters import check_choice, from_mapping
from safe_passage.leg_detection.features import FEATURE_NAMES
from safe_passage.leg_detection.segmentation import SegmentationParameters
from safe_passage.leg_detection.training_data import LEG, OTHER, LabelledSegments

CLASSIFIERS = ("adaboost", "svm", "random_forest")
SEED = 1
LEG_WEIGHT = 0.2  # of all weight in training: more finds more legs, and more that are none
MAX_OTHERS = 20_000  # of more, an even choice: scans repeat each other, and an SVM's time is square
FORMAT = "safe_passage leg model 1"


@dataclass(frozen=True)
class LegModel:
    """A trained classifier, and the segmentation that it is good for."""

    name: str  # one of CLASSIFIERS
    estimator: Any  # of scikit-learn
    segmentation: SegmentationParameters
    trained_on: str = ""  # for people to read

    def probabilities(self, features: np.ndarray) -> np.ndarray:
        """How sure it is (K,) that a segment is a leg, 0 to 1, of `features` (K, 14).

        0.5 is the classifier's own boundary. AdaBoost and SVM have no probabilities: theirs are
        the logistic function of twice the margin, as scikit-learn's AdaBoost has it.
        """
        if not len(features):
            return np.zeros(0)
        if self.name == "svm":
            return 1.0 / (1.0 + np.exp(-2.0 * self.estimator.decision_function(features)))
        return self.estimator.predict_proba(features)[:, 1]


def train(
    name: str,
    segments: LabelledSegments,
    segmentation: SegmentationParameters,
    trained_on: str = "",
) -> LegModel:
    """Train classifier `name` on the segments whose label is known; the same data, the same model.

    Legs are few among segments, and how few differs from room to room: whatever their number, they
    get LEG_WEIGHT.

    Raises:
        ParameterError: there is no such classifier.
        InputError: the segments are all legs, or none is.
    """
    known = _thinned(segments.known)
    legs = known.labels == LEG
    if legs.all() or not legs.any():
        raise InputError(
            f"{legs.sum()} legs and {(~legs).sum()} other segments: training needs both"
        )
    weights = np.where(legs, LEG_WEIGHT / legs.mean(), (1.0 - LEG_WEIGHT) / (1.0 - legs.mean()))
    estimator = _make(name)
    step = f"{estimator.steps[-1][0]}__" if hasattr(estimator, "steps") else ""
    estimator.fit(known.features, legs.astype(int), **{f"{step}sample_weight": weights})
    return LegModel(name, estimator, segmentation, trained_on)


def save(model: LegModel, path: Path) -> None:
    """Write a line of JSON that says what the model needs, then the estimator as joblib has it."""
    header = {
        "format": FORMAT,
        "classifier": model.name,
        "scikit_learn": sklearn.__version__,
        "features": FEATURE_NAMES,
        "segmentation": dataclasses.asdict(model.segmentation),
        "trained_on": model.trained_on,
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as file:
        file.write(json.dumps(header).encode() + b"\n")
        joblib.dump(model.estimator, file)


def load(path: Path) -> LegModel:
    """Read a model. The estimator is a pickle, which can run code: load only files you trust.

    Raises:
        InputError: no such file, not a model, or one made for other features or another
            scikit-learn. That is checked before anything is unpickled.
    """
    try:
        first, _, estimator = path.read_bytes().partition(b"\n")
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    name, segmentation, trained_on = _checked(first, path)
    try:
        loaded = joblib.load(io.BytesIO(estimator))
    except Exception as error:  # a pickle that is cut off can raise anything
        raise InputError(f"{path}: its estimator cannot be read: {error}") from None
    return LegModel(name, loaded, segmentation, trained_on)


def _thinned(known: LabelledSegments) -> LabelledSegments:
    """All legs and at most MAX_OTHERS others, from all over the recordings."""
    others = np.flatnonzero(known.labels == OTHER)
    chosen = known.labels == LEG
    kept = np.linspace(0, len(others), min(len(others), MAX_OTHERS), endpoint=False).astype(int)
    chosen[others[kept]] = True
    return known.where(chosen)


def _make(name: str) -> Any:
    check_choice("classifier", name, CLASSIFIERS)
    if name == "adaboost":  # by position: the argument's name differs between versions
        return AdaBoostClassifier(
            DecisionTreeClassifier(max_depth=2), n_estimators=100, random_state=SEED
        )
    if name == "svm":  # metres, radians and counts with long tails: ranks scale them all alike
        return make_pipeline(QuantileTransformer(n_quantiles=100, random_state=SEED), SVC())
    return RandomForestClassifier(n_estimators=15, max_depth=10, random_state=SEED)


def _checked(line: bytes, path: Path) -> tuple[str, SegmentationParameters, str]:
    """Classifier, segmentation and origin of a model, if it can be used here."""
    try:
        header = json.loads(line)
        known = header["format"] == FORMAT
        features, made_by = tuple(header["features"]), str(header["scikit_learn"])
        trained_on = str(header["trained_on"])
        check_choice("classifier", header["classifier"], CLASSIFIERS)
        segmentation = from_mapping(SegmentationParameters, header["segmentation"], "segmentation")
    except ParameterError as error:
        raise InputError(f"{path}: {error}") from None
    except (ValueError, KeyError, TypeError):
        known = False
    if not known:
        raise InputError(f"{path}: is no leg model, or one of another format")
    if features != FEATURE_NAMES:
        raise InputError(
            f"{path}: was trained on the features {', '.join(features)}; "
            f"here are {', '.join(FEATURE_NAMES)}"
        )
    if _minor(made_by) != _minor(sklearn.__version__):
        raise InputError(
            f"{path}: was made by scikit-learn {made_by}, here is {sklearn.__version__}: "
            "train it anew"
        )
    return header["classifier"], segmentation, trained_on


def _minor(version: str) -> list[str]:
    """Major and minor number: estimators may change with either."""
    return version.split(".")[:2]
