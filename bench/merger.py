"""Benchmark of the safety area merger: latency and losses of the node, cost of one scan."""

from __future__ import annotations

import json
import math
import subprocess
import time

import numpy as np
from safe_passage import _safety_area as areas

from bench.metric import metric
from bench.ros_master import private_master, program, running

RATE, BEAMS, PERSONS = 40, 1081, 50  # Hz, the paper's scanner, a crowd


def run(quick: bool = False) -> list[dict]:
    """Metrics rows {name, value, unit, bar, holds}; full: ten minutes, quick: twenty seconds."""
    compute_us, overhead_us = compute(300 if quick else 5000)
    load = drive_node(20.0 if quick else 600.0)
    # wake_p99_ms: how late this machine wakes a sleeping thread; a latency cannot be better.
    print(f"binding and allocation, in merger_compute_us too: {overhead_us:.1f} us", flush=True)
    print(f"node: {json.dumps(load)}", flush=True)
    return [
        metric("merger_latency_p99_ms", load["p99_ms"], "ms", "<= 2"),
        metric("merger_compute_us", compute_us, "us", "<= 100"),
        metric("merger_lost_scans", load["sent"] - load["received"], "scans", "= 0"),
    ]


def compute(repeats: int) -> tuple[float, float]:
    """Median time [us] of a scan with all circles, and with none: the binding's share."""
    angles = np.linspace(-math.radians(135), math.radians(135), BEAMS)
    scan = areas.Scan(
        np.full(BEAMS, 15.0), angles[0], angles[-1], angles[1] - angles[0], 0.06, 20.0, angles
    )
    bearings = np.arange(PERSONS) * 2 * math.pi / PERSONS
    distances = 2.0 + 4.0 * (np.arange(PERSONS) * 7 % PERSONS) / PERSONS
    circles = np.stack(
        [distances * np.cos(bearings), distances * np.sin(bearings), np.full(PERSONS, 1.2)], axis=1
    )
    nobody = np.empty((0, 3))
    return tuple(1e6 * _median_time(scan, some, repeats) for some in (circles, nobody))


def _median_time(scan: areas.Scan, circles: np.ndarray, repeats: int) -> float:
    times = []
    for _ in range(repeats + 50):
        start = time.perf_counter()
        areas.merge(scan, circles)
        times.append(time.perf_counter() - start)
    return float(np.median(times[50:]))


def drive_node(seconds: float) -> dict:
    """The node under load on a master of its own: scans sent and received, latency [ms]."""
    with private_master() as env, running([program("safety_area_merger")], env):
        command = [program("merger_load"), "--seconds", str(seconds), "--rate", str(RATE)]
        command += ["--beams", str(BEAMS), "--persons", str(PERSONS)]
        done = subprocess.run(command, env=env, stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])
