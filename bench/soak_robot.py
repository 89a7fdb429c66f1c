"""A simulated robot on its own master, and how its nodes fare: what the soak's phases share."""

from __future__ import annotations

import os
import subprocess
import sys
import time
import xmlrpc.client
from collections import defaultdict
from contextlib import contextmanager
from typing import Iterator, Sequence

import numpy as np
import psutil
import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray

from bench.ros_master import private_master

EVERY = 2.0  # [s] between two looks at the memory
START = 120.0  # [s] for all nodes to run


@contextmanager
def simulated(robot: str) -> Iterator[None]:
    """bringup.launch of a simulated robot; this process is its master's node, once and for all."""
    with private_master() as env:
        os.environ.update(env)
        rosgraph.Master("/soak").setParam("/use_sim_time", True)
        process = subprocess.Popen(
            ["roslaunch", "safe_passage", "bringup.launch", f"robot:={robot}", "simulate:=true"],
            env=env,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        try:
            rospy.init_node("soak", anonymous=True, disable_signals=True)
            yield
        finally:
            rospy.signal_shutdown("done")
            process.send_signal(2)
            process.wait(timeout=60)


class Nodes:
    """How much memory they take, and what they say they have dropped."""

    def __init__(self, names: Sequence[str]) -> None:
        self.memory: dict[str, list[float]] = defaultdict(list)  # [MB] of each node, every EVERY
        self._dropped: dict[tuple[str, str], int] = {}  # (node, topic and reason) -> count
        rospy.Subscriber("/diagnostics", DiagnosticArray, self._on_diagnostics)
        self._processes = _processes(names)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            node = status.name.partition(":")[0].strip("/ ")
            for pair in status.values:
                reason = pair.key.rpartition(" ")[2]
                if reason.isupper() and reason != "OK" and pair.value.isdigit():
                    self._dropped[node, pair.key] = int(pair.value)

    def drops(self, node: str = "", topics: str = "") -> int:
        """Messages dropped until now; of one node and of topics with this in their names."""
        return sum(
            count
            for (name, key), count in list(self._dropped.items())
            if node in ("", name) and topics in key
        )

    def watch(self, seconds: float, what: str) -> None:
        """Let them run, with progress."""
        began = said = time.monotonic()
        while time.monotonic() - began < seconds:
            time.sleep(EVERY)
            for name, process in self._processes.items():
                self.memory[name].append(process.memory_info().rss / 2**20)
            if time.monotonic() - said > 30.0:
                said = time.monotonic()
                done = f"{said - began:.0f} of {seconds:.0f} s"
                print(f"  {what}: {done}", file=sys.stderr, flush=True)

    def growth(self) -> dict[str, float]:
        """[MB] of each node, from the first to the last third of what was watched."""
        growth = {}
        for name, values in self.memory.items():
            third = max(len(values) // 3, 1)
            growth[name] = float(np.median(values[-third:]) - np.median(values[:third]))
        return growth


def percentile(values: Sequence[float] | np.ndarray, share: float) -> float:
    """NaN of nothing."""
    return float(np.percentile(values, share)) if len(values) else float("nan")


def _processes(names: Sequence[str]) -> dict[str, psutil.Process]:
    """The nodes, when all of them run."""
    master = rosgraph.Master("/soak")
    end = time.monotonic() + START
    found: dict[str, psutil.Process] = {}
    while len(found) < len(names):
        if time.monotonic() > end:
            missing = ", ".join(name for name in names if name not in found)
            raise TimeoutError(f"did not start: {missing}")
        for name in names:
            try:
                uri = master.lookupNode("/" + name)
                found[name] = psutil.Process(xmlrpc.client.ServerProxy(uri).getPid("/soak")[2])
            except (rosgraph.MasterError, OSError):
                time.sleep(0.2)
    return found
