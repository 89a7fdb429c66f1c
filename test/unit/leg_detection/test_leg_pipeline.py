"""The whole detector on exact worlds, and on the recordings."""

import numpy as np
import pytest
from leg_world import look, walk
from safe_passage.core.errors import ParameterError
from safe_passage.leg_detection.classifiers import train
from safe_passage.leg_detection.parameters import LegDetectorParameters
from safe_passage.leg_detection.pipeline import LegDetector
from safe_passage.leg_detection.scan import Scan
from safe_passage.leg_detection.segmentation import SegmentationParameters
from safe_passage.leg_detection.training_data import from_recording, joined

P = SegmentationParameters()


@pytest.fixture(scope="module")
def model():
    return train(
        "random_forest", joined(from_recording(walk(f"{i}", i)[0], P) for i in range(4)), P
    )


@pytest.fixture
def detector(model):
    return LegDetector(model, LegDetectorParameters())


def test_a_person_is_found_between_the_legs(detector):
    recording, _ = walk("new", seed=11)
    hits = 0
    for scan, legs in zip(recording.scans, recording.legs):
        persons = detector.detect(scan).persons
        away = [np.linalg.norm(legs.mean(axis=0) - person.position) for person in persons]
        hits += min(away, default=9.0) < 0.2
    assert hits >= 0.8 * len(recording.scans)


def test_an_empty_room_has_nobody(detector):
    for i in range(5):
        found = detector.detect(look([], stamp=0.1 * i).scan)
        assert found.persons == found.legs == []


@pytest.mark.parametrize("ranges", [[], [np.nan], [np.inf] * 9, [0.0] * 9, [1.0, np.nan, 2.0]])
def test_nothing_to_classify_is_nobody(detector, ranges):
    scan = Scan(np.array(ranges, float), 0.0, 0.01, 0.05, 10.0)
    assert detector.detect(scan).persons == []


def test_the_threshold_decides(model):
    scan = look([(1.5, -0.15), (1.5, 0.15)]).scan
    everything = LegDetector(model, LegDetectorParameters(leg_threshold=0.0)).detect(scan)
    assert len(everything.legs) == 5  # two legs, and the wall in three pieces
    surest = LegDetector(model, LegDetectorParameters(leg_threshold=1.0)).detect(scan)
    assert len(surest.legs) <= 2


def test_small_segments_are_not_classified():
    class Spy:
        segmentation = P

        def probabilities(self, features):
            assert features[:, 0].tolist() == [3, 5]
            return np.array([0.0, 1.0])

    ranges = np.repeat([3.0, 1.0, 4.0, 2.0, 5.0], [2, 3, 1, 5, 2])
    found = LegDetector(Spy(), LegDetectorParameters()).detect(Scan(ranges, 0.0, 0.01))
    (leg,) = found.legs
    assert np.hypot(*leg.position) == pytest.approx(2.0, abs=0.01)


def test_forgets_the_last_scan(model):
    """After a reset the speed of a segment is unknown again."""
    speeds = []

    class Spy:
        segmentation = P

        def probabilities(self, features):
            speeds.append(np.abs(features[:, 13]).max())
            return np.zeros(len(features))

    detector = LegDetector(Spy(), LegDetectorParameters())
    for i in range(3):
        if i == 2:
            detector.reset()
        detector.detect(look([(2.0 - 0.1 * i, 0.0)], stamp=0.1 * i).scan)
    assert speeds[0] == speeds[2] == 0.0
    assert speeds[1] > 0.5


@pytest.mark.parametrize(
    ("name", "value"),
    [("leg_threshold", 1.1), ("max_leg_distance", -0.1), ("lone_legs", 1)],
)
def test_parameters_are_checked(name, value):
    with pytest.raises(ParameterError, match=name):
        LegDetectorParameters(**{name: value})
