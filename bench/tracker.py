"""The obstacle tracker: speed with many objects, accuracy on scenarios, beside public trackers."""

from __future__ import annotations

import importlib.util
import os
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from safe_passage.evaluation.parallel import Workers, run_jobs
from safe_passage.evaluation.tracking_catalogue import Catalogue
from safe_passage.evaluation.tracking_lidar3d import (
    Bin,
    lidar3d_parameters,
    lidar3d_scenario,
    recall_by_distance,
    tracked_range,
)
from safe_passage.evaluation.tracking_metrics import Score, score
from safe_passage.evaluation.tracking_real_report import as_markdown as recordings_table
from safe_passage.evaluation.tracking_real_report import judge_all as judge_recordings
from safe_passage.evaluation.tracking_real_report import sums
from safe_passage.evaluation.tracking_recording import Recording, merged, recordings
from safe_passage.evaluation.tracking_report import EVERY, Line, as_markdown, judge_all, total
from safe_passage.evaluation.tracking_runs import ABLATION, follow, tracker_parameters
from safe_passage.evaluation.tracking_scenarios import TrackingScenario
from safe_passage.ros.tracker_recordings import read_tracking

from bench.metric import metric
from bench.tracker_cost import cycle_cost, memory_growth, one_core, peer_cost, stage_shares
from bench.tracker_peers import follow_with

CONFIG = Path(__file__).resolve().parents[1] / "config"
WORKERS = Workers(processes=os.cpu_count() or 1)
SEEDS = (4001, 4002)  # nothing was tuned with these
FIELD_SEED = 4003
QUICK = ("crossing_standing", "fig6", "static_driving")
CAMERAS = ("static_turning", "static_driving", "workshop_driving", "crossing_corridors")
CAMERA_RATE = 5.0  # [Hz] of each of the two depth cameras
REAL_QUICK = ("positive_2", "scans_demo", "overtake_ego")
PEERS = ("norfair", "stonesoup")
PEER_CYCLES_QUICK = 60
SHARED = 300  # objects at which the stages' shares are metrics
BARS = {300: "<= 25", 1000: "<= 100"}


def run(quick: bool = False) -> list[dict]:
    """All rows."""
    with one_core():
        cost = [*speed(quick), *memory(quick), *peers_speed(quick)]
    scenarios = chosen(quick)
    recordings(scenarios, WORKERS)
    found = [*accuracy(scenarios, quick), *with_cameras(quick)]
    return [*cost, *found, *peers_accuracy(scenarios, quick), *lidar3d(quick), *real(quick)]


def chosen(quick: bool) -> list[TrackingScenario]:
    """Scenarios that nothing was tuned with."""
    return [
        catalogue.make(name)
        for catalogue in (Catalogue(CONFIG, seed) for seed in SEEDS[: 1 if quick else None])
        for name in (QUICK if quick else catalogue.names())
    ]


def speed(quick: bool) -> list[dict]:
    """Cost against the number of objects."""
    rows, shares = [], {}
    for objects in (50, 300, 1000, 2000) if quick else (50, 100, 200, 300, 500, 1000, 1500, 2000):
        cycles = max(12 if quick else 20, (4000 if quick else 120000) // (objects + 100))
        cost = cycle_cost(objects, cycles, FIELD_SEED)
        rows.append(metric(f"cycle_{objects}_ms", float(np.median(cost.milliseconds)), "ms"))
        if objects in BARS:
            p99 = float(np.percentile(cost.milliseconds, 99))
            rows.append(metric(f"cycle_{objects}_p99_ms", p99, "ms", BARS[objects]))
        rows.append(metric(f"tracks_held_{objects}", cost.held, "tracks"))
        if objects == SHARED or not quick:
            shares[objects] = stage_shares(objects, 5 if quick else 40, FIELD_SEED)
    print(shares_table(shares))
    stages = shares[SHARED].items()
    return [*rows, *(metric(f"share_{SHARED}_{name}", share, "") for name, share in stages)]


def shares_table(shares: dict[int, dict[str, float]]) -> str:
    """Markdown: a row a stage, a column a number of objects."""
    names = list(dict.fromkeys(name for one in shares.values() for name in one))
    lines = [f"| stage | {' | '.join(map(str, shares))} |", "|---" * (len(shares) + 1) + "|"]
    for name in names:
        cells = " | ".join(f"{one.get(name, 0.0):.0%}" for one in shares.values())
        lines.append(f"| {name} | {cells} |")
    return "\n".join(lines)


def memory(quick: bool) -> list[dict]:
    """Ten minutes at a scanner's 12.5 Hz."""
    growth = memory_growth(8.0 if quick else 600.0, 300, 12.5, FIELD_SEED)
    return [metric("rss_growth_mb", growth, "MB", "<= 5")]


def peers_speed(quick: bool) -> list[dict]:
    """Time of the peers' update by that of our whole cycle, 300 objects."""
    cycles = 8 if quick else 100
    ours = float(np.median(cycle_cost(300, 3 * cycles, FIELD_SEED).milliseconds))
    rows = []
    for name in PEERS:
        theirs = peer_cost(name, 300, cycles, FIELD_SEED) if installed(name) else None
        ms = float(np.median(theirs.milliseconds)) if theirs else None
        rows += [
            metric(f"{name}_300_ms", ms, "ms"),
            metric(f"{name}_tracks_held_300", theirs.held if theirs else None, "tracks"),
            metric(f"{name}_over_ours", ms / ours if ms else None, ""),
        ]
    return rows


def installed(package: str) -> bool:
    """Whether it is there: not every Python can have every peer."""
    return importlib.util.find_spec(package) is not None


def with_cameras(quick: bool) -> list[dict]:
    """What two depth cameras add: tables, shelves, and things that come into a narrow view."""
    scenarios = [
        Catalogue(CONFIG, seed, CAMERA_RATE).make(name)
        for seed in SEEDS[: 1 if quick else None]
        for name in (CAMERAS[:1] if quick else CAMERAS)
    ]
    lines = judge_all(scenarios, tracker_parameters(CONFIG), WORKERS)
    found = total(lines)
    print(as_markdown([*lines, found], "with cameras"))
    mota = None if quick else found.score.mota
    return [
        metric("cameras_mota", mota, ""),
        metric("cameras_false_moving_share", found.score.false_moving_share, "", "< 0.01"),
    ]


def accuracy(scenarios: list[TrackingScenario], quick: bool) -> list[dict]:
    """Ours, and what each of the paper's extensions adds; quickly: all of them together."""
    steps: dict[str, list[Line]] = {}
    for name, changes in list(ABLATION.items())[:: len(ABLATION) - 1 if quick else 1]:
        steps[name] = judge_all(scenarios, tracker_parameters(CONFIG, changes), WORKERS)
    totals = [replace(total(lines), scenario=name) for name, lines in steps.items()]
    ours, baseline = totals[-1].score, totals[0].score
    lines = list(steps.values())[-1]
    print(as_markdown([*lines, total(lines)]))
    print(as_markdown(totals, "tracker"))
    driving = {scenario.name for scenario in scenarios if scenario.drives}
    moving = total([line for line in lines if line.scenario in driving]).score
    fig6 = max(line.ids for line in lines if line.scenario == "fig6")
    return [
        metric("mota", ours.mota, "", ">= 0.90"),
        metric("motp_m", ours.motp, "m"),
        metric("idf1", ours.idf1, "", ">= 0.90"),
        metric("id_switches", ours.switches, ""),
        metric("false_moving_share", ours.false_moving_share, "", "< 0.01"),
        metric("false_moving_share_driving", moving.false_moving_share, "", "< 0.01"),
        metric("baseline_mota", baseline.mota, "", f"< {ours.mota:.4f}"),
        metric("baseline_idf1", baseline.idf1, "", f"< {ours.idf1:.4f}"),
        metric("baseline_false_moving_share", baseline.false_moving_share, ""),
        metric("fig6_ids", fig6, "ids", "= 1"),
    ]


@dataclass(frozen=True)
class PeerJob:
    """One scenario for one peer."""

    peer: str
    scenario: TrackingScenario
    cycles: int | None  # at most


def judge_peer(job: PeerJob) -> Score:
    """Run it."""
    recording = merged(recordings([job.scenario], Workers())[0], EVERY)
    recording = shortened(recording, job.cycles)
    said = follow_with(job.peer, recording, tracker_parameters(CONFIG))
    return score(recording, said)


def shortened(recording: Recording, cycles: int | None) -> Recording:
    """Its beginning."""
    first = slice(cycles)
    names = ("stamps", "poses", "people", "visible", "moved", "raw")
    return replace(recording, **{name: getattr(recording, name)[first] for name in names})


def peers_accuracy(scenarios: list[TrackingScenario], quick: bool) -> list[dict]:
    """The same detections through public trackers."""
    rows = []
    for peer in PEERS:
        cycles = PEER_CYCLES_QUICK if quick else None
        jobs = [PeerJob(peer, one, cycles) for one in scenarios[: 1 if quick else None]]
        scores = run_jobs(judge_peer, jobs, WORKERS, peer) if installed(peer) else []
        found = sum(scores, Score())
        for name, unit in (("mota", ""), ("motp", "m"), ("idf1", ""), ("false_moving_share", "")):
            value = getattr(found, name) if scores else None
            rows.append(metric(f"{peer}_{name}{'_m' if unit else ''}", value, unit))
    return rows


def lidar3d(quick: bool) -> list[dict]:
    """People walking away from a 3D lidar, and towards it."""
    bins: dict[float, Bin] = {}
    seconds = 12.0 if quick else 24.0
    scenarios = [lidar3d_scenario(seed, seconds) for seed in SEEDS[: 1 if quick else None]]
    for recording in recordings(scenarios, WORKERS):
        for one in recall_by_distance(recording, follow(recording, lidar3d_parameters(CONFIG))):
            before = bins.get(one.end, Bin(one.end, 0, 0))
            bins[one.end] = Bin(one.end, before.there + one.there, before.found + one.found)
    ordered = [bins[end] for end in sorted(bins)]
    shown = ", ".join(f"{b.end:.0f} m {b.found / b.there:.0%}" for b in ordered if b.there)
    print(f"3D lidar, people tracked up to: {shown}")
    return [metric("lidar3d_range_m", tracked_range(ordered), "m", ">= 40")]


def real(quick: bool) -> list[dict]:
    """Real recordings, where they are here."""
    folder = CONFIG.parent / "../shared/data"
    folder = Path(os.environ.get("SAFE_PASSAGE_DATA", folder))
    results = []
    if folder.is_dir():
        results = judge_recordings(read_tracking(folder, REAL_QUICK if quick else ()), CONFIG)
        print(recordings_table(results))
    else:
        print(f"real recordings: not measured, {folder} is not here (SAFE_PASSAGE_DATA)")
    rows = []
    for name, value in sums(results).items():
        unit = "m/s" if name == "car_speed_error" else "ids" if name.endswith("ids") else ""
        bar = "< 0.01" if name.startswith("false_moving") else ""
        rows.append(metric(f"real_{name}", None if np.isnan(value) else value, unit, bar))
    return rows
