"""Depth cameras at three times their rate: who reads them drops the oldest, says so, recovers.

The robot is the omnirob: self-filter -> detector and tracker, a second camera's clouds -> tracker.
`python3 -m bench.soak_cameras ROWS.json [--quick]`, started by soak.py. Ages are in simulated time:
from a message's stamp until its result is here, so this process' own delay is in them.
"""

from __future__ import annotations

import json
import struct
import sys
import threading
import time
from pathlib import Path

import rospy
from rosgraph_msgs.msg import Clock
from safe_passage.msg import TrackedObstacleArray
from sensor_msgs.msg import CameraInfo, Image, PointCloud2

from bench.metric import metric
from bench.soak_robot import Nodes, percentile, simulated

OURS = ("depth_self_filter", "person_detector", "obstacle_tracker", "separation_monitor")
DEPTH, FILTERED = "depth_registered/image_rect", "depth_filtered/image_rect"
PERSONS, TRACKS = "persons", "tracks"
PASSAGES = {"filter": (DEPTH, FILTERED), "detector": (FILTERED, PERSONS)}  # what goes in and out
CAMERAS = {  # topics that the nodes read of the robot's two cameras
    DEPTH: Image,
    "rgb/image_rect_color": Image,
    "rgb/camera_info": CameraInfo,
    "camera_rear/depth_registered/points": PointCloud2,
}
WARM_UP = 15.0  # [s] of the wall, as all these
CALM, CALM_QUICK = 30.0, 10.0
OVERLOAD, OVERLOAD_QUICK = 60.0, 15.0
RECOVERY = 20.0
IN_FLIGHT = 1.0  # [s] simulated: younger messages may still be on their way
PERIOD_NS = 100_000_000  # of the robot's cameras
TIMES = 3
MAX_AGE = 500  # [ms] what is older the tracker refuses
BUFFER = 2**24  # bytes: a cloud has 5 MB


class Crowd:
    """Copies of each of the cameras' messages, at their time between it and the next."""

    def __init__(self) -> None:
        self.on = False
        self._lock = threading.Lock()
        self._due: list[tuple[int, rospy.Publisher, rospy.Message]] = []  # [ns]
        for topic, kind in CAMERAS.items():
            # What was received is sent on as it is, but for the stamp: nothing is parsed.
            raw = type("Raw", (kind,), {"serialize": _write, "_has_header": False})
            publisher = rospy.Publisher(topic, kind, queue_size=10)
            rospy.Subscriber(
                topic, rospy.AnyMsg, self._on_message, (publisher, raw), buff_size=BUFFER
            )
        rospy.Subscriber("/clock", Clock, self._on_clock)

    def _on_message(self, message: rospy.AnyMsg, to: tuple[rospy.Publisher, type]) -> None:
        if not self.on or message._connection_header["callerid"] == rospy.get_name():
            return
        publisher, raw = to
        stamp = _stamp(message)
        for k in range(1, TIMES):
            due = stamp + k * PERIOD_NS // TIMES
            copy, bytes_ = raw(), bytearray(message._buff)
            struct.pack_into("<II", bytes_, 4, *divmod(due, 10**9))
            copy.raw = bytes_
            with self._lock:
                self._due.append((due, publisher, copy))

    def _on_clock(self, clock: Clock) -> None:
        now = clock.clock.to_nsec()
        with self._lock:
            due = [one for one in self._due if one[0] <= now]
            self._due = [one for one in self._due if one[0] > now]
        for _, publisher, copy in sorted(due, key=lambda one: one[0]):
            publisher.publish(copy)


class Chain:
    """Which images come, which come out of the filter and the detector, and how old all is then."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._seen: dict[str, dict[float, float]] = {}  # topic -> stamp -> age when it came [s]
        self._blind: list[float] = []  # stamps of tracks that lack a sensor
        for topic in (DEPTH, FILTERED, PERSONS, TRACKS):
            self._seen[topic] = {}
            rospy.Subscriber(topic, rospy.AnyMsg, self._on_any, topic, buff_size=BUFFER)

    def _on_any(self, message: rospy.AnyMsg, topic: str) -> None:
        stamp = 1e-9 * _stamp(message)
        with self._lock:
            self._seen[topic][stamp] = rospy.get_time() - stamp
            if topic == TRACKS and not all(_tracks(message).alive):
                self._blind.append(stamp)

    def count(self, topic: str, begin: float, end: float) -> int:
        """Messages stamped between [s]."""
        with self._lock:
            return sum(begin <= stamp < end for stamp in self._seen[topic])

    def not_out(self, into: str, out: str, begin: float, end: float) -> int:
        """Of those stamped between that went in, how many did not come out."""
        with self._lock:
            return sum(begin <= s < end and s not in self._seen[out] for s in self._seen[into])

    def ages(self, topic: str, begin: float, end: float) -> list[float]:
        """[ms], of those stamped between [s], in their order."""
        with self._lock:
            pairs = sorted(self._seen[topic].items())
        return [1e3 * age for stamp, age in pairs if begin <= stamp < end]

    def blind(self, begin: float, end: float) -> int:
        """Messages of tracks, stamped between, that told of a sensor that is not alive."""
        return sum(begin <= stamp < end for stamp in list(self._blind))


def run(quick: bool) -> list[dict]:
    """All rows, of the robot that runs."""
    nodes, chain, crowd = Nodes(OURS), Chain(), Crowd()
    rospy.wait_for_message(PERSONS, rospy.AnyMsg, 60.0)
    nodes.watch(WARM_UP, "cameras, warm-up")
    begin = rospy.get_time()
    nodes.watch(CALM_QUICK if quick else CALM, "cameras, calm")
    calm = begin, rospy.get_time() - IN_FLIGHT
    told = _told(nodes)
    nodes.memory.clear()
    begin, wall = rospy.get_time(), time.monotonic()
    crowd.on = True
    nodes.watch(OVERLOAD_QUICK if quick else OVERLOAD, "cameras, overload")
    crowd.on = False
    over, took = (begin, rospy.get_time() - IN_FLIGHT), time.monotonic() - wall
    growth = nodes.growth()
    nodes.watch(0.5 * RECOVERY, "cameras, recovery")
    begin, told_by_now = rospy.get_time(), _told(nodes)
    nodes.watch(0.5 * RECOVERY, "cameras, recovery")
    after = begin, rospy.get_time() - IN_FLIGHT
    told_after = sum(_told(nodes).values()) - sum(told_by_now.values())
    during = {name: told_by_now[name] - told[name] for name in told}
    not_out = {name: chain.not_out(*passage, *over) for name, passage in PASSAGES.items()}
    untold = sum(max(0, not_out[name] - during[name]) for name in PASSAGES)
    return [
        metric("overload_camera_real_time_factor", (over[1] + IN_FLIGHT - over[0]) / took, ""),
        *_degraded(chain, calm, over),
        *(metric(f"overload_camera_{name}_not_out", n, "images") for name, n in not_out.items()),
        *(
            metric(f"overload_camera_{name}_told_drops", n, "messages")
            for name, n in during.items()
        ),
        metric("overload_camera_untold", untold, "images", "= 0"),
        metric("overload_camera_rss_growth_mb", max(growth.values()), "MB"),
        *_recovered(chain, after, told_after),
    ]


def _told(nodes: Nodes) -> dict[str, int]:
    """What the nodes say they have dropped of the cameras', until now."""
    return {
        "filter": nodes.drops("depth_self_filter", "image_rect"),
        "detector": nodes.drops("person_detector", "image_rect"),
        "tracker": nodes.drops("obstacle_tracker", "points"),
    }


def _degraded(chain: Chain, calm: tuple[float, float], over: tuple[float, float]) -> list[dict]:
    """What comes out under overload, and how old it is."""
    ages = chain.ages(FILTERED, *over)
    third = max(len(ages) // 3, 1)
    drift = percentile(ages[-third:], 95) / percentile(ages[:third], 95)
    images = chain.count(DEPTH, *over)
    return [
        metric("overload_camera_hz", images / max(over[1] - over[0], 1e-3), "Hz"),
        metric("overload_camera_images", images, "images"),
        metric("overload_camera_calm_age_p99_ms", _p99(chain, FILTERED, calm), "ms"),
        metric("overload_camera_age_p99_ms", _p99(chain, FILTERED, over), "ms", f"<= {MAX_AGE}"),
        metric("overload_camera_age_drift", drift, ""),
        metric("overload_camera_persons_age_p99_ms", _p99(chain, PERSONS, over), "ms"),
        metric("overload_camera_tracks_age_p99_ms", _p99(chain, TRACKS, over), "ms"),
        metric("overload_camera_blind_tracks", chain.blind(*over), "messages"),
    ]


def _recovered(chain: Chain, after: tuple[float, float], told: int) -> list[dict]:
    """At their own rate again, from half of RECOVERY on."""
    lost = sum(chain.not_out(*passage, *after) for passage in PASSAGES.values())
    prefix = "overload_camera_recovered_"
    return [
        metric(prefix + "hz", chain.count(DEPTH, *after) / max(after[1] - after[0], 1e-3), "Hz"),
        metric(prefix + "not_out", lost, "images", "= 0"),
        metric(prefix + "told_drops", told, "messages", "= 0"),
        metric(prefix + "age_p99_ms", _p99(chain, FILTERED, after), "ms"),
        metric(prefix + "blind_tracks", chain.blind(*after), "messages", "= 0"),
    ]


def _p99(chain: Chain, topic: str, window: tuple[float, float]) -> float:
    """[ms] of age."""
    return percentile(chain.ages(topic, *window), 99)


def _stamp(message: rospy.AnyMsg) -> int:
    """[ns] of a message that begins with a header: its number, then seconds and nanoseconds."""
    seconds, nanoseconds = struct.unpack_from("<II", message._buff, 4)
    return seconds * 10**9 + nanoseconds


def _tracks(message: rospy.AnyMsg) -> TrackedObstacleArray:
    return TrackedObstacleArray().deserialize(message._buff)


def _write(message: rospy.Message, out) -> None:
    out.write(message.raw)


if __name__ == "__main__":
    with simulated("omnirob"):
        found = run("--quick" in sys.argv)
    Path(sys.argv[1]).write_text(json.dumps(found))
