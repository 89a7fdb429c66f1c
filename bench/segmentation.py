"""Scan segmentation: time, accuracy, doors in random rooms, other software beside it."""

from __future__ import annotations

import os
import resource
import time
from dataclasses import dataclass

import numpy as np
from safe_passage.evaluation.hough_lines import agreement, hough_segments
from safe_passage.evaluation.parallel import Workers, run_jobs
from safe_passage.evaluation.segmentation_places import garage, hallway, random_case, room
from safe_passage.evaluation.segmentation_trials import (
    ROBOT,
    Trial,
    TrialJob,
    judge_trial,
    plane_errors,
)
from safe_passage.scan_segmentation import OrganisedScan, ScanSegmenter, SegmentationParameters
from safe_passage.scan_segmentation.lines import find_segments
from safe_passage.scan_segmentation.scan import line_images
from safe_passage.scan_segmentation.visualisation import pictured
from safe_passage.simulation.scan_scene import FLOOR, Place, Scanner, scan_place

from bench.metric import metric
from bench.segmentation_peers import Found, ground_of_patchwork, open3d, ours, pcl, score

SEED = 9101  # nothing was tuned with it
WORKERS = Workers(processes=min(2, os.cpu_count() or 1))
TRIALS, TRIALS_QUICK = 200, 16
FINE_CELL = SegmentationParameters().fine_cell
SIZES = {"14k": (80, 180), "76k": (430, 180), "250k": (790, 320), "1m": (1570, 640)}
SIZES_QUICK = {name: SIZES[name] for name in ("14k", "76k", "250k")}
SCANNER = Scanner(pitch=0.2)
GROUNDS, GROUNDS_QUICK = 20, 3  # random rooms in which ground is compared


@dataclass(frozen=True)
class Scene:
    """A scan with its truth."""

    name: str
    place: Place
    scanner: Scanner
    scan: OrganisedScan
    which: np.ndarray  # (H, W) surface of each point


def run(quick: bool = False) -> list[dict]:
    """All rows."""
    scenes = [
        Scene(name, place, SCANNER, *scan_place(place, SCANNER, SEED))
        for name, place in (("room", room()), ("garage", garage()), ("hallway", hallway()))
    ]
    return [
        *times(SIZES_QUICK if quick else SIZES),
        *lines(scenes[1]),
        *planes(scenes),
        *named(scenes),
        *ground(scenes, GROUNDS_QUICK if quick else GROUNDS),
        *random_rooms(TRIALS_QUICK if quick else TRIALS),
        *upright_rooms((TRIALS_QUICK if quick else TRIALS) // 2),
    ]


def times(sizes: dict[str, tuple[int, int]]) -> list[dict]:
    """The garage in scans of several sizes: medians of 5."""
    rows, cost = [], {}
    print("| points | segments | planes | " + " | ".join(_STAGES) + " | picture | all [s] |")
    print("|---" * (len(_STAGES) + 5) + "|")
    for name, (count, width) in sizes.items():
        scanner = Scanner(pitch=0.2, lines=count, points=width)
        scan, _ = scan_place(garage(), scanner, SEED)
        runs = [_timed(scan) for _ in range(6 if name != "1m" else 4)][1:]
        stages = {stage: float(np.median([one[stage] for one in runs])) for stage in runs[0]}
        total = float(np.median([sum(one.values()) for one in runs]))
        points = int(scan.valid.sum())
        found = ScanSegmenter().find_planes(scan)
        shown = " | ".join(f"{stages[stage]:.3f}" for stage in (*_STAGES, "picture"))
        print(f"| {points} | {len(found.segments)} | {len(found.valid)} | {shown} | {total:.3f} |")
        early = stages["lines"] + stages["planes"]
        cost[name] = total / points
        bars = ("<= 0.20", "<= 1.0") if name == "76k" else ("", "")
        rows += [
            metric(f"planes_{name}_s", early, "s", bars[0]),
            metric(f"total_{name}_s", total, "s", bars[1]),
            metric(f"cost_per_point_{name}_us", 1e6 * cost[name], "us"),
        ]
    largest = list(sizes)[-1]
    share = cost[largest] / cost["76k"]
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return [
        *rows,
        metric("cost_per_point_largest_over_76k", share, ""),
        metric("peak_mb", peak, "MB"),
    ]


_STAGES = ("lines", "planes", "ground", "map", "traversability", "doors")


def _timed(scan: OrganisedScan) -> dict[str, float]:
    found = ScanSegmenter().segment(scan, ROBOT)
    start = time.perf_counter()
    pictured(found)
    return {**found.seconds, "picture": time.perf_counter() - start}


def lines(scene: Scene) -> list[dict]:
    """Our line detection beside OpenCV's Hough transform of each line's image."""
    p = SegmentationParameters()
    uv, _ = line_images(scene.scan)
    start = time.perf_counter()
    for line in uv:
        hough_segments(line, p)
    hough = time.perf_counter() - start
    took = []
    for _ in range(5):
        start = time.perf_counter()
        find_segments(scene.scan, p)
        took.append(time.perf_counter() - start)
    in_hough, in_ours = agreement(scene.scan, p)
    return [
        metric("hough_over_ours", hough / float(np.median(took)), ""),
        metric("lines_in_hough_share", in_hough, ""),
        metric("hough_in_lines_share", in_ours, ""),
    ]


def planes(scenes: list[Scene]) -> list[dict]:
    """Plane extraction of three programs on three scans with truth."""
    ratio: dict[str, list[float]] = {"pcl": [], "open3d": []}
    print("| scan | method | s | planes | surfaces found | no surface | normal | offset |")
    print("|---" * 8 + "|")
    for scene in scenes:
        mine = ours(scene.scan)
        _say(scene, "ours", mine)
        for name, method in (("pcl", pcl), ("open3d", open3d)):
            other = method(scene.scan)
            if other is not None:
                _say(scene, name, other)
                ratio[name].append(other.seconds / mine.seconds)
    return [
        metric(f"{name}_over_ours", float(np.median(found)) if found else None, "", ">= 1")
        for name, found in ratio.items()
    ]


def _say(scene: Scene, method: str, found: Found) -> None:
    judged = score(found, scene.place, scene.scanner, scene.which)
    normal = f"{np.median(judged.normal):.2f} deg" if len(judged.normal) else "-"
    offset = f"{np.median(judged.offset):.1f} mm" if len(judged.offset) else "-"
    count = f"{len(found.planes)} | {judged.surfaces} | {judged.wrong}"
    print(f"| {scene.name} | {method} | {found.seconds:.3f} | {count} | {normal} | {offset} |")


def named(scenes: list[Scene]) -> list[dict]:
    """The worst plane of the room, the garage and the hallway."""
    found = [(scene, ScanSegmenter().segment(scene.scan, ROBOT).planes) for scene in scenes]
    errors = [plane_errors(s.place, s.scanner, own, s.which) for s, own in found]
    normal = np.concatenate([one.normal for one in errors])
    offset = np.concatenate([one.offset for one in errors])
    return [
        metric("named_scenes_normal_error_deg", float(normal.max()), "deg"),
        metric("named_scenes_offset_error_mm", float(offset.max()), "mm"),
    ]


def ground(scenes: list[Scene], rooms: int) -> list[dict]:
    """Ground points against truth, ours and Patchwork++'s."""
    cases = [random_case(number, SEED + 1) for number in range(rooms)]
    more = [
        Scene(f"random {c.number}", c.place, c.scanner, *scan_place(c.place, c.scanner, c.number))
        for c in cases
    ]
    counts = {"ours": np.zeros(3), "patchwork": np.zeros(3)}
    for scene in [*scenes, *more]:
        floors = [i for i, s in enumerate(scene.place.surfaces()) if s.kind == FLOOR]
        truth = np.isin(scene.which[scene.scan.valid], floors)
        found = ScanSegmenter().segment(scene.scan, ROBOT)
        labels = found.planes.labels[found.planes.scan.valid]
        mine = np.isin(labels, [plane.index for plane in found.ground])
        counts["ours"] += _hits(mine, truth)
        other = ground_of_patchwork(scene.scan, scene.scanner.position[2])
        if other is not None:
            counts["patchwork"] += _hits(other[0], truth)
    rows = []
    for name, (hit, said, true) in counts.items():
        rows += [
            metric(f"ground_precision_{name}", hit / said if said else None, ""),
            metric(f"ground_recall_{name}", hit / true if true else None, ""),
        ]
    return rows


def _hits(found: np.ndarray, truth: np.ndarray) -> np.ndarray:
    return np.array([(found & truth).sum(), found.sum(), truth.sum()], float)


def random_rooms(count: int) -> list[dict]:
    """Doors, false ways and planes in random rooms."""
    jobs = [TrialJob(number, SEED) for number in range(count)]
    trials = run_jobs(judge_trial, jobs, WORKERS, "rooms")
    done = [trial for trial in trials if not trial.refused]
    decided = [trial for trial in trials if not trial.is_close(FINE_CELL)]
    right = [trial for trial in decided if not trial.refused and trial.is_right]
    passable = [trial for trial in decided if trial.passable and not trial.refused]
    widths = 1e3 * np.array([trial.found_width - trial.width for trial in done])
    drivable = sum(trial.drivable_cells for trial in done)
    print(_wrong(decided))
    return [
        metric("rooms", len(trials), "rooms"),
        metric("rooms_refused", len(trials) - len(done), "rooms"),
        *accuracy(done),
        metric("door_right_share", len(right) / len(decided), "", ">= 0.99"),
        metric("door_not_found", int(np.isnan(widths).sum()), "doors"),
        metric("door_width_error_p95_mm", float(np.nanpercentile(np.abs(widths), 95)), "mm"),
        metric("map_passes_true_doors_share", _mean([t.map_passes for t in passable]), ""),
        metric("false_drivable_cells", sum(t.false_cells for t in done), "cells", "= 0"),
        metric("drivable_cells", drivable, "cells"),
        metric("false_fit_share", sum(t.false_fits for t in done) / max(drivable, 1), ""),
    ]


def upright_rooms(count: int) -> list[dict]:
    """Doors whose frames run along the scan lines: how well such a scan can tell their width."""
    jobs = [TrialJob(number, SEED, upright=True) for number in range(count)]
    trials = run_jobs(judge_trial, jobs, WORKERS, "rooms, upright scanner")
    widths = 1e3 * np.array([trial.found_width - trial.width for trial in trials])
    too_wide = [t.says_passable and not t.passable for t in trials]
    right = [trial.is_right for trial in trials if not trial.is_close(FINE_CELL)]
    return [
        metric("upright_door_falsely_passable", sum(too_wide), "doors", "= 0"),
        metric("upright_door_right_share", _mean(right), ""),
        metric(
            "upright_door_width_error_p95_mm", float(np.nanpercentile(np.abs(widths), 95)), "mm"
        ),
    ]


def accuracy(done: list[Trial]) -> list[dict]:
    """Of planes of a square metre and more: the worst, most, and the worst seen wide enough."""
    errors = [trial.errors for trial in done if trial.errors is not None]
    normal = np.concatenate([one.normal for one in errors])
    offset = np.concatenate([one.offset for one in errors])
    wide = np.concatenate([one.wide for one in errors])
    return [
        metric("planes_judged", len(normal), "planes"),
        metric("normal_error_deg", float(normal.max()), "deg", "<= 0.3"),
        metric("normal_error_p95_deg", float(np.percentile(normal, 95)), "deg"),
        metric("normal_over_bar", int((normal > 0.3).sum()), "planes"),
        metric("strips_seen", int((~wide).sum()), "planes"),
        metric("normal_error_without_strips_deg", float(normal[wide].max()), "deg"),
        metric("offset_error_mm", float(offset.max()), "mm", "<= 5"),
        metric("offset_error_p95_mm", float(np.percentile(offset, 95)), "mm"),
    ]


def _wrong(decided: list[Trial]) -> str:
    wrong = [t for t in decided if t.refused or not t.is_right]
    shown = [f"{t.number}: {t.width:.3f} m, found {t.found_width:.3f} {t.refused}" for t in wrong]
    return f"wrong doors: {'; '.join(shown) or 'none'}"


def _mean(values: list[bool]) -> float | None:
    return float(np.mean(values)) if values else None
