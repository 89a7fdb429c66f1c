"""What the camera calibration answers, and shows: the paper's Fig. 2 for rviz."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Sequence

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from scipy.spatial import cKDTree
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from safe_passage.calibration import ArmView, Calibration, Verdict
from safe_passage.calibration.arm_surface import ArmSurface
from safe_passage.calibration.writers import T_BODY_OPTICAL
from safe_passage.msg import CalibrateCameraResult
from safe_passage.robot_model import PinholeCamera, RobotModel
from safe_passage.ros.conversions import to_cloud, to_header, to_transform

GREEN, ORANGE = (44, 160, 44), (14, 127, 255)  # bgr of sensor and reference
MARGIN = 0.15  # [m] from the arm within which the sensor's points are shown
SHOWN = 25_000  # points of a cloud, so few that one lets the other show
STEP = 2  # [px] of the reference that is shown
LETTERS = 0.06  # [m]
WIDTH = 36  # letters in a line
LEGEND = "sensor green, model orange"


class CalibrationOutputs:
    """Sensor and reference, before and after; latched: who comes later sees what holds now.

    Args:
        before_frame: tf frame that "before" is drawn in, beside the robot.
        apart: [m] by which it is beside, seen from the camera to the left.
        view_frame: tf frame between the two, z up, x towards the camera: to look at both from.
    """

    def __init__(self, before_frame: str, apart: float, view_frame: str) -> None:
        self._before_frame, self._apart, self._view_frame = before_frame, apart, view_frame
        self._clouds = {
            name: rospy.Publisher(f"~{name}", PointCloud2, queue_size=1, latch=True)
            for name in ("before/sensor", "before/reference", "after/sensor", "after/reference")
        }
        self._labels = rospy.Publisher("~labels", MarkerArray, queue_size=1, latch=True)
        self._broadcaster = tf2_ros.StaticTransformBroadcaster()

    def clear(self, root: str) -> None:
        """Nothing is shown of an older calibration."""
        header = to_header(rospy.Time.now(), root)
        for publisher in self._clouds.values():
            publisher.publish(_coloured(header, np.empty((0, 3)), GREEN))
        self._labels.publish([Marker(header=header, action=Marker.DELETEALL)])

    def show(
        self,
        model: RobotModel,
        camera: PinholeCamera,
        views: Sequence[ArmView],
        result: Calibration,
        root: str,
    ) -> None:
        """All poses in one: as the guess has it, and as the calibration has it."""
        now = rospy.Time.now()
        beside = -self._apart * _level(result.T_initial[:3, 0])
        surface = ArmSurface(model, camera, STEP)
        titles = "BEFORE (the guess)", f"AFTER ({result.why})"
        shown, arms = [], []
        for name, frame, T, title in zip(
            ("before", "after"),
            (self._before_frame, root),
            (result.T_initial, result.T_root_camera),
            titles,
        ):
            reference = np.concatenate([surface.visible(v.positions, T).points for v in views])
            sensor = np.concatenate([camera.points(v.depth) for v in views])
            sensor = _near(sensor @ T[:3, :3].T + T[:3, 3], reference)
            shown.append((to_header(now, frame), name, sensor, reference, title))
            arms.append(_middle(reference))
        surface.close()
        middle = np.mean([arms[0] + beside, arms[1]], axis=0)
        self._broadcaster.sendTransform(
            [
                to_transform(to_header(now, root), self._before_frame, beside),
                to_transform(to_header(now, root), self._view_frame, middle, _facing(result)),
            ]
        )
        # after their frames: rviz drops what comes before
        for header, name, sensor, reference, _ in shown:
            self._clouds[f"{name}/sensor"].publish(_coloured(header, sensor, GREEN))
            self._clouds[f"{name}/reference"].publish(_coloured(header, reference, ORANGE))
        self._labels.publish(
            [
                _label(header, number, reference, f"{textwrap.fill(title, WIDTH)}\n{LEGEND}")
                for number, (header, _, _, reference, title) in enumerate(shown)
            ]
        )


def to_result(
    result: Calibration, parent: str, child: str, child_is_optical: bool, files: Sequence[Path]
) -> CalibrateCameraResult:
    """The answer to a goal; its transform may be used only where it is a success."""
    T = result.T_root_camera
    T = T if child_is_optical else T @ np.linalg.inv(T_BODY_OPTICAL)
    answer = CalibrateCameraResult(
        success=result.verdict is Verdict.OK,
        verdict=result.verdict.name,
        why=result.why,
        rms=result.rms,
        inliers=result.inliers,
        pose_rms=[one.rms for one in result.residuals],
        pose_inliers=[one.inliers for one in result.residuals],
        files=[str(path) for path in files],
    )
    answer.transform = to_transform(to_header(rospy.Time.now(), parent), child, T[:3, 3], T[:3, :3])
    if result.observability is not None:
        answer.weakest = result.observability.weakest
        answer.eigenvalues = list(result.observability.eigenvalues)
    return answer


def _level(direction: np.ndarray) -> np.ndarray:
    """Unit (3,), without its part upwards; 0 where it has no other."""
    level = direction * [1.0, 1.0, 0.0]
    return level / max(float(np.linalg.norm(level)), 1e-9)


def _facing(result: Calibration) -> np.ndarray:
    """(3, 3) z up, x towards where the camera was thought to be."""
    right = _level(result.T_initial[:3, 0])
    up = np.array([0.0, 0.0, 1.0])
    if not right.any():  # it lies on its side: any direction does
        return np.eye(3)
    return np.stack([np.cross(right, up), right, up], axis=1)


def _middle(arm: np.ndarray) -> np.ndarray:
    """(3,) of the box around it."""
    return 0.5 * (arm.min(axis=0) + arm.max(axis=0)) if len(arm) else np.zeros(3)


def _near(points: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """Those around the arm; all where the camera looks away from it."""
    if not len(arm):
        return points
    low, high = arm.min(axis=0) - MARGIN, arm.max(axis=0) + MARGIN
    points = points[((points > low) & (points < high)).all(axis=1)]
    return points[np.isfinite(cKDTree(_thin(arm)).query(points, distance_upper_bound=MARGIN)[0])]


def _thin(points: np.ndarray) -> np.ndarray:
    return points[:: -(-len(points) // SHOWN) or 1]


def _coloured(header: Header, points: np.ndarray, bgr: tuple[int, int, int]) -> PointCloud2:
    points = _thin(points)
    colours = np.broadcast_to(np.array(bgr, np.uint8), (1, len(points), 3))
    return to_cloud(header, points[None].astype(np.float32), colours)


def _label(header: Header, number: int, arm: np.ndarray, text: str) -> Marker:
    """Over the arm."""
    place = [0.0, 0.0, 1.0]
    if len(arm):
        place = [*arm[:, :2].mean(axis=0), arm[:, 2].max() + 3 * LETTERS]
    return Marker(
        header=header,
        ns="titles",
        id=number,
        type=Marker.TEXT_VIEW_FACING,
        pose=Pose(Point(*place), Quaternion(0, 0, 0, 1)),
        scale=Vector3(0, 0, LETTERS),
        color=ColorRGBA(0.1, 0.1, 0.1, 1.0),
        text=text,
    )
