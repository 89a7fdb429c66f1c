"""Table 3 of paper 002 as a report: drawn or recorded views, methods beside the paper's figures."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Sequence

import numpy as np

from safe_passage.evaluation.dataset import Dataset
from safe_passage.evaluation.detection_metrics import DetectionCounts
from safe_passage.evaluation.detector_table import (
    STANDARDS,
    DetectorScore,
    recall_by,
    score_view,
    time_views,
)
from safe_passage.evaluation.human_safety_chain import make_detector
from safe_passage.evaluation.parallel import Workers, batches, run_jobs
from safe_passage.evaluation.report import table
from safe_passage.evaluation.setting import Setting
from safe_passage.evaluation.views import View, ViewSampler
from safe_passage.simulation.robots import CameraModel

FIRST_VIEW = 1_000_000  # unless another is given: none of those that the detector was tuned on
TIMED_VIEWS = 50
FIGURES = ("accuracy", "precision", "recall", "f1", "fp_rate")
PAPER = {  # table 3: accuracy, precision, recall, F1, FP rate, ms, Hz; on the CPU and with a GPU
    "hog": {
        "CPU": (0.718, 0.664, 0.619, 0.640, 0.154, 39.0, 18.82),
        "GPU": (0.741, 0.761, 0.672, 0.713, 0.136, 21.0, 34.57),
    },
    "yolo": {
        "CPU": (0.966, 0.906, 0.813, 0.856, 0.021, 1961.0, 5.29),
        "GPU": (0.974, 0.912, 0.830, 0.869, 0.018, 8.0, 53.80),
    },
}
DISTANCES = (1.5, 3.0, 4.5, 6.0, 8.0)  # [m] edges of the bins
VISIBLE = (0.0, 0.25, 0.5, 0.65, 0.8, 1.0)


@dataclass(frozen=True)
class Batch:
    """Views to be judged."""

    source: Setting | Path
    numbers: range
    methods: tuple[str, ...]


@dataclass(frozen=True)
class DetectorReport:
    """What each method made of the same views."""

    views: int
    scores: dict[str, DetectorScore]
    milliseconds: dict[str, list[float]]  # a view, with nothing else running


class Views:
    """Views by number, drawn or from a folder."""

    def __init__(self, source: Setting | Path) -> None:
        self._sampler = ViewSampler(*source.load()) if isinstance(source, Setting) else None
        self._folder = Dataset(source) if isinstance(source, Path) else None
        self.camera: CameraModel = (self._sampler or self._folder).camera  # type: ignore[union-attr]

    def __getitem__(self, number: int) -> View:
        if self._folder is not None:
            return self._folder[number]
        assert self._sampler is not None
        return self._sampler.draw(number)

    def close(self) -> None:
        """Free what draws."""
        if self._sampler is not None:
            self._sampler.close()


def judge_detectors(
    source: Setting | Path, first: int, count: int, methods: Sequence[str], workers: Workers
) -> DetectorReport:
    """Scores of all views, then times of some of them, here and one after the other."""
    jobs = [Batch(source, numbers, tuple(methods)) for numbers in batches(first, count)]
    scores = {method: DetectorScore() for method in methods}
    for part in run_jobs(judge_batch, jobs, workers, "views"):
        for method, score in part.items():
            scores[method] += score
    views = Views(source)
    try:
        timed = [views[first + i] for i in range(min(count, TIMED_VIEWS))]
    finally:
        views.close()
    times = {method: time_views(make_detector(method), timed, views.camera) for method in methods}
    return DetectorReport(count, scores, times)


def judge_batch(batch: Batch) -> dict[str, DetectorScore]:
    """Score by method."""
    detectors = {method: make_detector(method) for method in batch.methods}
    scores = {method: DetectorScore() for method in batch.methods}
    views = Views(batch.source)
    try:
        for number in batch.numbers:
            view = views[number]
            for method, detector in detectors.items():
                scores[method] += score_view(detector, view, views.camera, number)
    finally:
        views.close()
    return scores


def as_markdown(report: DetectorReport) -> str:
    """Table 3 and what lies behind it."""
    reasonable, half = STANDARDS["reasonable"], STANDARDS["half_visible"]
    header = ("method", *FIGURES, "ms", "Hz")
    rows = []
    for method, score in report.scores.items():
        ms = float(np.median(report.milliseconds[method]))
        rows.append((method, *_figures(score.counts["reasonable"]), ms, 1e3 / ms))
        for machine, figures in PAPER[method].items():
            rows.append((f"the paper's {method}, {machine}", *figures))
    halves = [(m, *_figures(s.counts["half_visible"])) for m, s in report.scores.items()]
    errors = [(m, float(np.median(s.errors))) for m, s in report.scores.items() if s.errors]
    return "\n\n".join(
        [
            f"# Person detector on {report.views} views",
            f"Persons who must be found: {reasonable.nearest} to {reasonable.farthest} m away, "
            f"{reasonable.height:.0f} px tall or more, {100 * reasonable.visible:.0f} % visible or "
            "more (Caltech pedestrian benchmark, reasonable). Others may be found or missed.",
            table(header, rows),
            f"With {100 * half.visible:.0f} % visible or more:",
            table(("method", *FIGURES), halves),
            "Recall by distance [m] of who is reasonable, and by visible share of everybody:",
            *(_bins(report, key, edges) for key, edges in _binned()),
            "Median error of a found person's place [m]:",
            table(("method", "error"), errors),
        ]
    )


def as_values(report: DetectorReport) -> dict:
    """The same for JSON, with every person."""
    return {
        "views": report.views,
        "methods": {
            method: {
                "counts": {name: asdict(counts) for name, counts in score.counts.items()},
                "figures": {
                    name: dict(zip(FIGURES, _figures(counts)))
                    for name, counts in score.counts.items()
                },
                "ms": report.milliseconds[method],
                "persons": [asdict(person) for person in score.persons],
            }
            for method, score in report.scores.items()
        },
    }


def binned_recall(score: DetectorScore, key: str, edges: Sequence[float]) -> list[tuple]:
    """By distance: of those visible enough, so that hidden ones do not hide its effect."""
    least = STANDARDS["reasonable"].visible if key == "distance" else 0.0
    return recall_by([p for p in score.persons if p.visible >= least], key, edges)


def _binned() -> tuple[tuple[str, tuple[float, ...]], ...]:
    return ("distance", DISTANCES), ("visible", VISIBLE)


def _bins(report: DetectorReport, key: str, edges: Sequence[float]) -> str:
    found = {m: binned_recall(score, key, edges) for m, score in report.scores.items()}
    first = next(iter(found.values()))
    header = (key, "persons", *found)
    rows = [
        (f"{low:g} to {high:g}", persons, *(found[m][i][3] for m in found))
        for i, (low, high, persons, _) in enumerate(first)
    ]
    return table(header, rows)


def _figures(counts: DetectionCounts) -> tuple[float, ...]:
    return tuple(getattr(counts, name) for name in FIGURES)
