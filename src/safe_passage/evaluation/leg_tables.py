"""Tables 1 and 2 of paper 002: person classifiers on 2D laser scans, segment by segment.

Table 1 is of real scans: each recording is judged by a model that was trained on the others.
Table 2 is of a warehouse: given models judge scans of which the truth is known beam by beam.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Callable, Mapping, Sequence

import numpy as np

from safe_passage.core.errors import InputError
from safe_passage.evaluation.detection_metrics import DetectionCounts
from safe_passage.leg_detection.classifiers import CLASSIFIERS, LegModel, train
from safe_passage.leg_detection.parameters import LegDetectorParameters
from safe_passage.leg_detection.pipeline import LegDetector
from safe_passage.leg_detection.scan import Scan
from safe_passage.leg_detection.segmentation import SegmentationParameters
from safe_passage.leg_detection.training_data import (
    LEG,
    LabelledScan,
    LabelledSegments,
    from_labelled_scans,
)

PAPER_LEG_SHARE = 0.12  # of table 1's segments, from its accuracy, recall and FP rate
WARM_UP = 5  # scans
Progress = Callable[[str], None]


@dataclass(frozen=True)
class LegRow:
    """One line of either table."""

    classifier: str
    counts: DetectionCounts  # of segments
    ms: float  # median time from a scan to its persons; NaN: not measured

    @property
    def hz(self) -> float:
        """Scans a second."""
        return 1e3 / self.ms


def table_1(
    segments: LabelledSegments,
    scans: Sequence[Scan],
    segmentation: SegmentationParameters,
    classifiers: Sequence[str] = CLASSIFIERS,
    progress: Progress = lambda text: None,
) -> list[LegRow]:
    """Classifiers on real scans, by leave-one-group-out cross-validation.

    Args:
        segments: labelled, of two groups at least: recordings, or stretches of one.
        scans: for the time a scan takes, in order; empty: not measured.
        progress: is told what is done.
    """
    rows = []
    for name in classifiers:
        progress(f"{name}: {len(np.unique(segments.known.groups))} models to train and judge")
        counts = cross_validate(name, segments, segmentation)
        rows.append(LegRow(name, counts, scan_ms(train(name, segments, segmentation), scans)))
    return rows


def table_2(models: Mapping[str, LegModel], runs: Sequence[Sequence[LabelledScan]]) -> list[LegRow]:
    """Trained models on a warehouse's scans; figures are of all runs together.

    Args:
        models: name to print -> model.
        runs: scans of one scanner in order of time, run by run. A leg that is hidden in a larger
            segment is one to be found (`from_labelled_scans`); one of fewer beams than the model
            classifies is not a candidate and is not counted.
    """
    rows = []
    for name, model in models.items():
        judged = [
            judge(model, from_labelled_scans(run, model.segmentation, name, judging=True))
            for run in runs
        ]
        counts = sum(judged, DetectionCounts())
        rows.append(LegRow(name, counts, scan_ms(model, [one.scan for run in runs for one in run])))
    return rows


def cross_validate(
    name: str, segments: LabelledSegments, segmentation: SegmentationParameters
) -> DetectionCounts:
    """Every group judged by classifier `name`, trained on all the others.

    Raises:
        InputError: the legs are all of one group.
    """
    known, counts = segments.known, DetectionCounts()
    if len(np.unique(known.groups[known.labels == LEG])) < 2:
        raise InputError("legs of one recording alone: cross-validation needs two at least")
    for group in np.unique(known.groups):
        held_out = known.groups == group
        model = train(name, known.where(~held_out), segmentation)
        counts += judge(model, known.where(held_out))
    return counts


def judge(model: LegModel, segments: LabelledSegments) -> DetectionCounts:
    """Verdicts on the segments whose label is known."""
    known = segments.known
    return DetectionCounts.of(known.labels == LEG, model.probabilities(known.features) >= 0.5)


def scan_ms(model: LegModel, scans: Sequence[Scan]) -> float:
    """Median time [ms] of the whole detector on a scan; NaN without scans."""
    detector, times = LegDetector(model, LegDetectorParameters()), []
    warm_up = scans[:WARM_UP]
    for scan in [*warm_up, *scans]:
        start = time.perf_counter()
        detector.detect(scan)
        times.append(time.perf_counter() - start)
    return 1e3 * float(np.median(times[len(warm_up) :])) if scans else float("nan")


def as_markdown(rows: Sequence[LegRow]) -> str:
    """The table as the paper prints it, with the times."""
    lines = [
        "| Method | Accuracy | Precision | Recall | F1 | FP rate | ms | Hz |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        of = row.counts
        figures = (of.accuracy, of.precision, of.recall, of.f1, of.fp_rate)
        shown = " | ".join(f"{figure:.3f}" for figure in figures)
        lines.append(f"| {row.classifier} | {shown} | {row.ms:.2f} | {row.hz:.0f} |")
    return "\n".join(lines)
