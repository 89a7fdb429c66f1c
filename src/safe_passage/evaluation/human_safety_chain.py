"""The human safety chain without ROS: what detector, merger and costmap nodes do, in a row."""

from __future__ import annotations

from typing import Any, Mapping, Sequence

import numpy as np

import safe_passage._person_detection as detection
import safe_passage._safety_area as safety
from safe_passage.core.geometry import Pose, compose, inverse, placed
from safe_passage.core.grid import GridMap
from safe_passage.costmap import (
    LocalCostmap,
    Observation,
    load_costmap_parameters,
    project_scan,
)
from safe_passage.costmap.costs import LETHAL_OBSTACLE
from safe_passage.evaluation.person_tracker import PersonTracker
from safe_passage.evaluation.tracking_runs import scan_measurement
from safe_passage.human_safety.models import default_folder
from safe_passage.monitoring.aggregation import Measurement
from safe_passage.monitoring.person_looks import Look, View
from safe_passage.simulation.robots import CameraModel, LidarModel

RADIUS = 1.35  # [m] 1.2, and what the person's place and the costmap's cells may be off by
CLEARANCE = 0.05  # [m] as in the robots' files
LASER_HOLD_TIME = 120.0  # [s] that the laser may keep a person whom the camera no longer sees
TRACKER_HOLD_TIME = 1.0  # [s] that a person is remembered, where the tracker tells where he is
VIEW = (0.95, 1.5, 5.0)  # [rad], [m], [m] of the camera, as in the robots' files
SURE = 0.9  # probability of who was found


def make_detector(method: str) -> detection.PersonDetector:
    """The detector with the node's defaults; `method`: hog or yolo."""
    parameters = detection.DetectorParameters()
    parameters.method = getattr(detection.Method, method.upper())
    parameters.yolo.model = str(default_folder() / "yolov3-tiny.weights")
    return detection.PersonDetector(parameters)


class HumanSafetyChain:
    """RGB-D frames and scans in, lethal cells out; frame odom.

    Args:
        method: hog or yolo; none: no person is ever seen, as if there were no safety area.
        costmap: contents of config/local_costmap.yaml.
        hold_time: [s] that a person is remembered.
        footprint: of the robot, [m] base; areas end CLEARANCE before it.
        tracker: of whom the camera no longer sees; None: the laser keeps him, see LASER_HOLD_TIME.
    """

    def __init__(
        self,
        method: str,
        costmap: Mapping[str, Any],
        hold_time: float,
        footprint: Sequence[tuple[float, float]],
        tracker: PersonTracker | None = None,
    ) -> None:
        self._detector = None if method == "none" else make_detector(method)
        parameters = safety.PipelineParameters()
        memory = safety.MemoryParameters()
        memory.hold_time = TRACKER_HOLD_TIME if tracker else hold_time
        memory.laser_hold_time = 0.0 if tracker else LASER_HOLD_TIME
        area = safety.AreaParameters()
        area.radius = RADIUS
        parameters.area = area
        parameters.memory = memory
        merge = safety.MergeParameters()
        merge.clearance = CLEARANCE
        parameters.merge = merge
        self._footprint = np.array(footprint, float).reshape(-1, 2)
        self._merger = safety.Pipeline(parameters)
        self._tracker = tracker
        self._scans: list[Measurement] = []  # since its last cycle
        self._looks: list[Look] = []
        self.remembered = np.empty((0, 2))  # [m] persons with an area in the last scan, frame odom
        self.costmap = LocalCostmap(load_costmap_parameters(costmap).parameters)
        layer = next(p["name"] for p in costmap["plugins"] if "Obstacle" in p["type"])
        self._key = (layer, costmap[layer]["observation_sources"].split()[0])

    def see(
        self, depth: np.ndarray, bgr: np.ndarray, camera: CameraModel, pose: Pose, time: float
    ) -> np.ndarray:
        """Detect and remember persons.

        depth (H, W) [m], bgr (H, W, 3), taken at `time` [s] with the robot at `pose`.
        Returns: (N, 2) [m] where they stand, frame odom.
        """
        if self._detector is None:
            return np.empty((0, 2))
        frame = detection.from_depth(depth, bgr, detection.Intrinsics(*camera.intrinsics))
        T = camera.pose_in_base()
        seed = detection.GroundPlane(T[2, :3], camera.z)
        result = self._detector.detect(frame, seed)
        heads = [d.candidate.head for d in result.detections if d.accepted]
        under_camera = compose(pose, (camera.x, camera.y, camera.yaw))
        places = [compose(under_camera, (float(h[0]), float(h[1]), 0.0)) for h in heads]
        self._merger.remember([safety.Person(time, [p[0], p[1], 0.0]) for p in places])
        found = np.array(places).reshape(-1, 3)[:, :2]
        if self._tracker:
            view = View(under_camera[:2], under_camera[2], *VIEW)
            self._looks.append(Look(time, found, np.full(len(found), SURE), view))
        return found

    def hear(self, ranges: np.ndarray, lidar: LidarModel, pose: Pose, time: float) -> None:
        """Ranges (N,) [m] for the tracker."""
        if self._tracker:
            source = self._tracker.source
            self._scans.append(scan_measurement(lidar, ranges, source, time, pose))

    def _track(self, pose: Pose, time: float) -> None:
        if self._tracker:
            persons = self._tracker.update(time, pose, self._scans, self._looks)
            self._merger.remember(persons)
            self._scans, self._looks = [], []

    def merge(self, ranges: np.ndarray, lidar: LidarModel, pose: Pose, time: float) -> np.ndarray:
        """Ranges (N,) [m] with the safety areas in them, after a cycle of the tracker."""
        self._track(pose, time)
        step = lidar.field_of_view / (lidar.beams - 1)
        half = 0.5 * lidar.field_of_view
        scan = safety.Scan(ranges, -half, half, step, lidar.range_min, lidar.range_max)
        x, y, yaw = compose(pose, (lidar.x, lidar.y, lidar.yaw))
        c, s = np.cos(yaw), np.sin(yaw)
        T_odom_laser = np.array([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, lidar.z], [0, 0, 0, 1.0]])
        laser = safety.LaserPose(np.linalg.inv(T_odom_laser))
        outline = placed(self._footprint, inverse((lidar.x, lidar.y, lidar.yaw)))
        merged = self._merger.merge(scan, time, laser, outline)
        self.remembered = np.array([p.position[:2] for p in merged.persons]).reshape(-1, 2)
        return np.asarray(merged.scan.ranges)

    def update(self, ranges: np.ndarray, lidar: LidarModel, pose: Pose, time: float) -> GridMap:
        """The costmap's lethal cells after a scan with `ranges` (N,) [m]."""
        step = lidar.field_of_view / (lidar.beams - 1)
        points = project_scan(
            ranges,
            -0.5 * lidar.field_of_view,
            step,
            lidar.range_min,
            lidar.range_max,
            inf_is_valid=True,
        )
        x, y, yaw = compose(pose, (lidar.x, lidar.y, lidar.yaw))
        c, s = np.float32(np.cos(yaw)), np.float32(np.sin(yaw))
        turned = points @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]], np.float32)
        seen = Observation(time, (x, y, lidar.z), turned + np.array((x, y, lidar.z), np.float32))
        update = self.costmap.update(pose, {self._key: [seen]}, time)
        return GridMap(update.costs == LETHAL_OBSTACLE, update.origin, update.resolution)
