"""What a cycle of the tracker costs, on one core: time, its parts, memory; and what peers cost.

A cycle is everything from raw measurements to tracks: preprocessing of two scans and two clouds,
grid, clusters, hypotheses, association, filters, shape alignment.
"""

from __future__ import annotations

import contextlib
import cProfile
import os
import pstats
import re
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Iterator

import cv2
import numpy as np
from safe_passage.monitoring.pipeline import ObstacleTracker
from threadpoolctl import threadpool_limits

from bench.tracker_field import RATE, Field, parameters, prepare
from bench.tracker_peers import Detector, make_peer

WARM_UP = 20  # cycles
SMALL = 0.01  # share of a stage that is told by itself


@dataclass(frozen=True)
class Cost:
    """Of cycles with so many objects."""

    objects: int
    milliseconds: np.ndarray  # (N,) of each cycle
    held: int  # confirmed tracks in the end


@contextlib.contextmanager
def one_core() -> Iterator[None]:
    """Keep this process to one core and one thread of work."""
    before, threads = os.sched_getaffinity(0), cv2.getNumThreads()
    os.sched_setaffinity(0, {max(before)})
    cv2.setNumThreads(1)
    try:
        with threadpool_limits(1):
            yield
    finally:
        os.sched_setaffinity(0, before)
        cv2.setNumThreads(threads)


def cycle_cost(objects: int, cycles: int, seed: int) -> Cost:
    """Time each cycle, after some to warm up."""
    tracker, spent, held = ObstacleTracker(parameters()), [], 0
    for stamp, pose, raw in Field(objects, seed).cycles(WARM_UP + cycles):
        start = time.perf_counter()
        snapshot = tracker.update(stamp, pose, prepare(stamp, pose, raw))
        spent.append(time.perf_counter() - start)
        held = int(snapshot.confirmed.sum())
    return Cost(objects, 1e3 * np.array(spent[WARM_UP:]), held)


def stage_shares(objects: int, cycles: int, seed: int) -> dict[str, float]:
    """Of a cycle's time, by what `ObstacleTracker.update` calls; as the profiler sees it."""
    tracker, profile = ObstacleTracker(parameters()), cProfile.Profile()
    for i, (stamp, pose, raw) in enumerate(Field(objects, seed).cycles(WARM_UP + cycles)):
        if i < WARM_UP:
            tracker.update(stamp, pose, prepare(stamp, pose, raw))
        else:
            profile.runcall(
                lambda a, b, c: tracker.update(a, b, prepare(a, b, c)), stamp, pose, raw
            )
    return shares(pstats.Stats(profile).stats)  # type: ignore[attr-defined]


def shares(stats: dict) -> dict[str, float]:
    """Name of each stage and its share, the largest first; what is small together."""
    update = next(f for f in stats if f[2] == "update" and f[0].endswith("monitoring/pipeline.py"))
    spent = {"preprocessing": next(s[3] for f, s in stats.items() if f[2] == "prepare")}
    for function, (*_, callers) in stats.items():
        if update in callers:
            name = function[2].strip("_")
            spent[name] = spent.get(name, 0.0) + callers[update][3]
    total = stats[update][3] + spent["preprocessing"]
    told = {name: s / total for name, s in spent.items() if s >= SMALL * total}
    ordered = dict(sorted(told.items(), key=lambda item: -item[1]))
    return {**ordered, "other": max(0.0, 1.0 - sum(told.values()))}


def memory_growth(seconds: float, objects: int, rate: float, seed: int) -> float:
    """[MB] by which the process grows over so long a time, after its first fifth."""
    tracker, field = ObstacleTracker(parameters()), Field(objects, seed)
    number, before = round(seconds * rate), 0.0
    for i, (stamp, pose, raw) in enumerate(field.cycles(number, rate)):
        tracker.update(stamp, pose, prepare(stamp, pose, raw))
        if i == number // 5:
            before = resident_mb()
    return resident_mb() - before


def resident_mb() -> float:
    """[MB] of memory that this process holds."""
    rollup = Path("/proc/self/smaps_rollup").read_text()  # exact, unlike statm
    return int(re.search(r"^Rss:\s+(\d+) kB", rollup, re.MULTILINE)[1]) / 1e3  # type: ignore[index]


def peer_cost(name: str, objects: int, cycles: int, seed: int) -> Cost:
    """Time a peer's update alone: our own clustering makes its detections."""
    p = parameters()
    detector, peer = Detector(p), make_peer(name, p, 1.0 / RATE)
    warm_up = max(WARM_UP // 2, 5)
    spent, held = [], 0
    for stamp, pose, raw in Field(objects, seed).cycles(warm_up + cycles):
        positions = detector.detect(stamp, pose, prepare(stamp, pose, raw))
        start = time.perf_counter()
        held = len(peer.update(stamp, positions))
        spent.append(time.perf_counter() - start)
    return Cost(objects, 1e3 * np.array(spent[warm_up:]), held)
