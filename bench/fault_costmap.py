"""The local costmap under faults: no map around an unknown place, no obstacle where nothing is."""

from __future__ import annotations

import threading

import numpy as np
import rospy
from geometry_msgs.msg import PolygonStamped
from map_msgs.msg import OccupancyGridUpdate
from nav_msgs.msg import OccupancyGrid
from node_testing import CostmapView, transform
from safe_passage.ros.conversions import to_header
from sensor_msgs import point_cloud2
from sensor_msgs.msg import LaserScan, PointCloud2
from test_local_costmap import BASE, LASER, ODOM, circle_ahead, make_scan
from tf2_msgs.msg import TFMessage

from bench.fault_graph import NODE_TESTS
from bench.fault_subject import Input, Seen, Sent, Stated, Subject, of, silence
from bench.fault_transforms import OLD

MAP, FOOTPRINT = "local_costmap/costmap", "local_costmap/footprint"
UPDATES = MAP + "_updates"
CENTRE, RADIUS = (2.7, 0.0), 1.2  # [m] odom: the circle before the laser
POINT = 1.0, 2.0  # [m] odom: what only the camera sees
NEAR = 0.15  # [m]
TOLERANCE = 0.3  # [s] of tf
SILENT = 1.0  # [s] of a source, as diagnostics report it


class LocalCostmapSubject(Subject):
    """A circle before the laser, something higher aside."""

    name = "local_costmap"
    launch = "local_costmap.launch"
    arguments = (
        f"global_frame:={ODOM}",
        f"robot_base_frame:={BASE}",
        f"config:={NODE_TESTS}/local_costmap.yaml",
    )
    frames = frozenset({ODOM})

    def __init__(self) -> None:
        self.outputs = {
            MAP: OccupancyGrid,
            UPDATES: OccupancyGridUpdate,
            FOOTPRINT: PolygonStamped,
        }
        self._map = CostmapView(MAP, threading.Condition())
        silent = silence(MAP, UPDATES, FOOTPRINT)
        ahead = {"future": Stated(silent, told=True, late=OLD)}  # tf keeps it as the newest
        self.inputs = (
            Input("tf", "/tf", TFMessage, _tf, TOLERANCE, silent, stated=ahead),
            Input("scan", "scan_human_aware", LaserScan, _scan, SILENT, self._stays),
            Input("depth", "depth/points", PointCloud2, _cloud, SILENT, self._stays),
        )

    def healthy(self, seen: Seen) -> str:
        if not of(FOOTPRINT, seen):
            return "no update"
        cells = self._map.lethal()
        if _off(cells) > NEAR:
            return f"an obstacle {_off(cells):.2f} m from what there is"
        if not (np.linalg.norm(cells - POINT, axis=1) < NEAR).any():
            return "the point is missing"
        return self._stays(seen)

    def _stays(self, seen: Seen) -> str:
        """The circle is where it was last seen, and updates go on."""
        near = (np.linalg.norm(self._map.lethal() - (1.5, 0.0), axis=1) < NEAR).any()
        return "" if near and of(FOOTPRINT, seen) else "the circle or the updates are gone"

    def wrong(self, seen: Seen, sent: list[Sent]) -> str:
        """An obstacle where nothing is."""
        del seen, sent
        off = _off(self._map.lethal())
        return f"an obstacle {off:.2f} m from what there is" if off > NEAR else ""


def _off(cells: np.ndarray) -> float:
    """[m] of the lethal cell (N, 2) farthest from circle and point."""
    if not len(cells):
        return 0.0
    circle = np.abs(np.linalg.norm(cells - CENTRE, axis=1) - RADIUS)
    return float(np.minimum(circle, np.linalg.norm(cells - POINT, axis=1)).max())


def _tf(stamp: rospy.Time) -> TFMessage:
    poses = transform(ODOM, BASE, stamp), transform(BASE, LASER, stamp, 0.2, 0.3)
    return TFMessage(list(poses))


def _scan(stamp: rospy.Time) -> LaserScan:
    return make_scan(circle_ahead(), LASER, stamp)


def _cloud(stamp: rospy.Time) -> PointCloud2:
    return point_cloud2.create_cloud_xyz32(to_header(stamp, BASE), [(*POINT, 0.5)])
