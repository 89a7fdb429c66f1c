"""The safety area merger under faults: every scan comes out, none longer than it came in."""

from __future__ import annotations

import math

import numpy as np
import rospy
from geometry_msgs.msg import Point, Vector3
from node_testing import OPTICAL, transform
from safe_passage.msg import Person, PersonArray
from sensor_msgs.msg import LaserScan
from test_safety_area_merger import AHEAD, CAMERA_X, CAMERA_Z, LASER_X, person_at
from tf2_msgs.msg import TFMessage

from bench.fault_subject import Input, Seen, Sent, Stated, Subject, of

MERGED = "scan_human_aware"
BEAMS, OPEN = 181, 10.0  # one a degree; [m] where nobody is
PERSON_X = 3.0  # [m] the detector's person, ahead
TRACKED = 2.0, 4.0  # [m] the tracker's, to the left
HOLD = 1.0  # [s] safety_area_merger.yaml
RADIUS = 1.2  # [m]
NEAR = 0.03  # [m]
LEFT = AHEAD + round(math.degrees(math.atan2(TRACKED[1], TRACKED[0] - LASER_X)))
AREA_AHEAD = PERSON_X - LASER_X - RADIUS  # [m] ranges of the areas
AREA_LEFT = math.hypot(TRACKED[1], TRACKED[0] - LASER_X) - RADIUS


class SafetyAreaMergerSubject(Subject):
    """One person whom the detector sees, another whom only the tracker knows."""

    name = "safety_area_merger"
    launch = "safety_area_merger.launch"
    frames = frozenset({"laser", "no_such_frame"})  # a scan comes out as it came in
    without_number = frozenset(
        {
            "angle_min",
            "angle_max",
            "angle_increment",
            "time_increment",
            "scan_time",
            "range_min",
            "range_max",
            "ranges",
            "intensities",
        }
    )

    def __init__(self) -> None:
        self.outputs = {MERGED: LaserScan}
        scan_as_is = Stated(anything, told=True)
        seen_still = Stated(self.healthy, told=True)
        self.inputs = (
            Input("tf", "/tf", TFMessage, make_tf, HOLD, self._without(True, True)),
            Input(
                "scan",
                "scan",
                LaserScan,
                make_scan,
                0.0,
                nothing,
                stated={
                    "NaN": Stated(anything, told=True),
                    "empty": scan_as_is,
                    "truncated": Stated(anything, told=False),
                    "wrong frame": scan_as_is,
                    "stale": seen_still,
                    "future": seen_still,
                },
            ),
            Input(
                "persons",
                "persons",
                PersonArray,
                make_persons,
                HOLD,
                self._without(True, False),
                stated={"empty": Stated(self._without(True, False), told=False)},
            ),
            Input(
                "tracked_persons",
                "tracked_persons",
                PersonArray,
                make_tracked,
                HOLD,
                self._without(False, True),
                told=False,
            ),
        )

    def prepare(self) -> None:
        self._static = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        self._static.publish(
            [
                transform("base_link", "laser", rospy.Time(), LASER_X),
                transform("base_link", "camera", rospy.Time(), CAMERA_X, CAMERA_Z, OPTICAL),
            ]
        )

    def healthy(self, seen: Seen) -> str:
        return self._ranges(seen, AREA_AHEAD, AREA_LEFT)

    def _without(self, person: bool, tracked: bool):
        """Their areas are gone, scans pass."""

        def check(seen: Seen) -> str:
            return self._ranges(
                seen,
                OPEN if person else AREA_AHEAD,
                OPEN if tracked else AREA_LEFT,
            )

        return check

    def _ranges(self, seen: Seen, ahead: float, left: float) -> str:
        scans = of(MERGED, seen)
        if not scans:
            return "no scan"
        for scan in scans[-1:]:
            if len(scan.ranges) != BEAMS:
                return f"{len(scan.ranges)} beams"
            for beam, wanted in ((AHEAD, ahead), (LEFT, left), (0, OPEN)):
                if abs(scan.ranges[beam] - wanted) > NEAR:
                    return f"beam {beam}: {scan.ranges[beam]:.2f} m, not {wanted:.2f} m"
        return ""

    def wrong(self, seen: Seen, sent: list[Sent]) -> str:
        """A scan was lost, or a range became longer."""
        given = {one.message.header.stamp: one.message for one in sent if one.name == "scan"}
        for scan in of(MERGED, seen):
            raw = given.get(scan.header.stamp)
            if raw is None:
                continue
            if len(raw.ranges) != len(scan.ranges) or raw.header.frame_id != scan.header.frame_id:
                return "beams or frame of a scan have changed"
            before, after = np.array(raw.ranges), np.array(scan.ranges)
            if (after > before + 1e-5).any():
                return "a range became longer"
        came = {scan.header.stamp for scan in of(MERGED, seen)}
        lost = [stamp for stamp in list(given)[:-2] if stamp not in came]  # the last are under way
        return f"{len(lost)} of {len(given)} scans lost" if lost else ""


def nothing(seen: Seen) -> str:
    """Where no scan comes in, none comes out."""
    return "scans came out" if of(MERGED, seen) else ""


def anything(_: Seen) -> str:
    """What `wrong` says is all there is to say."""
    return ""


def make_tf(stamp: rospy.Time) -> TFMessage:
    """The robot stands; told a step ahead, for a scan that overtakes its tf has wider areas."""
    ahead = stamp + rospy.Duration.from_sec(Subject.tick)
    return TFMessage([transform("odom", "base_link", ahead)])


def make_scan(stamp: rospy.Time) -> LaserScan:
    """Nothing around."""
    scan = LaserScan(range_min=0.1, range_max=20.0, ranges=[OPEN] * BEAMS)
    scan.header.frame_id, scan.header.stamp = "laser", stamp
    scan.angle_min, scan.angle_max = -math.pi / 2, math.pi / 2
    scan.angle_increment = math.pi / (BEAMS - 1)
    return scan


def make_persons(stamp: rospy.Time) -> PersonArray:
    """The detector's."""
    message = PersonArray(persons=[person_at(PERSON_X)])
    message.header.frame_id, message.header.stamp = "camera", stamp
    return message


def make_tracked(stamp: rospy.Time) -> PersonArray:
    """The tracker's."""
    tracked = Person(id=7, position=Point(*TRACKED, 0.0), velocity=Vector3(0.0, 0.0, 0.0))
    message = PersonArray(persons=[tracked])
    message.header.frame_id, message.header.stamp = "odom", stamp
    return message
