"""The whole simulated robot for ten minutes: memory, lost scans, latency; then three times as many.

Simulated time makes the sensors' rates the real ones on any machine; a slow one has less of it.
`SOAK_MINUTES` sets another length: 60 for the long one.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
import xmlrpc.client
from collections import defaultdict

import numpy as np
import psutil
import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header

from bench.metric import metric
from bench.ros_master import private_master

MINUTES, MINUTES_QUICK = 10.0, 0.5
WARM_UP = 60.0  # [s] in which caches and queues may grow
OVERLOAD = 40.0  # [s]
RECOVERY = 20.0  # [s] after it
EVERY = 2.0  # [s] between two looks at the memory
IN_FLIGHT = 1.0  # [s] simulated: younger scans may still be on their way
PERIOD = 0.025  # [s] of the robot's scanner
TIMES = 3  # the sensors' rate under overload
OURS = (
    *("obstacle_tracker", "separation_monitor", "person_detector"),
    *("safety_area_merger", "local_costmap"),
)


class Watch:
    """What goes in, what comes out, and how much memory that takes."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._came: dict[float, float] = {}  # stamp of a scan: when it came [s of the wall]
        self._merged: dict[float, float] = {}
        self.memory: dict[str, list[float]] = defaultdict(list)  # [MB] of each node, every EVERY
        self.dropped: dict[str, dict[str, int]] = defaultdict(dict)  # node -> reason -> count
        rospy.Subscriber("scan", LaserScan, self._on_scan, queue_size=None, tcp_nodelay=True)
        rospy.Subscriber("scan_human_aware", LaserScan, self._on_merged, queue_size=None)
        rospy.Subscriber("/diagnostics", DiagnosticArray, self._on_diagnostics)

    def _on_scan(self, scan: LaserScan) -> None:
        with self._lock:
            self._came[scan.header.stamp.to_sec()] = time.monotonic()

    def _on_merged(self, scan: LaserScan) -> None:
        with self._lock:
            self._merged[scan.header.stamp.to_sec()] = time.monotonic()

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            node = status.name.partition(":")[0].strip("/ ")
            for pair in status.values:
                reason = pair.key.rpartition(" ")[2]
                if reason.isupper() and reason != "OK" and pair.value.isdigit():
                    self.dropped[node][pair.key] = int(pair.value)

    def remember(self, processes: dict[str, psutil.Process]) -> None:
        """The nodes' memory now."""
        for name, process in processes.items():
            self.memory[name].append(process.memory_info().rss / 2**20)

    def drops(self) -> int:
        """Messages that the nodes say they have dropped."""
        return sum(sum(reasons.values()) for reasons in self.dropped.values())

    def scans(self, begin: float, end: float) -> tuple[int, int, np.ndarray]:
        """Of those stamped between [s]: number, how many did not come out, latencies [ms]."""
        with self._lock:
            wanted = sorted(stamp for stamp in self._came if begin <= stamp < end)
            out = [stamp for stamp in wanted if stamp in self._merged]
            late = [1e3 * (self._merged[stamp] - self._came[stamp]) for stamp in out]
        return len(wanted), len(wanted) - len(out), np.array(late)


def run(quick: bool = False) -> list[dict]:
    """All rows."""
    minutes = float(os.environ.get("SOAK_MINUTES", MINUTES_QUICK if quick else MINUTES))
    with private_master() as env:
        os.environ.update(env)
        rosgraph.Master("/soak").setParam("/use_sim_time", True)
        process = subprocess.Popen(
            ["roslaunch", "safe_passage", "bringup.launch", "robot:=summit_xl", "simulate:=true"],
            env=env,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        try:
            rospy.init_node("soak", anonymous=True, disable_signals=True)
            return _watched(60.0 * minutes, WARM_UP if minutes > 2.0 else 10.0, quick)
        finally:
            rospy.signal_shutdown("done")
            process.send_signal(2)
            process.wait(timeout=60)


def _watched(seconds: float, warm_up: float, quick: bool) -> list[dict]:
    watch = Watch()
    processes = _processes()
    _pass(watch, processes, warm_up, "warm-up")
    begin, wall, dropped = rospy.get_time(), time.monotonic(), watch.drops()
    watch.memory.clear()
    _pass(watch, processes, seconds, "soak")
    end, took = rospy.get_time(), time.monotonic() - wall
    calm_drops = watch.drops() - dropped
    growth = {name: _growth(values) for name, values in watch.memory.items()}
    print("growth [MB]: " + ", ".join(f"{name} {mb:+.1f}" for name, mb in growth.items()))
    count, lost, late = watch.scans(begin, end - IN_FLIGHT)
    third = max(len(late) // 3, 1)
    rows = [
        metric("soak_simulated_s", end - begin, "s"),
        metric("soak_real_time_factor", (end - begin) / took, ""),
        metric("soak_scans", count, "scans"),
        metric("soak_lost_scans", lost, "scans", "= 0"),
        metric("soak_rss_growth_mb", max(growth.values()), "MB", "<= 5"),
        metric("soak_latency_p99_ms", _percentile(late, 99), "ms"),
        metric(
            "soak_latency_drift", _percentile(late[-third:], 95) / _percentile(late[:third], 95), ""
        ),
        metric("soak_dropped", calm_drops, "messages"),
    ]
    return [*rows, *_overloaded(watch, processes, 10.0 if quick else OVERLOAD)]


def _overloaded(watch: Watch, processes: dict[str, psutil.Process], seconds: float) -> list[dict]:
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
    before = watch.drops()
    begin = rospy.get_time()
    _pass(watch, processes, seconds, "overload")
    end = rospy.get_time()
    subscriber.unregister()
    count, lost, late = watch.scans(begin, end - IN_FLIGHT)
    during = watch.drops() - before
    _pass(watch, processes, RECOVERY, "recovery")
    now = rospy.get_time()
    _, lost_after, late_after = watch.scans(end + 0.5 * (now - end), now - IN_FLIGHT)
    return [
        metric("overload_scan_hz", count / max(end - begin - IN_FLIGHT, 1e-3), "Hz"),
        metric("overload_scans_not_out", lost, "scans"),
        metric("overload_latency_p99_ms", _percentile(late, 99), "ms"),
        metric("overload_told_drops", during, "messages"),
        metric("overload_recovered_lost_scans", lost_after, "scans", "= 0"),
        metric("overload_recovered_latency_p99_ms", _percentile(late_after, 99), "ms"),
    ]


def _processes() -> dict[str, psutil.Process]:
    """Our nodes, when all of them run and speak."""
    master = rosgraph.Master("/soak")
    end = time.monotonic() + 120.0
    found: dict[str, psutil.Process] = {}
    while len(found) < len(OURS):
        if time.monotonic() > end:
            missing = ", ".join(name for name in OURS if name not in found)
            raise TimeoutError(f"did not start: {missing}")
        for name in OURS:
            try:
                uri = master.lookupNode("/" + name)
                found[name] = psutil.Process(xmlrpc.client.ServerProxy(uri).getPid("/soak")[2])
            except (rosgraph.MasterError, OSError):
                time.sleep(0.2)
    rospy.wait_for_message("scan_human_aware", LaserScan, 60.0)
    return found


def _pass(watch: Watch, processes: dict[str, psutil.Process], seconds: float, what: str) -> None:
    """Let it run, with progress."""
    began = said = time.monotonic()
    while time.monotonic() - began < seconds:
        time.sleep(EVERY)
        watch.remember(processes)
        if time.monotonic() - said > 30.0:
            said = time.monotonic()
            print(f"  {what}: {said - began:.0f} of {seconds:.0f} s", file=sys.stderr, flush=True)


def _growth(values: list[float]) -> float:
    """[MB] from the first to the last third."""
    third = max(len(values) // 3, 1)
    return float(np.median(values[-third:]) - np.median(values[:third]))


def _percentile(values: np.ndarray, share: float) -> float:
    return float(np.percentile(values, share)) if len(values) else float("nan")
