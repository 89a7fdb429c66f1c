"""Messages of the costmap's sources to points in their own frame, and costs to messages."""

from __future__ import annotations

from typing import Union

import numpy as np
import rospy
from geometry_msgs.msg import Point32, PolygonStamped
from map_msgs.msg import OccupancyGridUpdate
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import LaserScan, PointCloud, PointCloud2, PointField

from safe_passage.costmap import CostmapUpdate, occupancy, project_scan
from safe_passage.costmap.grid import CellBox
from safe_passage.costmap.parameters import SourceParameters
from safe_passage.ros.diagnostics import Outcome

SensorMessage = Union[LaserScan, PointCloud, PointCloud2]
MESSAGE_TYPES = {"LaserScan": LaserScan, "PointCloud": PointCloud, "PointCloud2": PointCloud2}


class UnusableMessageError(Exception):
    """A message that cannot be used, and why."""

    def __init__(self, outcome: Outcome, detail: str) -> None:
        super().__init__(detail)
        self.outcome = outcome


def sensor_points(message: SensorMessage, source: SourceParameters) -> np.ndarray:
    """Points (N, 3) float32 m in the message's frame; raises UnusableMessageError."""
    if isinstance(message, LaserScan):
        return _scan_points(message, source.inf_is_valid)
    if isinstance(message, PointCloud2):
        points = _cloud_points(message)
    else:
        points = np.array([(p.x, p.y, p.z) for p in message.points], dtype=np.float32)
    if not points.size:
        raise UnusableMessageError(Outcome.EMPTY, "no points")
    if np.isnan(points).any(axis=1).all():
        raise UnusableMessageError(Outcome.NOT_FINITE, "every point has a NaN")
    return points


def _scan_points(scan: LaserScan, inf_is_valid: bool) -> np.ndarray:
    geometry = (scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max)
    if not np.isfinite(geometry).all() or scan.range_max <= scan.range_min:
        raise UnusableMessageError(Outcome.BAD_FIELDS, f"angles and range limits {geometry}")
    if not scan.ranges:
        raise UnusableMessageError(Outcome.EMPTY, "no beams")
    ranges = np.array(scan.ranges, dtype=np.float32)
    if np.isnan(ranges).all():
        raise UnusableMessageError(Outcome.NOT_FINITE, "every range is NaN")
    return project_scan(ranges, *geometry, inf_is_valid=inf_is_valid)


def _cloud_points(cloud: PointCloud2) -> np.ndarray:
    fields = {field.name: field for field in cloud.fields}
    for axis in "xyz":
        field = fields.get(axis)
        if field is None or field.datatype != PointField.FLOAT32:
            raise UnusableMessageError(Outcome.BAD_FIELDS, f"no float32 field {axis}")
        if field.offset + 4 > cloud.point_step:
            raise UnusableMessageError(Outcome.BAD_FIELDS, f"field {axis} outside the point")
    shape = (cloud.height, cloud.width)
    if 0 in shape:
        return np.empty((0, 3), dtype=np.float32)
    too_short = cloud.row_step < cloud.width * cloud.point_step
    if too_short or len(cloud.data) < cloud.height * cloud.row_step:
        raise UnusableMessageError(Outcome.BAD_FIELDS, f"{len(cloud.data)} bytes for {shape}")
    layout = np.dtype(
        {
            "names": list("xyz"),
            "formats": [">f4" if cloud.is_bigendian else "<f4"] * 3,
            "offsets": [fields[axis].offset for axis in "xyz"],
            "itemsize": cloud.point_step,
        }
    )
    strides = (cloud.row_step, cloud.point_step)
    grid = np.ndarray(shape, layout, buffer=cloud.data, strides=strides)
    return np.stack([grid[axis].ravel() for axis in "xyz"], axis=1).astype(np.float32)


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
