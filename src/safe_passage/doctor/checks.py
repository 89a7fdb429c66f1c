"""What observations of a graph mean: each check yields findings in plain words."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Any, Callable, Iterator, Mapping, Union

import numpy as np

from safe_passage.doctor.observations import Graph, Topic
from safe_passage.simulation.robots import CameraModel, LidarModel

SLOW = 0.6  # share of its nominal rate from which on a sensor is slow
LEAST_RATE = {"nav_msgs/Odometry": 10.0}  # [Hz] of what no yaml tells
OLD = 0.3  # [s] of a message when it comes: a tenth is usual
AHEAD = 0.05  # [s] that a stamp may lie in the future
MOVED = 0.05  # [m] between where tf and yaml have a sensor
TURNED = math.radians(3.0)
EMPTY = 0.9  # share of messages without one return
LATE_TF = 0.3  # [s]


class Severity(enum.Enum):
    """How bad."""

    FAULT = "FAULT"  # something does not work, or is unsafe
    WARNING = "WARNING"  # it works, worse than it should
    NOTE = "note"


@dataclass(frozen=True)
class Finding:
    """What is wrong, with what, why most likely and what to do."""

    severity: Severity
    subject: str  # node, topic or frame
    what: str
    cause: str


Check = Callable[[Graph], Iterator[Finding]]
Sensor = Union[LidarModel, CameraModel]


def examine(graph: Graph) -> list[Finding]:
    """Everything that is wrong, the worst first."""
    found = [finding for check in CHECKS for finding in check(graph)]
    return sorted(found, key=lambda one: list(Severity).index(one.severity))


def check_nodes(graph: Graph) -> Iterator[Finding]:
    """Do those run that should?"""
    if not graph.nodes and not graph.expected:
        cause = "start one: roslaunch safe_passage bringup.launch robot:=..."
        yield Finding(Severity.FAULT, graph.namespace, "no node of safe_passage runs here", cause)
    for name in graph.expected:
        if name not in graph.nodes and name not in graph.dead:
            cause = (
                "it ended, or never started: its last line in the terminal of roslaunch says why; "
                "mostly a parameter that it refused"
            )
            yield Finding(Severity.FAULT, name, "should run and does not", cause)
    for name in graph.dead:
        cause = "it was killed, or its machine is gone; rosnode cleanup makes the master forget it"
        yield Finding(Severity.FAULT, name, "is known to the master but does not answer", cause)


def check_inputs(graph: Graph) -> Iterator[Finding]:
    """Does each topic that is read bring what it should?"""
    for topic in graph.topics.values():
        if topic.wanted:
            yield from _input(graph, topic)


def _input(graph: Graph, topic: Topic) -> Iterator[Finding]:
    readers = ", ".join(topic.readers)
    if not topic.publishers:
        yield _unpublished(graph, topic, readers)
        return
    if topic.type not in (topic.wanted, "*"):
        cause = f"{readers} wants {topic.wanted}: another topic is meant, remap it"
        yield Finding(Severity.FAULT, topic.name, f"is of type {topic.type}", cause)
        return
    if not topic.count:
        if topic.wanted == "geometry_msgs/Twist":
            return  # nobody drives now
        who = ", ".join(topic.publishers)
        cause = f"{who} has it open but says nothing: is the device on, its cable in?"
        needed = _is_missed(graph, topic)
        severity = Severity.FAULT if needed else Severity.NOTE
        yield Finding(severity, topic.name, "is silent", cause)
        return
    yield from _rate(graph, topic)
    yield from _stamps(topic)
    if len(topic.publishers) > 1 and topic.wanted != "tf2_msgs/TFMessage":
        who = ", ".join(topic.publishers)
        cause = "two drivers, or one left over from an earlier start: stop one, or remap it"
        yield Finding(Severity.WARNING, topic.name, f"has several publishers: {who}", cause)
    if topic.empty_share > EMPTY:
        cause = "a covered lens, a sensor in a wall, or its range_min set above everything"
        yield Finding(Severity.FAULT, topic.name, "brings scans without one return", cause)


def _unpublished(graph: Graph, topic: Topic, readers: str) -> Finding:
    alike = [
        other.name
        for other in graph.topics.values()
        if other.type == topic.wanted and set(other.publishers) - {*topic.readers}
    ]
    missed = _is_missed(graph, topic)
    cause = "is its driver running?" if missed else "it does without for now."
    if alike:
        cause += f" Of that type there are: {', '.join(sorted(alike)[:5])}: is one of them meant?"
    severity = Severity.FAULT if missed else Severity.NOTE
    return Finding(severity, topic.name, f"nobody publishes it; {readers} would read it", cause)


def _is_missed(graph: Graph, topic: Topic) -> bool:
    """Whether a reader says that it waits for it: only that one knows what it can do without."""
    return any(
        topic.name in text
        for name in topic.readers
        for text in [graph.diagnostics.get(name, (0, ""))[1]]
    )


def _rate(graph: Graph, topic: Topic) -> Iterator[Finding]:
    sensor = sensors(graph).get(topic.name)
    nominal = sensor.rate if sensor else LEAST_RATE.get(topic.type, 0.0) / SLOW
    if topic.rate < SLOW * nominal:
        what = f"comes at {topic.rate:.1f} Hz, {nominal:.1f} Hz are expected"
        if not sensor:
            what = f"comes at {topic.rate:.1f} Hz, {SLOW * nominal:.0f} Hz are needed"
        cause = (
            "a loaded machine, a full network (depth images over wireless), a driver's own setting"
        )
        yield Finding(Severity.WARNING, topic.name, what, cause)


def _stamps(topic: Topic) -> Iterator[Finding]:
    if topic.age > OLD:
        cause = (
            "clocks of two computers differ (chronyc tracking), or it waits in a queue: a full "
            "network, a driver that stamps with the device's own clock"
        )
        what = f"is {topic.age:.2f} s old when it comes"
        yield Finding(Severity.FAULT, topic.name, what, cause)
    if topic.age < -AHEAD:
        cause = "the clock of its computer is ahead of this one's: run chrony on both"
        what = f"is stamped {-topic.age:.2f} s in the future"
        yield Finding(Severity.FAULT, topic.name, what, cause)


def check_frames(graph: Graph) -> Iterator[Finding]:
    """Is all in one tree, and where the yaml says?"""
    yield from _odometry(graph)
    for topic in graph.topics.values():
        if not topic.wanted or not topic.frames:
            continue
        if len(topic.frames) > 1:
            cause = "two sensors on one topic: give each its own"
            what = f"comes in different frames: {', '.join(topic.frames)}"
            yield Finding(Severity.FAULT, topic.name, what, cause)
        for name in topic.frames:
            yield from _frame(graph, topic, name)


def _odometry(graph: Graph) -> Iterator[Finding]:
    base = graph.frames.get(graph.base_frame)
    if base is None:
        return
    subject = f"{graph.odom_frame} -> {graph.base_frame}"
    if base.error:
        cause = (
            f"the base's driver or robot_localization publishes it, if so told. tf: {base.error}"
        )
        yield Finding(Severity.FAULT, subject, "tf has no way between them", cause)
    elif base.age > LATE_TF:
        cause = "odometry comes late or rarely: every measurement waits for it"
        what = f"the newest transform is {base.age:.2f} s old"
        yield Finding(Severity.FAULT, subject, what, cause)


def _frame(graph: Graph, topic: Topic, name: str) -> Iterator[Finding]:
    if not name:
        cause = "its driver has a parameter frame_id that is not set"
        yield Finding(Severity.FAULT, topic.name, "has no frame_id", cause)
        return
    if name == graph.base_frame:
        return
    frame = graph.frames.get(name)
    if frame is None or frame.T_base_frame is None:
        cause = "no static_transform_publisher or robot_state_publisher tells where it is mounted"
        if frame and frame.error:
            cause += f". tf: {frame.error}"
        what = f"is in frame {name}, to which tf knows no way from {graph.base_frame}"
        yield Finding(Severity.FAULT, topic.name, what, cause)
        return
    sensor = sensors(graph).get(topic.name)
    if sensor is None:
        return
    if name != sensor.frame:
        cause = f"robot yaml: frame of {sensor.name}"
        what = f"is in frame {name}, the robot's yaml says {sensor.frame}"
        yield Finding(Severity.WARNING, topic.name, what, cause)
    yield from _mounting(topic, sensor, frame.T_base_frame)


def _mounting(topic: Topic, sensor: Sensor, T: np.ndarray) -> Iterator[Finding]:
    told = sensor.pose_in_base()
    moved = float(np.linalg.norm(T[:3, 3] - told[:3, 3]))
    turned = math.acos(float(np.clip(0.5 * (np.trace(T[:3, :3].T @ told[:3, :3]) - 1.0), -1, 1)))
    if moved <= MOVED and turned <= TURNED:
        return
    cause = "one of them was measured wrongly; tf counts, the yaml is for simulation and tools"
    if isinstance(sensor, CameraModel) and abs(turned - 2.0 * math.pi / 3.0) < 0.2:
        cause = (
            "the image's frame is no optical one (REP 103: z ahead, x right): use *_optical_frame"
        )
    elif isinstance(sensor, LidarModel) and abs(turned - math.pi) < 0.1:
        cause = "it is mounted upside down or backwards, and only one of tf and yaml says so"
    off = f"{100 * moved:.0f} cm and {math.degrees(turned):.0f} deg"
    what = f"tf has {sensor.name} {off} off the robot's yaml"
    yield Finding(Severity.FAULT, topic.name, what, cause)


def check_command(graph: Graph) -> Iterator[Finding]:
    """Does the separation monitor sit between planner and base?"""
    for monitor in (name for name in graph.nodes if name.endswith("/separation_monitor")):
        for topic in graph.topics.values():
            if topic.type != "geometry_msgs/Twist" or monitor not in topic.publishers:
                continue
            others = [name for name in topic.publishers if name != monitor]
            if others:
                cause = "they drive past it: remap their cmd_vel to what separation_monitor reads"
                what = f"is also published by {', '.join(others)}"
                yield Finding(Severity.FAULT, topic.name, what, cause)


def check_clock(graph: Graph) -> Iterator[Finding]:
    """Is there one time?"""
    clock = graph.clock
    if clock.simulated and not clock.publishers:
        cause = "left over from a simulation: rosparam set use_sim_time false, start the nodes anew"
        yield Finding(
            Severity.FAULT, "/clock", "use_sim_time is set and nobody publishes it", cause
        )
    elif clock.simulated and clock.advanced < 0.01:
        cause = "the simulation or the bag is paused, or it is at its end"
        yield Finding(Severity.FAULT, "/clock", "stands still", cause)
    elif clock.publishers and not clock.simulated:
        cause = "rosparam set use_sim_time true before the nodes start, or stop the bag's --clock"
        what = f"{', '.join(clock.publishers)} publishes it, and use_sim_time is not set"
        yield Finding(Severity.WARNING, "/clock", what, cause)


def check_parameters(graph: Graph) -> Iterator[Finding]:
    """Do the nodes agree with each other and with what comes?"""
    outlines: dict[str, list[str]] = {}
    for node, values in graph.parameters.items():
        outline = values.get("footprint")
        if outline and not values.get("robot_radius"):
            outlines.setdefault(str(outline), []).append(node)
    if len(outlines) > 1:
        said = "; ".join(f"{', '.join(nodes)}: {outline}" for outline, nodes in outlines.items())
        cause = "one robot has one: &footprint and *footprint in its yaml"
        yield Finding(Severity.FAULT, "footprint", f"differs between nodes. {said}", cause)
    for node, values in graph.parameters.items():
        for source in values.get("sources") or ():
            yield from _source(graph, node, source)
        yield from _reaction(graph, node, values)


def _source(graph: Graph, node: str, source: Mapping[str, Any]) -> Iterator[Finding]:
    name = graph.resolved(str(source.get("topic") or source.get("name")))
    topic, timeout = graph.topics.get(name), float(source.get("timeout", 0.5))
    if topic and topic.count > 1 and topic.rate * timeout < 2.0:
        what = f"comes at {topic.rate:.1f} Hz; {node} gives it up after {timeout:g} s of silence"
        cause = (
            "one message that is lost makes it blind there: a faster sensor, or a larger timeout"
        )
        yield Finding(Severity.WARNING, name, what, cause)


def _reaction(graph: Graph, node: str, values: Mapping[str, Any]) -> Iterator[Finding]:
    reaction = values.get("reaction_time")
    if not node.endswith("/separation_monitor") or not isinstance(reaction, (int, float)):
        return
    for topic in graph.topics.values():
        if topic.wanted == "safe_passage/TrackedObstacleArray" and topic.count > 1:
            takes = float(np.percentile(topic.ages, 95)) + 1.0 / topic.rate if topic.ages else 0.0
            if takes > reaction:
                what = (
                    f"reaction_time is {reaction:g} s, but tracks alone take {takes:.2f} s (95 %)"
                )
                cause = "too short is unsafe: measure it, docs/new_robot.md, step 8"
                yield Finding(Severity.FAULT, node, what, cause)


def check_diagnostics(graph: Graph) -> Iterator[Finding]:
    """What do the nodes say of themselves?"""
    for node, (level, message) in graph.diagnostics.items():
        if level > 0:
            severity = Severity.FAULT if level > 1 else Severity.WARNING
            yield Finding(severity, node, f"says: {message}", "see /diagnostics for its counts")


def sensors(graph: Graph) -> dict[str, Sensor]:
    """Those of the robot's yaml by the topics that they publish."""
    if graph.robot is None:
        return {}
    found: dict[str, Sensor] = {graph.resolved(one.topic): one for one in graph.robot.lidars}
    for camera in graph.robot.cameras:
        for topic in (camera.image, camera.depth, camera.points):
            found[graph.resolved(topic)] = camera
    return found


CHECKS: tuple[Check, ...] = (
    check_nodes,
    check_clock,
    check_command,
    check_inputs,
    check_frames,
    check_parameters,
    check_diagnostics,
)
