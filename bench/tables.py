"""The paper's tables and figure 9: legs, the person detector, the closed loop, the simulator."""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np
from safe_passage.evaluation import closed_loop_table
from safe_passage.evaluation.closed_loop_table import CAUSES, HOLD_TIME, Outcome
from safe_passage.evaluation.detector_report import FIGURES, FIRST_VIEW, judge_detectors
from safe_passage.evaluation.leg_report import FIRST_RUN, Recordings, judge_legs
from safe_passage.evaluation.parallel import Workers
from safe_passage.evaluation.scenarios import KINDS
from safe_passage.evaluation.setting import Setting
from safe_passage.simulation.simulator import Simulator

from bench import leg_tables
from bench.metric import metric

SETTING = Setting.of(Path(__file__).resolve().parents[1] / "config")
WORKERS = Workers(processes=os.cpu_count() or 1)
DETECT_EVERY = 3  # cycles of 0.1 s: a third of the work, harder than at the full rate
DETECT_EVERY_QUICK = 5
SCANS_A_FRAME = 4  # the lidar's 40 Hz over the camera's 10 Hz
BARS = {
    "yolo_accuracy": ">= 0.98",
    "yolo_precision": ">= 0.95",
    "yolo_recall": ">= 0.90",
    "yolo_fp_rate": "<= 0.01",
    "hog_accuracy": "> 0.741",
    "hog_precision": "> 0.761",
    "hog_recall": "> 0.672",
    "hog_fp_rate": "< 0.136",
}


def run(quick: bool = False) -> list[dict]:
    """All rows."""
    return [
        *simulator(10 if quick else 200),
        *legs(quick),
        *detectors(24 if quick else 1000),
        *closed_loop(1 if quick else 50, DETECT_EVERY_QUICK if quick else DETECT_EVERY),
    ]


def simulator(frames: int) -> list[dict]:
    """Frames a second with their scans, noise and all, with nothing else running."""
    world, robot = SETTING.load()
    made = Simulator(world, robot)
    try:
        made.frame(robot.cameras[0])  # builds the drawing context
        start = time.perf_counter()
        for _ in range(frames):
            for _ in range(SCANS_A_FRAME):
                made.step()
                made.scan(robot.lidars[0])
            made.frame(robot.cameras[0])
        return [metric("sim_fps", frames / (time.perf_counter() - start), "Hz", ">= 5")]
    finally:
        made.close()


def legs(quick: bool) -> list[dict]:
    """Tables 1 and 2."""
    recordings = leg_tables.read_recordings(quick)
    real = leg_tables.rows(recordings, quick)
    return [*real, *warehouse_legs(6 if quick else 60, recordings)]


def warehouse_legs(runs: int, recordings: Recordings | None) -> list[dict]:
    """Table 2: trained on the recordings, as in the paper, and on other simulated scans."""
    report = judge_legs(SETTING, FIRST_RUN, runs, recordings, WORKERS, with_table_1=False)
    rows = []
    for source, suffix in (("recordings", ""), ("other simulated scans", "_simulated")):
        found = {row.classifier: row.counts for row in report.warehouse.get(source, ())}
        for name in leg_tables.CLASSIFIERS:
            stem = f"legs_warehouse{suffix}_{name}"
            for figure in leg_tables.FIGURES:
                value = getattr(found[name], figure) if found else None
                rows.append(metric(f"{stem}_{figure}", value, ""))
    return rows


def detectors(views: int) -> list[dict]:
    """Table 3: who is reasonably visible, and beside it whoever is half visible."""
    report = judge_detectors(SETTING, FIRST_VIEW, views, ("hog", "yolo"), WORKERS)
    rows = []
    for method, score in report.scores.items():
        for figure in FIGURES:
            name = f"{method}_{figure}"
            value = getattr(score.counts["reasonable"], figure)
            rows.append(metric(name, value, "", BARS.get(name, "")))
        for figure in ("accuracy", "recall"):
            value = getattr(score.counts["half_visible"], figure)
            rows.append(metric(f"{method}_{figure}_half_visible", value, ""))
        ms = float(np.median(report.milliseconds[method]))
        rows += [metric(f"{method}_ms", ms, "ms"), metric(f"{method}_hz", 1e3 / ms, "Hz")]
    return rows


def closed_loop(runs: int, detect_every: int) -> list[dict]:
    """Fig. 9: `runs` scenarios of each kind, without areas and with those of YOLO's persons."""
    outcomes = closed_loop_table.run_all(
        SETTING, runs, ("none", "yolo"), closed_loop_table.SEED, WORKERS, detect_every
    )
    print(closed_loop_table.as_markdown(closed_loop_table.summaries(outcomes), outcomes))
    return [*_with_areas([o for o in outcomes if o.run.method == "yolo"]), *_compared(outcomes)]


def _with_areas(outcomes: list[Outcome]) -> list[dict]:
    reached = [o.run for o in outcomes if o.run.reached]
    keepable = [o.run for o in outcomes if o.way_existed]
    causes = [o.cause for o in outcomes]
    return [
        metric("closed_loop_runs", len(outcomes), "runs"),
        metric("goals_reached_share", len(reached) / len(outcomes), "", ">= 0.95"),
        metric("pallet_approach_m", _max([run.pallet_gap for run in reached]), "m", "<= 0.15"),
        metric("ways_existed", len(keepable), "runs"),
        metric("min_person_distance_m", _min([run.min_distance for run in keepable]), "m"),
        metric(
            "min_person_distance_moving_m", _min([run.min_distance_moving for run in keepable]), "m"
        ),
        metric("distance_violations", sum(o.violates for o in outcomes), "runs", "= 0"),
        *(
            metric(
                f"distance_violations_{kind}",
                sum(o.violates and o.run.kind == kind for o in outcomes),
                "runs",
            )
            for kind in KINDS
        ),
        metric("distance_violations_moving", sum(o.violates_moving for o in outcomes), "runs"),
        metric(
            "distance_violations_within_cell",
            sum(o.violates and o.within_cell for o in outcomes),
            "runs",
        ),
        *(
            metric(f"distance_violations_{name.replace(' ', '_')}", causes.count(name), "runs")
            for name in CAUSES
        ),
        metric("hold_time_s", HOLD_TIME, "s"),
    ]


def _compared(outcomes: list[Outcome]) -> list[dict]:
    without = [o for o in outcomes if o.run.method == "none"]
    distances = [o.run.min_distance for o in without if o.way_existed]
    lost = [t for kind in KINDS for t in closed_loop_table.time_lost(outcomes, kind, "yolo")]
    return [
        metric("min_person_distance_without_areas_m", _min(distances), "m"),
        metric("distance_violations_without_areas", sum(o.violates for o in without), "runs"),
        metric("time_lost_s", float(np.median(lost)) if lost else None, "s"),
        metric("time_lost_mean_s", float(np.mean(lost)) if lost else None, "s"),
    ]


def _min(values: list[float]) -> float | None:
    return min(values, default=None)


def _max(values: list[float]) -> float | None:
    return max(values, default=None)
