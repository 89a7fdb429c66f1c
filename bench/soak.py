"""The whole simulated robot for ten minutes: memory, lost scans, latency; then three times as many.

Simulated time makes the sensors' rates the real ones on any machine; a slow one has less of it.
`SOAK_MINUTES` sets another length: 60 for the long one. Then depth cameras: soak_cameras.py.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
import rospy
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header

from bench.metric import metric
from bench.soak_robot import Nodes, percentile, simulated

MINUTES, MINUTES_QUICK = 10.0, 0.5
WARM_UP = 60.0  # [s] in which caches and queues may grow
OVERLOAD = 40.0  # [s]
RECOVERY = 20.0  # [s] after it
IN_FLIGHT = 1.0  # [s] simulated: younger scans may still be on their way
PERIOD = 0.025  # [s] of the robot's scanner
TIMES = 3  # the sensors' rate under overload
OURS = (
    *("obstacle_tracker", "separation_monitor", "person_detector"),
    *("safety_area_merger", "local_costmap"),
)


class Scans:
    """What goes in and what comes out."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._came: dict[float, float] = {}  # stamp of a scan: when it came [s of the wall]
        self._merged: dict[float, float] = {}
        rospy.Subscriber("scan", LaserScan, self._on_scan, queue_size=None, tcp_nodelay=True)
        rospy.Subscriber("scan_human_aware", LaserScan, self._on_merged, queue_size=None)

    def _on_scan(self, scan: LaserScan) -> None:
        with self._lock:
            self._came[scan.header.stamp.to_sec()] = time.monotonic()

    def _on_merged(self, scan: LaserScan) -> None:
        with self._lock:
            self._merged[scan.header.stamp.to_sec()] = time.monotonic()

    def between(self, begin: float, end: float) -> tuple[int, int, np.ndarray]:
        """Of those stamped between [s]: number, how many did not come out, latencies [ms]."""
        with self._lock:
            wanted = sorted(stamp for stamp in self._came if begin <= stamp < end)
            out = [stamp for stamp in wanted if stamp in self._merged]
            late = [1e3 * (self._merged[stamp] - self._came[stamp]) for stamp in out]
        return len(wanted), len(wanted) - len(out), np.array(late)


def run(quick: bool = False) -> list[dict]:
    """All rows."""
    minutes = float(os.environ.get("SOAK_MINUTES", MINUTES_QUICK if quick else MINUTES))
    with simulated("summit_xl"):
        rows = _watched(60.0 * minutes, WARM_UP if minutes > 2.0 else 10.0, quick)
    return [*rows, *_cameras(quick)]


def _cameras(quick: bool) -> list[dict]:
    """Rows of a robot on another master, for which a process of its own is needed."""
    with tempfile.TemporaryDirectory() as folder:
        rows = Path(folder) / "rows.json"
        how = ["--quick"] if quick else []
        subprocess.run([sys.executable, "-m", "bench.soak_cameras", str(rows), *how], check=True)
        return json.loads(rows.read_text())


def _watched(seconds: float, warm_up: float, quick: bool) -> list[dict]:
    nodes, scans = Nodes(OURS), Scans()
    rospy.wait_for_message("scan_human_aware", LaserScan, 60.0)
    nodes.watch(warm_up, "warm-up")
    begin, wall, dropped = rospy.get_time(), time.monotonic(), nodes.drops()
    nodes.memory.clear()
    nodes.watch(seconds, "soak")
    end, took = rospy.get_time(), time.monotonic() - wall
    calm_drops, growth = nodes.drops() - dropped, nodes.growth()
    print("growth [MB]: " + ", ".join(f"{name} {mb:+.1f}" for name, mb in growth.items()))
    count, lost, late = scans.between(begin, end - IN_FLIGHT)
    third = max(len(late) // 3, 1)
    rows = [
        metric("soak_simulated_s", end - begin, "s"),
        metric("soak_real_time_factor", (end - begin) / took, ""),
        metric("soak_scans", count, "scans"),
        metric("soak_lost_scans", lost, "scans", "= 0"),
        metric("soak_rss_growth_mb", max(growth.values()), "MB", "<= 5"),
        metric("soak_latency_p99_ms", percentile(late, 99), "ms"),
        metric(
            "soak_latency_drift", percentile(late[-third:], 95) / percentile(late[:third], 95), ""
        ),
        metric("soak_dropped", calm_drops, "messages"),
    ]
    return [*rows, *_overloaded(nodes, scans, 10.0 if quick else OVERLOAD)]


def _overloaded(nodes: Nodes, scans: Scans, seconds: float) -> list[dict]:
    """Scans at three times their rate, then at their own again."""
    publisher = rospy.Publisher("scan", LaserScan, queue_size=10)

    def more(scan: LaserScan) -> None:
        """Copies of each of the robot's scans, between it and the next."""
        if scan._connection_header["callerid"] == rospy.get_name():
            return
        for k in range(1, TIMES):
            copy = LaserScan(**{name: getattr(scan, name) for name in scan.__slots__})
            stamp = scan.header.stamp + rospy.Duration(k * PERIOD / TIMES)
            copy.header = Header(stamp=stamp, frame_id=scan.header.frame_id)
            publisher.publish(copy)

    subscriber = rospy.Subscriber("scan", LaserScan, more, queue_size=1)
    before = nodes.drops()
    begin = rospy.get_time()
    nodes.watch(seconds, "overload")
    end = rospy.get_time()
    subscriber.unregister()
    count, lost, late = scans.between(begin, end - IN_FLIGHT)
    during = nodes.drops() - before
    nodes.watch(RECOVERY, "recovery")
    now = rospy.get_time()
    _, lost_after, late_after = scans.between(end + 0.5 * (now - end), now - IN_FLIGHT)
    return [
        metric("overload_scan_hz", count / max(end - begin - IN_FLIGHT, 1e-3), "Hz"),
        metric("overload_scans_not_out", lost, "scans"),
        metric("overload_latency_p99_ms", percentile(late, 99), "ms"),
        metric("overload_told_drops", during, "messages"),
        metric("overload_recovered_lost_scans", lost_after, "scans", "= 0"),
        metric("overload_recovered_latency_p99_ms", percentile(late_after, 99), "ms"),
    ]
