"""The leg detector: a scan in, legs and persons out."""

from __future__ import annotations

from dataclasses import dataclass

from safe_passage.leg_detection.classifiers import LegModel
from safe_passage.leg_detection.features import beam_speeds, segment_features
from safe_passage.leg_detection.parameters import LegDetectorParameters
from safe_passage.leg_detection.persons import Leg, LegPerson, pair_legs
from safe_passage.leg_detection.scan import Scan
from safe_passage.leg_detection.segmentation import segment


@dataclass(frozen=True)
class LegDetection:
    """What one scan shows."""

    legs: list[Leg]
    persons: list[LegPerson]


class LegDetector:
    """The papers' baseline: persons from a 2D laser scan alone.

    It remembers the last scan, for the speeds of the next one's segments.
    """

    def __init__(self, model: LegModel, parameters: LegDetectorParameters) -> None:
        self._model, self._p = model, parameters
        self._before: Scan | None = None

    def detect(self, scan: Scan) -> LegDetection:
        """Scan -> segments -> features -> probabilities -> legs -> persons."""
        shape = self._model.segmentation
        segments = segment(scan, shape.jump_distance)
        speeds = beam_speeds(scan, self._before, shape.max_scan_gap)
        features = segment_features(segments, speeds)
        large = segments.sizes >= shape.min_points
        probabilities = self._model.probabilities(features[large])
        legs = [
            Leg((float(x), float(y)), float(probability))
            for (x, y), probability in zip(segments.centres()[large], probabilities)
            if probability >= self._p.leg_threshold
        ]
        self._before = scan
        return LegDetection(legs, pair_legs(legs, self._p.max_leg_distance, self._p.lone_legs))

    def reset(self) -> None:
        """Forget the last scan."""
        self._before = None
