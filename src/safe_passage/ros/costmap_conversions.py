"""Messages of the costmap's sources to points in their own frame, and costs to messages."""

from __future__ import annotations

from typing import Union

import numpy as np
import rospy
from geometry_msgs.msg import Point32, PolygonStamped
from map_msgs.msg import OccupancyGridUpdate
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import LaserScan, PointCloud, PointCloud2

from safe_passage.costmap import CostmapUpdate, occupancy, project_scan
from safe_passage.costmap.grid import CellBox
from safe_passage.costmap.parameters import SourceParameters
from safe_passage.ros.sensor_conversions import cloud_xyz, refuse_nan, scan_ranges

SensorMessage = Union[LaserScan, PointCloud, PointCloud2]
MESSAGE_TYPES = {"LaserScan": LaserScan, "PointCloud": PointCloud, "PointCloud2": PointCloud2}


def sensor_points(message: SensorMessage, source: SourceParameters) -> np.ndarray:
    """Points (N, 3) float32 m in the message's frame; raises UnusableMessageError."""
    if isinstance(message, LaserScan):
        geometry = message.angle_min, message.angle_increment, message.range_min, message.range_max
        ranges = scan_ranges(message)
        return refuse_nan(project_scan(ranges, *geometry, inf_is_valid=source.inf_is_valid))
    if isinstance(message, PointCloud2):
        return cloud_xyz(message)
    return refuse_nan(np.array([(p.x, p.y, p.z) for p in message.points], dtype=np.float32))


def to_grid(update: CostmapUpdate, frame: str, stamp: rospy.Time) -> OccupancyGrid:
    """The whole costmap."""
    grid = OccupancyGrid()
    grid.header.frame_id, grid.header.stamp = frame, stamp
    grid.info.map_load_time = stamp
    grid.info.resolution = update.resolution
    grid.info.height, grid.info.width = update.costs.shape
    grid.info.origin.position.x, grid.info.origin.position.y = update.origin
    grid.info.origin.orientation.w = 1.0
    grid.data = occupancy(update.costs).ravel().tolist()
    return grid


def to_grid_update(
    update: CostmapUpdate, box: CellBox, frame: str, stamp: rospy.Time
) -> OccupancyGridUpdate:
    """The cells of `box` only."""
    first_column, end_column, first_row, end_row = box
    patch = OccupancyGridUpdate()
    patch.header.frame_id, patch.header.stamp = frame, stamp
    patch.x, patch.width = first_column, end_column - first_column
    patch.y, patch.height = first_row, end_row - first_row
    cells = update.costs[first_row:end_row, first_column:end_column]
    patch.data = occupancy(cells).ravel().tolist()
    return patch


def to_polygon(update: CostmapUpdate, frame: str, stamp: rospy.Time) -> PolygonStamped:
    """The padded footprint at the robot's pose."""
    polygon = PolygonStamped()
    polygon.header.frame_id, polygon.header.stamp = frame, stamp
    polygon.polygon.points = [Point32(x, y, 0.0) for x, y in update.footprint]
    return polygon
