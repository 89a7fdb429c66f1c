"""A private ROS graph: a master, the node under test as its launch file has it, what comes out."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import roslaunch.config
import roslaunch.xmlloader
import roslib.packages
import rospy
from rosgraph_msgs.msg import Clock, Log

NODE_TESTS = Path(__file__).resolve().parent.parent / "test" / "node"
sys.path.append(str(NODE_TESTS))  # their worlds are ours
ADDRESSES = 8 * 2**30  # [byte] that a node may reserve
PERIOD = 0.1  # [s] of /diagnostics
ROBOT = "robot1"  # namespace of the node under test
from node_testing import Diagnostics  # noqa: E402


@dataclass(frozen=True)
class Output:
    """A message that came out."""

    topic: str
    message: Any
    at: float  # [s] simulated, when it came
    stamp: float  # [s] its own; where it has none, `at`


class Told(Diagnostics):
    """What a node says of its inputs: level, and how many messages it has dropped."""

    def drops(self) -> int:
        """Messages with any other outcome than OK."""
        pairs = [pair for status in list(self._statuses.values()) for pair in status.values]
        return sum(
            int(pair.value)
            for pair in pairs
            if pair.key.split()[-1].isupper() and pair.key.split()[-1] != "OK"
        )

    def worst(self) -> int:
        """Level of the worst task."""
        return max((status.level for status in list(self._statuses.values())), default=-1)


class Graph:
    """Simulated time, publishers and subscribers; `news` is notified when something comes out."""

    def __init__(self) -> None:
        self.news = threading.Condition()
        self.outputs: list[Output] = []
        self.warnings: list[str] = []  # names of nodes that logged one
        self._now = 1000 * 10**9  # [ns]
        self._clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self._subscribers: list[rospy.Subscriber] = []
        rospy.Subscriber("/rosout", Log, self._on_log)

    @property
    def now(self) -> rospy.Time:
        """Simulated."""
        return rospy.Time(self._now // 10**9, self._now % 10**9)

    def advance(self, seconds: float) -> rospy.Time:
        """The clock goes on, or jumps; returns its time."""
        self._now += round(1e9 * seconds)
        self._clock.publish(self.now)
        return self.now

    def listen(self, topics: dict[str, type]) -> None:
        """To these, and no other ones any more."""
        for subscriber in self._subscribers:
            subscriber.unregister()
        self.outputs.clear()
        self._subscribers = [
            rospy.Subscriber(topic, kind, self._receive, topic, queue_size=1000, buff_size=2**24)
            for topic, kind in topics.items()
        ]

    def _receive(self, message: Any, topic: str) -> None:
        at = self._now / 1e9
        header = getattr(message, "header", None)
        stamp = header.stamp.to_sec() if header else at
        with self.news:
            self.outputs.append(Output(topic, message, at, stamp))
            self.news.notify_all()

    def _on_log(self, log: Log) -> None:
        if log.level >= Log.WARN:
            with self.news:
                self.warnings.append(log.name)
                self.news.notify_all()


class NodeProcess:
    """One node of a launch file of this package, with that file's parameters and remappings."""

    def __init__(
        self,
        launch: str,
        arguments: tuple[str, ...],
        name: str,
        parameters: dict[str, Any],
        logs: Path,
    ) -> None:
        config = roslaunch.config.ROSLaunchConfig()
        os.environ["ROS_NAMESPACE"] = ROBOT
        path = str(NODE_TESTS.parent.parent / "launch" / launch)
        roslaunch.xmlloader.XmlLoader().load(path, config, argv=list(arguments), verbose=False)
        for key, parameter in config.params.items():
            rospy.set_param(key, parameter.value)
        # what it tells shall come soon after it is known
        for key, value in {"diagnostic_period": PERIOD, **parameters}.items():
            rospy.set_param(f"/{ROBOT}/{name}/{key}", value)
        node = next(node for node in config.nodes if node.name == name)
        program, *_ = roslib.packages.find_node("safe_passage", node.type)
        remaps = [f"{there}:={here}" for there, here in node.remap_args]
        self._command = [program, *remaps, f"__name:={name}"]
        self._log = (logs / f"{name}.log").open("w")
        self.start()

    def start(self) -> None:
        """As at first, or as roslaunch does it again with respawn."""
        self.process = subprocess.Popen(
            self._command, stdout=self._log, stderr=self._log, preexec_fn=_bound_memory
        )

    def died(self) -> str:
        """Its exit status; empty: it lives."""
        status = self.process.poll()
        if status is None:
            return ""
        lines = Path(self._log.name).read_text(errors="replace").strip().splitlines()
        return f"the node ended with {status}: {lines[-1] if lines else ''}"

    def kill(self) -> None:
        """Without a chance to say goodbye."""
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    def stop(self) -> None:
        """For good."""
        self.process.terminate()
        try:
            self.process.wait(timeout=10)
        except subprocess.TimeoutExpired:
            self.kill()
        self._log.close()

    def memory(self) -> int:
        """[byte] most that it has held."""
        lines = Path(f"/proc/{self.process.pid}/status").read_text().splitlines()
        (most,) = (line.split()[1] for line in lines if line.startswith("VmHWM"))
        return 1024 * int(most)


def _bound_memory() -> None:
    """A node that wants all there is shall end, and nothing else on this machine."""
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES, ADDRESSES))
