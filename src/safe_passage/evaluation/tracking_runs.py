"""The tracker on recordings: parameters for a robot, and what it says in each cycle."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Mapping

import numpy as np

from safe_passage.core.geometry import Pose, rotation
from safe_passage.core.reading import build, build_list, read_yaml
from safe_passage.evaluation.tracking_recording import Raw, Recording
from safe_passage.monitoring.aggregation import Measurement
from safe_passage.monitoring.parameters import SourceParameters, TrackerParameters
from safe_passage.monitoring.pipeline import ObstacleTracker, Snapshot
from safe_passage.monitoring.preprocessing import cloud_points, scan_points
from safe_passage.monitoring.views import CloudView, ScanView
from safe_passage.simulation.robots import LidarModel

FRESH = 0.3  # [s] a track seen so long ago is said to be there, as a person is (truth)
# Each row of the ablation adds to the one before it.
ABLATION: Mapping[str, Mapping[str, object]] = {
    "baseline": {
        **{"composites": False, "splits": False, "free_space": False},
        **{"alignment": False, "aggregate": 1},
    },
    "+ composite and split": {"free_space": False, "alignment": False, "aggregate": 1},
    "+ shape alignment": {"free_space": False, "aggregate": 1},
    "+ aggregation": {"free_space": False},
    "+ free space": {},
}


@dataclass(frozen=True)
class Told:
    """The confirmed tracks that a tracker holds in a cycle; frame of the odometry."""

    id: np.ndarray  # (N,) int
    position: np.ndarray  # (N, 2) [m]
    velocity: np.ndarray  # (N, 2) [m/s]
    moving: np.ndarray  # (N,) bool
    fresh: np.ndarray  # (N,) bool: seen just now


def tracker_parameters(
    config: Path, changes: Mapping[str, Any] | None = None, name: str = "obstacle_tracker"
) -> TrackerParameters:
    """Those of the node's own yaml for the robot, but for `changes`.

    Args:
        config: folder of the package's parameters.
        changes: of TrackerParameters; `aggregate` is that of all scanners.
        name: of the yaml in that folder.

    Raises:
        ParameterError, InputError: as of any yaml.
    """
    parameters = tracker_of(read_yaml(config / f"{name}.yaml"), name)
    changed = dict(changes or {})
    if "aggregate" in changed:
        number = changed.pop("aggregate")
        changed["sources"] = tuple(
            source if source.three_dimensional else replace(source, aggregate=number)
            for source in parameters.sources
        )
    return replace(parameters, **changed)


def tracker_of(values: Mapping[str, Any], where: str) -> TrackerParameters:
    """The tracker's own of a node's `values`.

    Raises:
        ParameterError: as of any yaml.
    """
    known = {field.name for field in fields(TrackerParameters)}
    kept = {key: value for key, value in values.items() if key in known}
    kept["sources"] = build_list(SourceParameters, values.get("sources"), f"{where}/sources")
    return build(TrackerParameters, kept, where)


def scan_measurement(
    lidar: LidarModel, ranges: np.ndarray, source: SourceParameters, stamp: float, pose: Pose
) -> Measurement:
    """A scan (N,) [m] as the tracker takes it; taken at `stamp` [s], base at `pose` in odometry."""
    first, second = lidar.angles()[:2]
    points = scan_points(ranges, first, second - first, lidar.pose_in_base(), source)
    return Measurement(source.name, stamp, pose, points, ScanView.of(points, (lidar.x, lidar.y)))


def measurements(recording: Recording, parameters: TrackerParameters) -> list[list[Measurement]]:
    """The obstacle points of each cycle."""
    sources = {source.name: source for source in parameters.sources}
    robot = recording.scenario.robot
    lidars = {lidar.name: lidar for lidar in robot.lidars}
    cameras = {camera.name: camera for camera in robot.cameras}

    turning = recording.scenario.lidar3d
    rays: np.ndarray = turning.directions().astype(np.float32) if turning else np.empty((0, 3))
    T_base_turning = turning.pose_in_base() if turning else np.eye(4)

    def measurement(raw: Raw) -> Measurement:
        source = sources[raw.sensor]
        if raw.sensor in lidars:
            return scan_measurement(lidars[raw.sensor], raw.data, source, raw.stamp, raw.pose)
        if raw.sensor in cameras:
            pose = cameras[raw.sensor].pose_in_base()
            view = CloudView.of(raw.data, pose)
            points = cloud_points(raw.data, pose, source)
            return Measurement(raw.sensor, raw.stamp, raw.pose, points, view)
        returned = np.isfinite(raw.data)
        cloud = rays[returned] * raw.data[returned, None]
        points = cloud_points(cloud, T_base_turning, source)
        return Measurement(raw.sensor, raw.stamp, raw.pose, points)

    return [[measurement(raw) for raw in cycle] for cycle in recording.raw]


def follow(recording: Recording, parameters: TrackerParameters) -> list[Told]:
    """Run our tracker over a recording."""
    every = float(np.median(np.diff(recording.stamps)))
    return [told(one, int(FRESH / every)) for one in snapshots(recording, parameters)]


def snapshots(recording: Recording, parameters: TrackerParameters) -> list[Snapshot]:
    """All that our tracker knows in each cycle."""
    tracker = ObstacleTracker(parameters)
    cycles = zip(recording.stamps, recording.poses, measurements(recording, parameters))
    return [
        tracker.update(float(stamp), (float(x), float(y), float(yaw)), measured)
        for stamp, (x, y, yaw), measured in cycles
    ]


def told(snapshot: Snapshot, fresh_cycles: int) -> Told:
    """What of a snapshot is judged."""
    tracks = snapshot.tracks
    x, y, yaw = snapshot.pose
    turn = rotation(yaw).T  # of row vectors
    which = snapshot.confirmed
    return Told(
        tracks.id[which],
        tracks.position[which] @ turn + (x, y),
        tracks.velocity[which] @ turn,
        tracks.moving[which],
        tracks.misses[which] <= fresh_cycles,
    )
