"""The real recordings on which the obstacle tracker is judged, from bags."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Sequence

import numpy as np
from geometry_msgs.msg import PoseStamped

from safe_passage.core.errors import InputError
from safe_passage.core.geometry import Pose, compose, inverse, placed
from safe_passage.evaluation.scan_matching import match_scans
from safe_passage.evaluation.tracking_real import (
    CAME,
    LEGS,
    NOBODY,
    VEHICLE,
    RealRecording,
    RealScanner,
    pose_at,
)
from safe_passage.leg_detection.scan import Scan
from safe_passage.leg_detection.training_data import background_beams
from safe_passage.ros.bags import SCAN, read_bag, to_scan
from safe_passage.ros.conversions import planar_pose
from safe_passage.ros.leg_recordings import read_negative, read_positive

POSE = "geometry_msgs/PoseStamped"
SINGLE, BOTH = "obstacle_tracker_single_lidar", "obstacle_tracker"
LASER = "laser"  # as SINGLE calls its scanner
CAR = ((0.30, 0.15), (-0.18, 0.15), (-0.18, -0.15), (0.30, -0.15))  # [m] around its pose
ON_CAR = (-0.12, 0.0, 0.0)  # the scanner in the car's pose, as its authors' launch file has it
BESIDE = 8  # beams to both sides of those that meet the robot itself
CLEAR = 0.6  # [m] around the other car
MOUNTINGS = {  # of the robot with two scanners: topic -> as BOTH calls it, in base
    "/front_scan": ("laser_front", (0.23565, -0.0005, 0.0)),
    "/rear_scan": ("laser_rear", (-0.23832, 0.00542, math.pi)),
}


def read_tracking(folder: Path, names: Sequence[str] = ()) -> list[RealRecording]:
    """Those in `folder` that a tracker of scans can be judged by.

    Args:
        names: parts of the names of those that are wanted; none: all.

    Raises:
        InputError: no such folder, or something is not as it should be in a bag.
    """
    readers = {"lidar2d_legs": _legs, "lidar2d_two_scanners": _two, "lidar2d_vehicles": _vehicles}
    paths = [path for name in readers for path in sorted((folder / name).glob("*.bag"))]
    if not paths:
        raise InputError(f"{folder}: no bags in {', '.join(readers)}")
    wanted = [p for p in paths if not names or any(name in p.stem for name in names)]
    return [recording for path in wanted for recording in readers[path.parent.name](path)]


def _legs(path: Path) -> list[RealRecording]:
    if path.stem.startswith("positive"):
        recording = read_positive(path)
        scanner = RealScanner(LASER, recording.scans, legs=recording.legs)
        return [RealRecording(path.stem.replace("_extracted", ""), SINGLE, LEGS, (scanner,))]
    several = [recording.scans for recording in read_negative(path)]
    if path.stem.startswith("negative"):
        return [_empty_room(f"{path.stem} {name}", scans) for name, scans in zip("abc", several)]
    return [RealRecording(path.stem, SINGLE, CAME, (RealScanner(LASER, several[0]),))]


def _empty_room(name: str, scans: Sequence[Scan]) -> RealRecording:
    """The robot drives, nobody tells how: its scans do. What goes along with it is its own."""
    own = background_beams(scans).mean(axis=0) > 0.5
    own = np.convolve(own, np.ones(2 * BESIDE + 1), mode="same") > 0.0
    seen = [replace(scan, ranges=np.where(own, np.nan, scan.ranges)) for scan in scans]
    return RealRecording(name, SINGLE, NOBODY, (RealScanner(LASER, seen),), way=match_scans(seen))


def _two(path: Path) -> list[RealRecording]:
    _, messages = read_bag(path, (SCAN,))
    if set(messages) != set(MOUNTINGS):
        raise InputError(f"{path}: scans of {sorted(messages)}, not of {sorted(MOUNTINGS)}")
    scanners = tuple(
        RealScanner(name, [to_scan(one, path) for one in messages[topic]], mounting)
        for topic, (name, mounting) in MOUNTINGS.items()
    )
    return [RealRecording(path.stem, BOTH, CAME, scanners)]


def _vehicles(path: Path) -> list[RealRecording]:
    """Two cars, whose poses were measured from outside.

    The scans are stamped up to 0.3 s too late (one that has stopped still nears a wall), so the own
    pose is matched from scans, with the measured one as a guess; the other's is relative to it.
    """
    _, messages = read_bag(path, (SCAN, POSE))
    if not all(messages[topic] for topic in ("/scan", "/ego_pose", "/red_pose")):
        raise InputError(f"{path}: needs /scan, /ego_pose and /red_pose")
    measured, red = _way(messages["/ego_pose"]), _way(messages["/red_pose"])
    scans = [to_scan(message, path) for message in messages["/scan"]]
    scans = [scan for scan in scans if measured[0, 0] <= scan.stamp <= measured[-1, 0]]
    guess = [pose_at(measured, scan.stamp) for scan in scans]
    seen = [compose(inverse(at), pose_at(red, s.stamp)) for at, s in zip(guess, scans)]
    way = match_scans([_without(s, other) for s, other in zip(scans, seen)], ON_CAR, guess)
    other = [compose((x, y, yaw), at) for (_, x, y, yaw), at in zip(way, seen)]
    vehicle = np.column_stack([way[:, 0], np.array(other)])
    scanner = RealScanner(LASER, scans, ON_CAR)
    return [RealRecording(path.stem, SINGLE, VEHICLE, (scanner,), CAR, way, vehicle)]


def _without(scan: Scan, other: Pose) -> Scan:
    """The scan without the beams that met the car at `other`, frame base."""
    beams = np.stack([np.cos(scan.angles()), np.sin(scan.angles())], axis=1)
    ranges = np.where(scan.returns(), scan.ranges, np.nan)
    points = placed(beams * ranges[:, None], ON_CAR)
    return replace(scan, ranges=np.where(np.hypot(*(points - other[:2]).T) < CLEAR, np.nan, ranges))


def _way(messages: Sequence[PoseStamped]) -> np.ndarray:
    """(K, 4)"""
    way = [
        (
            message.header.stamp.to_sec(),
            *planar_pose(message.pose.position, message.pose.orientation),
        )
        for message in messages
    ]
    found = np.array(way).reshape(-1, 4)
    found[:, 3] = np.unwrap(found[:, 3])
    return found
