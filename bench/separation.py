"""Separation: crossings in a closed loop, safety areas that follow, cost of a cycle."""

from __future__ import annotations

import math
import os
from collections import Counter
from pathlib import Path

import numpy as np
from safe_passage.evaluation.parallel import Workers, run_jobs
from safe_passage.evaluation.separation_crossings import crossing
from safe_passage.evaluation.separation_crowd import cycle_times
from safe_passage.evaluation.separation_follow import (
    Followed,
    FollowJob,
    follow_round,
    make_round,
)
from safe_passage.evaluation.separation_runs import crossing_robot, separation_parameters
from safe_passage.evaluation.separation_scores import (
    CrossingJob,
    Outcome,
    Verdict,
    false_stops,
    judge_crossing,
)

from bench.metric import metric
from bench.tracker_cost import one_core

CONFIG = Path(__file__).resolve().parents[1] / "config"
WORKERS = Workers(processes=min(2, os.cpu_count() or 1))
SEED = 5001  # nothing was tuned with it
CROSSINGS, CROSSINGS_QUICK = 500, 12
ROUNDS, ROUNDS_QUICK = 24, 2
CYCLES, CYCLES_QUICK = 3000, 200
TRACKS, MOVING = 300, 0.1  # as in the tracker's benchmark one in ten moves
LOST = 1.2  # [m] an area's radius: a person outside of it has none


def run(quick: bool = False) -> list[dict]:
    """All rows."""
    with one_core():
        rows = cost(quick)
    return [*rows, *follow(quick), *crossings(quick)]


def cost(quick: bool) -> list[dict]:
    """One cycle: everybody is assessed, a command is limited."""
    parameters, cycles = separation_parameters(CONFIG), CYCLES_QUICK if quick else CYCLES
    some, all_of_them = (
        cycle_times(TRACKS, share, cycles, parameters, SEED) for share in (MOVING, 1.0)
    )
    return [
        metric("separation_p99_ms", float(np.percentile(some, 99)), "ms", "<= 5"),
        metric("separation_median_ms", float(np.median(some)), "ms"),
        metric("separation_all_move_p99_ms", float(np.percentile(all_of_them, 99)), "ms"),
    ]


def follow(quick: bool) -> list[dict]:
    """Persons who walk out of the camera's view and around the robot."""
    rounds = range(ROUNDS_QUICK if quick else ROUNDS)
    jobs = [FollowJob(make_round(number, SEED), CONFIG) for number in rounds]
    found = run_jobs(follow_round, jobs, WORKERS, "rounds")
    error = np.concatenate([one.error for one in found])
    print(rounds_table(found))
    return [
        metric("area_follow_error_m", float(error.max()), "m", "<= 0.25"),
        metric("area_follow_error_median_m", float(np.median(error)), "m", "<= 0.25"),
        metric("area_follow_error_p95_m", float(np.percentile(error, 95)), "m"),
        metric("area_follow_over_bar_share", float((error > 0.25).mean()), ""),
        metric("area_lost_share", float((error > LOST).mean()), ""),
        metric("area_strangers", float(np.mean([one.strangers.mean() for one in found])), "areas"),
    ]


def rounds_table(found: list[Followed]) -> str:
    """Markdown: when each was farthest off."""
    lines = ["| round | in view | median [m] | largest [m] | at [s] |", "|---" * 5 + "|"]
    for i, one in enumerate(found):
        median, worst = np.median(one.error), one.error.argmax()
        at = f"{one.error[worst]:.2f} | {one.times[worst]:.1f}"
        lines.append(f"| {i} | {one.in_view.mean():.0%} | {median:.2f} | {at} |")
    return "\n".join(lines)


def crossings(quick: bool) -> list[dict]:
    """Random crossings, with the monitor and with obstacles taken to stand."""
    footprint = np.array(crossing_robot(CONFIG).footprint)
    numbers = range(CROSSINGS_QUICK if quick else CROSSINGS)
    jobs = [CrossingJob(crossing(number, SEED, footprint), CONFIG) for number in numbers]
    outcomes = run_jobs(judge_crossing, jobs, WORKERS, "crossings")
    ours = [one.monitor for one in outcomes]
    print(reasons(ours))
    return [*contacts(ours, outcomes), *stops(ours, outcomes), *times(ours)]


def contacts(ours: list[Verdict], outcomes: list[Outcome]) -> list[dict]:
    """Who was touched."""
    static = [one.static for one in outcomes]
    least = [one.least for one in ours if math.isfinite(one.least)]
    undisturbed = sum(one.free < 0.0 for one in ours)
    return [
        metric("contacts", sum(one.contact for one in ours), "runs", "= 0"),
        metric("contacts_static_baseline", sum(one.contact for one in static), "runs"),
        metric("contacts_undisturbed", undisturbed, "runs"),
        metric("contacts_unavoidable", sum(not one.avoidable for one in ours), "runs"),
        metric("walked_into_standing_robot", sum(one.bumped for one in ours), "runs"),
        metric("least_distance_m", min(least), "m"),
        metric("least_distance_p5_m", float(np.percentile(least, 5)), "m"),
    ]


def stops(ours: list[Verdict], outcomes: list[Outcome]) -> list[dict]:
    """Stops where nobody would have come near."""
    kept = separation_parameters(CONFIG).min_distance
    static = [one.static for one in outcomes]
    harmless = sum(one.free >= kept for one in ours)
    wrong = len(false_stops(ours, kept))
    half = len(false_stops(ours, 0.5))
    baseline = len(false_stops(static, kept))
    return [
        metric("false_stop_share", wrong / len(ours), "", "<= 0.05"),
        metric("false_stop_share_of_harmless", wrong / max(harmless, 1), ""),
        metric("false_stop_share_half_metre", half / len(ours), ""),
        metric("false_stop_share_static_baseline", baseline / len(ours), ""),
        metric("harmless_runs", harmless, "runs"),
    ]


def times(ours: list[Verdict]) -> list[dict]:
    """From danger to command, and from the end of danger to the full command."""
    reaction = 1e3 * np.array([one.reaction for one in ours if not math.isnan(one.reaction)])
    resume = np.array([one.resume for one in ours if not math.isnan(one.resume)])
    late = float(np.percentile(np.nan_to_num(reaction, posinf=1e4), 95)) if len(reaction) else None
    return [
        metric("reaction_ms", float(np.median(reaction)) if len(reaction) else None, "ms"),
        metric("reaction_p95_ms", late, "ms"),
        metric("never_reacted", int(np.isinf(reaction).sum()), "runs"),
        metric("resume_s", float(np.median(resume)) if len(resume) else None, "s"),
        metric("resume_p95_s", float(np.percentile(resume, 95)) if len(resume) else None, "s"),
    ]


def reasons(ours: list[Verdict]) -> str:
    """How contacts and false stops came about, and in which crossings."""
    kept = separation_parameters(CONFIG).min_distance
    wrong = false_stops(ours, kept)
    lines = []
    for what, runs in (("contacts", [one for one in ours if one.contact]), ("false stops", wrong)):
        counted = ", ".join(f"{n} {why}" for why, n in Counter(one.why for one in runs).items())
        lines.append(f"{what}: {counted or 'none'} {[one.number for one in runs]}")
    return "\n".join(lines)
