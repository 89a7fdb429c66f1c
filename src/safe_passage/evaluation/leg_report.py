"""Tables 1 and 2 of paper 002 as a report, and why legs alone fail in a warehouse."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from itertools import islice
from typing import Callable, Mapping, Sequence, Tuple

from safe_passage.evaluation.leg_tables import PAPER_LEG_SHARE, LegRow, table_1, table_2
from safe_passage.evaluation.parallel import Workers
from safe_passage.evaluation.report import table
from safe_passage.evaluation.setting import Setting
from safe_passage.evaluation.warehouse_legs import (
    JudgedSegment,
    LegRun,
    draw_runs,
    judged_segments,
    shares,
)
from safe_passage.leg_detection.classifiers import CLASSIFIERS, train
from safe_passage.leg_detection.scan import Scan
from safe_passage.leg_detection.segmentation import SegmentationParameters
from safe_passage.leg_detection.training_data import (
    LEG,
    LabelledSegments,
    from_labelled_scans,
    joined,
)

FIRST_RUN = 3_000_000  # unless another is given
FIGURES = ("accuracy", "precision", "recall", "f1", "fp_rate")
PAPER_1 = {  # accuracy, precision, recall, F1, FP rate
    "svm": (0.914, 0.741, 0.615, 0.672, 0.031),
    "adaboost": (0.969, 0.895, 0.846, 0.870, 0.014),
    "random_forest": (0.962, 0.906, 0.766, 0.830, 0.011),
}
PAPER_2 = {
    "svm": (0.310, 0.221, 0.249, 0.235, 0.636),
    "adaboost": (0.440, 0.285, 0.497, 0.363, 0.588),
    "random_forest": (0.291, 0.214, 0.331, 0.260, 0.733),
}
LOOKED_AT = "random_forest"  # the classifier whose false alarms are looked at
Recordings = Tuple[LabelledSegments, Sequence[Scan]]  # segments of all, and scans to take times of


@dataclass(frozen=True)
class LegReport:
    """Both tables, and the segments of the second one."""

    real: list[LegRow]  # table 1; empty without recordings
    warehouse: dict[str, list[LegRow]]  # table 2, by what the models were trained on
    segments: dict[str, list[JudgedSegment]]  # the same, of LOOKED_AT


def judge_legs(
    setting: Setting,
    first: int,
    count: int,
    recordings: Recordings | None,
    workers: Workers,
    say: Callable[[str], None] = lambda text: None,
    with_table_1: bool = True,
) -> LegReport:
    """Train on the recordings, if there are any, and on `count` simulated runs; judge `count` more.

    The runs that are trained on have the numbers after those that are judged.
    """
    shape = SegmentationParameters()
    world, robot = setting.load()
    runs = draw_runs(setting, first, 2 * count, workers)
    judged, others = runs[:count], runs[count:]
    training = {"recordings": recordings[0]} if recordings else {}
    training["other simulated scans"] = _training(others, shape)
    warehouse, segments = {}, {}
    for source, data in training.items():
        say(f"training on {source}")
        models = {name: train(name, data, shape) for name in CLASSIFIERS}
        warehouse[source] = table_2(models, [run.scans for run in judged])
        segments[source] = [
            one
            for run in judged
            for one in judged_segments(models[LOOKED_AT], run, world, robot.lidars[0].z)
        ]
    real = []
    if recordings and with_table_1:
        real = table_1(recordings[0], recordings[1][:200], shape, progress=say)
    return LegReport(real, warehouse, segments)


def examples(segments: Sequence[JudgedSegment], each: int = 4) -> dict[str, list[JudgedSegment]]:
    """What fig. 7 shows: things that were taken for legs, and legs, spread over all runs."""
    chosen = {
        "pallet": [s for s in segments if s.false_alarm and s.thing == "pallet"],
        "rack upright": [s for s in segments if s.false_alarm and s.thing == "rack upright"],
        "person": [s for s in segments if s.label == LEG and s.probability >= 0.5],
    }
    return {
        thing: list(islice(found, 0, None, max(1, len(found) // each)))[:each]
        for thing, found in chosen.items()
    }


def as_markdown(report: LegReport) -> str:
    """Both tables beside the paper's, and what is taken for legs."""
    parts = ["# Persons by their legs: 2D laser scans, segment by segment"]
    if report.real:
        parts += ["## Table 1: real scans, each recording judged by models of the others"]
        parts += [_table(report.real, PAPER_1)]
    for source, rows in report.warehouse.items():
        parts += [f"## Table 2: simulated warehouse, trained on {source}", _table(rows, PAPER_2)]
        parts += [f"What the {LOOKED_AT} takes for legs:"]
        header = ("what it is", "segments", "taken for legs", "share of all false alarms")
        parts += [table(header, shares(report.segments[source]))]
    return "\n\n".join(parts)


def as_values(report: LegReport) -> dict:
    """The same for JSON."""
    return {
        "table_1": _rows(report.real),
        "table_2": {source: _rows(rows) for source, rows in report.warehouse.items()},
        "false_alarms": {source: shares(found) for source, found in report.segments.items()},
    }


def _training(runs: Sequence[LegRun], shape: SegmentationParameters) -> LabelledSegments:
    return joined(from_labelled_scans(run.scans, shape, "simulated", False) for run in runs)


def _table(rows: Sequence[LegRow], paper: Mapping[str, tuple[float, ...]]) -> str:
    lines: list[tuple] = []
    for row in rows:
        figures = (getattr(row.counts, name) for name in FIGURES)
        share = row.counts.person_share
        at_share = row.counts.f1_at(PAPER_LEG_SHARE)
        lines.append((row.classifier, *figures, share, at_share, row.ms, row.hz))
        blank = (None, None, None, None)
        lines.append((f"the paper's {row.classifier}", *paper[row.classifier], *blank))
    at = f"F1 at {100 * PAPER_LEG_SHARE:.0f} % legs"
    return table(("classifier", *FIGURES, "share of legs", at, "ms", "Hz"), lines)


def _rows(rows: Sequence[LegRow]) -> dict:
    return {
        row.classifier: {
            "counts": asdict(row.counts),
            **{name: getattr(row.counts, name) for name in FIGURES},
            "f1_at_paper_share": row.counts.f1_at(PAPER_LEG_SHARE),
            "ms": row.ms,
        }
        for row in rows
    }
