"""Benchmark of the 2D laser person classifiers: table 1 of paper 002 on the recordings of legs."""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path

import numpy as np
from safe_passage.evaluation.leg_report import Recordings
from safe_passage.evaluation.leg_tables import PAPER_LEG_SHARE, LegRow, cross_validate, table_1
from safe_passage.evaluation.parallel import Workers, run_jobs
from safe_passage.leg_detection.classifiers import CLASSIFIERS
from safe_passage.leg_detection.scan import Scan
from safe_passage.leg_detection.segmentation import SegmentationParameters
from safe_passage.leg_detection.training_data import LabelledSegments
from safe_passage.ros.train_leg_detector import read_bags

from bench.metric import metric

FIGURES = ("f1", "precision", "recall", "accuracy", "fp_rate")
# The positive recordings were made at two places: numbers 1 to 4 at one, 6 and 7 at the other. What
# the negative one shows is not told: one half of it goes with either.
OTHER_PLACE = ("positive_6", "positive_7", "negative_2 4", "negative_2 5", "negative_2 6")


def run(quick: bool = False) -> list[dict]:
    """All rows; without the recordings every value is None."""
    return rows(read_recordings(quick), quick)


def rows(recordings: Recordings | None, quick: bool) -> list[dict]:
    """The rows of recordings that were read; each classifier in a process of its own."""
    if recordings is None:
        found: list[tuple[LegRow | None, float | None]] = [(None, None) for _ in CLASSIFIERS]
    else:
        segments, scans = recordings
        folds = in_three(segments) if quick else segments
        jobs = [(name, folds, segments, scans[:100]) for name in CLASSIFIERS]
        workers = Workers(os.cpu_count() or 1)
        found = run_jobs(_judge, jobs, workers, "classifiers on real scans")
    return [line for name, row in zip(CLASSIFIERS, found) for line in _lines(name, *row)]


def read_recordings(quick: bool) -> Recordings | None:
    """Those that are here; `quick`: of their segments every eighth."""
    folder = data_folder()
    if folder is None:
        return None
    segments, scans = recorded(folder)
    if quick:
        segments = segments.where(np.arange(len(segments.labels)) % 8 == 0)
    return segments, scans


def _judge(
    job: tuple[str, LabelledSegments, LabelledSegments, list[Scan]],
) -> tuple[LegRow, float]:
    name, folds, segments, scans = job
    row = table_1(folds, scans, SegmentationParameters(), [name])[0]
    return row, new_place_f1(name, segments)


def recorded(folder: Path) -> tuple[LabelledSegments, list[Scan]]:
    """Segments of all recordings, one group each (the negative one: six), and some scans."""
    positive = sorted(folder.glob("positive_*.bag"))
    return read_bags(positive, [folder / "negative_2.bag"], SegmentationParameters())


def in_three(segments: LabelledSegments) -> LabelledSegments:
    """The same in three groups, each of whole recordings."""
    groups = np.unique(segments.groups)
    return _regrouped(segments, {group: str(i % 3) for i, group in enumerate(groups)})


def new_place_f1(name: str, segments: LabelledSegments) -> float:
    """F1 on the people of one place by a model of the other, at the paper's share of legs."""
    places = {group: str(group.startswith(OTHER_PLACE)) for group in np.unique(segments.groups)}
    counts = cross_validate(name, _regrouped(segments, places), SegmentationParameters())
    return counts.f1_at(PAPER_LEG_SHARE)


def _regrouped(segments: LabelledSegments, groups: dict[str, str]) -> LabelledSegments:
    return dataclasses.replace(segments, groups=np.array([groups[g] for g in segments.groups]))


def _lines(name: str, row: LegRow | None, elsewhere: float | None) -> list[dict]:
    stem = f"legs_real_{name}"
    values = {figure: getattr(row.counts, figure) if row else None for figure in FIGURES}
    at_share = row.counts.f1_at(PAPER_LEG_SHARE) if row else None
    return [
        *(metric(f"{stem}_{figure}", value, "") for figure, value in values.items()),
        metric(f"{stem}_leg_share", row.counts.person_share if row else None, ""),
        metric(f"{stem}_f1_at_paper_share", at_share, "", ">= 0.67"),
        metric(f"{stem}_new_place_f1_at_paper_share", elsewhere, ""),
        metric(f"{stem}_ms", row.ms if row else None, "ms"),
        metric(f"{stem}_hz", row.hz if row else None, "Hz"),
    ]


def data_folder() -> Path | None:
    """Where the recordings of legs are, if they are here."""
    root = Path(__file__).resolve().parents[1]
    folder = Path(os.environ.get("SAFE_PASSAGE_DATA", root / "../shared/data")) / "lidar2d_legs"
    return folder if folder.is_dir() else None
