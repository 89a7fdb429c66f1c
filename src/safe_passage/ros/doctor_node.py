"""doctor: listens to the running graph for some seconds and says in plain words what is wrong."""

from __future__ import annotations

import argparse
import json
import struct
import sys
import threading
import time
import xmlrpc.client
from collections import defaultdict
from pathlib import Path
from typing import Any, Iterable

import numpy as np
import rosgraph
import rosnode
import rospy
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import LaserScan

from safe_passage.core.errors import SafePassageError
from safe_passage.doctor.checks import Finding, Severity, examine
from safe_passage.doctor.observations import Clock, Frame, Graph, Topic
from safe_passage.ros.conversions import from_transform
from safe_passage.simulation.robots import Robot, make_robot

OURS = (  # as bringup and the nodes' own launch files call them
    *("obstacle_tracker", "separation_monitor", "depth_self_filter", "person_detector"),
    *("safety_area_merger", "safety_area_merger_rear", "local_costmap", "leg_detector"),
    *("scan_assembler", "scan_segmentation_server", "camera_calibrator"),
)
NOT_INPUTS = ("/clock", "/tf", "/tf_static", "/rosout", "/statistics", "/diagnostics")
HEADERS = (["Header"], ["std_msgs/Header"])


class Listener:
    """What comes on a topic, whatever its type: only the header is read."""

    def __init__(self, name: str) -> None:
        self.count, self.empty = 0, 0
        self.frames: set[str] = set()
        self.ages: list[float] = []
        self._lock = threading.Lock()
        self._subscriber = rospy.Subscriber(name, rospy.AnyMsg, self._on_message, queue_size=10)

    def _on_message(self, message: rospy.AnyMsg) -> None:
        now = rospy.get_rostime().to_sec()
        connection = message._connection_header
        own = connection.get("message_definition", "").split("=" * 40)[0]  # not of what it holds
        stamped = any(line.split()[:1] in HEADERS for line in own.splitlines())
        with self._lock:
            self.count += 1
            if connection.get("type") == LaserScan._type:
                ranges = np.asarray(LaserScan().deserialize(message._buff).ranges)
                self.empty += not (np.isfinite(ranges) & (ranges > 0.0)).any()
            if stamped:
                stamp, frame = read_header(message._buff)
                self.frames.add(frame)
                if stamp > 0.0:
                    self.ages.append(now - stamp)

    def stop(self) -> None:
        """Listen no more."""
        self._subscriber.unregister()


def read_header(data: bytes) -> tuple[float, str]:
    """Stamp [s] and frame_id of a serialised message that begins with a std_msgs/Header."""
    _, seconds, nanoseconds, length = struct.unpack_from("<IIII", data)
    return seconds + 1e-9 * nanoseconds, data[16 : 16 + length].decode(errors="replace")


class Doctor:
    """Looks at one robot's part of the graph.

    Args:
        namespace: of the robot.
    """

    def __init__(self, namespace: str) -> None:
        self._namespace = "/" + namespace.strip("/")
        self._master = rosgraph.Master(rospy.get_name())
        self._tf = tf2_ros.Buffer()
        self._tf_listener = tf2_ros.TransformListener(self._tf)
        self._diagnostics: dict[str, tuple[int, str]] = {}
        rospy.Subscriber("/diagnostics", DiagnosticArray, self._on_diagnostics, queue_size=100)

    def observe(self, seconds: float) -> Graph:
        """Listen for `seconds` of the wall's time, with progress on a terminal."""
        publishers, subscribers, _ = self._state()
        types = dict(self._master.getTopicTypes())
        registered = {
            node for nodes in (*publishers.values(), *subscribers.values()) for node in nodes
        }
        expected = self._expected()
        mine = sorted(node for node in registered if self._is_ours(node, expected))
        alive = [node for node in mine if rosnode.rosnode_ping(node, max_count=1, verbose=False)]
        read = {
            topic: [node for node in nodes if node in alive]
            for topic, nodes in subscribers.items()
            if topic not in NOT_INPUTS and set(nodes) & set(alive)
        }
        written = {topic for topic, nodes in publishers.items() if set(nodes) & set(alive)}
        heard = {
            topic: Listener(topic)
            for topic in {*read, *written}
            if publishers.get(topic) and topic not in NOT_INPUTS
        }
        clock, listened = self._listen(seconds, publishers.get("/clock", []))
        wanted = self._wanted(read)
        topics = {}
        for name in {*types, *read}:
            own = heard.get(name)
            topics[name] = Topic(
                name,
                types.get(name, "") if publishers.get(name) else "",
                wanted.get(name, ""),
                tuple(sorted(publishers.get(name, []))),
                tuple(read.get(name, ())),
                listened if own else 0.0,
                own.count if own else 0,
                tuple(sorted(own.frames)) if own else (),
                tuple(own.ages) if own else (),
                own.empty / own.count if own and own.count else 0.0,
            )
        for one in heard.values():
            one.stop()
        parameters = {node: self._parameters(node) for node in alive}
        odom, base = self._frame_names(parameters)
        frames = {frame for topic in topics.values() if topic.wanted for frame in topic.frames}
        return Graph(
            tuple(alive),
            expected,
            tuple(node for node in mine if node not in alive),
            topics,
            {name: self._frame(name, base, odom) for name in {*frames, base}},
            odom,
            base,
            clock,
            {node: self._said(node) for node in alive},
            parameters,
            self._robot(),
            self._namespace,
        )

    def _state(self) -> tuple[dict[str, list[str]], ...]:
        return tuple(
            {name: nodes for name, nodes in part} for part in self._master.getSystemState()
        )

    def _in_namespace(self, name: str) -> str:
        return self._namespace.rstrip("/") + "/" + name

    def _expected(self) -> tuple[str, ...]:
        """Nodes that bringup was told to start."""
        told = rospy.get_param(self._in_namespace("bringup/nodes"), {})
        return tuple(self._in_namespace(name) for name, on in sorted(told.items()) if on)

    def _is_ours(self, node: str, expected: Iterable[str]) -> bool:
        space, _, name = node.rpartition("/")
        return node in expected or (name in OURS and (space or "/") == self._namespace)

    def _listen(self, seconds: float, clock_publishers: list[str]) -> tuple[Clock, float]:
        """Waits; the clock, and how long it was by it [s]."""
        began, start = time.monotonic(), rospy.get_rostime().to_sec()
        while not rospy.is_shutdown() and time.monotonic() - began < seconds:
            time.sleep(0.1)
            if sys.stderr.isatty():
                left = seconds - (time.monotonic() - began)
                print(
                    f"\r  listening, {max(left, 0.0):3.0f} s ", end="", file=sys.stderr, flush=True
                )
        if sys.stderr.isatty():
            print("\r" + 30 * " ", end="\r", file=sys.stderr)
        passed = rospy.get_rostime().to_sec() - start
        simulated = bool(rospy.get_param("/use_sim_time", False))
        return Clock(simulated, tuple(clock_publishers), passed / seconds), max(passed, 1e-3)

    def _wanted(self, read: dict[str, list[str]]) -> dict[str, str]:
        """Types that our nodes expect of the topics they read, as they say themselves."""
        found = {}
        for node in {node for nodes in read.values() for node in nodes}:
            try:
                uri = self._master.lookupNode(node)
            except rosgraph.MasterError:
                continue  # it left meanwhile
            found.update(subscriptions(uri))
        return {topic: found.get(topic, "*") for topic in read}

    def _parameters(self, node: str) -> dict[str, Any]:
        values = rospy.get_param(node, {})
        return values if isinstance(values, dict) else {}

    def _frame_names(self, parameters: dict[str, dict[str, Any]]) -> tuple[str, str]:
        """Of odometry and base, as the nodes have them."""
        names = [("odom_frame", "odom"), ("base_frame", "base_footprint")]
        return tuple(  # type: ignore[return-value]
            next((str(values[key]) for values in parameters.values() if key in values), default)
            for key, default in names
        )

    def _frame(self, name: str, base: str, odom: str) -> Frame:
        try:
            if name == base:
                newest = self._tf.lookup_transform(odom, base, rospy.Time(0))
                age = (rospy.get_rostime() - newest.header.stamp).to_sec()
                return Frame(name, np.eye(4), age if newest.header.stamp else 0.0)
            return Frame(name, from_transform(self._tf.lookup_transform(base, name, rospy.Time(0))))
        except (tf2_ros.LookupException, tf2_ros.ConnectivityException) as error:
            return Frame(name, error=str(error))
        except (tf2_ros.ExtrapolationException, tf2_ros.InvalidArgumentException) as error:
            return Frame(name, error=str(error))

    def _robot(self) -> Robot | None:
        values = rospy.get_param(self._in_namespace("robot"), None)
        return make_robot(values) if values else None

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self._diagnostics[status.name] = int(status.level), status.message

    def _said(self, node: str) -> tuple[int, str]:
        """The worst of a node's newest statuses."""
        own = [
            said
            for name, said in self._diagnostics.items()
            if "/" + name.partition(":")[0].strip().lstrip("/") == node
        ]
        return max(own, default=(0, ""))


def subscriptions(uri: str) -> list[tuple[str, str]]:
    """Topics that a node reads, with the types it wants; none of a node that has just died."""
    try:
        code, _, found = xmlrpc.client.ServerProxy(uri).getSubscriptions("/doctor")  # type: ignore[misc]
    except (OSError, xmlrpc.client.Error):
        return []
    return [(topic, kind) for topic, kind in found] if code == 1 else []  # type: ignore[union-attr]


def as_text(graph: Graph, findings: list[Finding]) -> str:
    """For people: the worst first, each with its likely cause."""
    lines = []
    for one in findings:
        lines += [f"{one.severity.value:8}{one.subject} {one.what}", f"{'':10}{one.cause}"]
    heard = sum(topic.count for topic in graph.topics.values())
    lines.append(f"{len(graph.nodes)} nodes, {heard} messages looked at.")
    counts = defaultdict(int)
    for one in findings:
        counts[one.severity] += 1
    said = [f"{counts[s]} {s.value.lower()}{'s' * (counts[s] != 1)}" for s in Severity if counts[s]]
    lines.append(", ".join(said) + "." if said else "All well.")
    return "\n".join(lines)


def main(arguments: list[str]) -> int:
    """Run the command line; 1 when there is a fault."""
    parser = argparse.ArgumentParser(prog="doctor", description=__doc__)
    parser.add_argument("namespace", nargs="?", default="/", help="of the robot (default: /)")
    parser.add_argument("--seconds", type=float, default=5.0, help="how long to listen")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the findings there, too")
    args = parser.parse_args(arguments)
    if not rosgraph.is_master_online():
        print(
            "doctor: no ROS master answers: is roscore running, ROS_MASTER_URI right?",
            file=sys.stderr,
        )
        return 1
    rospy.init_node("doctor", anonymous=True, disable_signals=False)
    try:
        graph = Doctor(args.namespace).observe(args.seconds)
    except SafePassageError as error:
        print(f"doctor: {error}", file=sys.stderr)
        return 1
    findings = examine(graph)
    print(as_text(graph, findings))
    if args.json:
        rows = [{**one.__dict__, "severity": one.severity.name} for one in findings]
        args.json.write_text(json.dumps(rows, indent=1) + "\n")
    return int(any(one.severity is Severity.FAULT for one in findings))
