"""What a scan showed, as messages. Frame of all: the cloud's."""

from __future__ import annotations

import math

import numpy as np
from geometry_msgs.msg import Point, Point32, Polygon, Pose, Quaternion, Vector3
from nav_msgs.msg import OccupancyGrid
from scipy.spatial.transform import Rotation
from std_msgs.msg import Header

from safe_passage.msg import Door, ScanPlane, ScanPlanes, ScanSegmentation, Stairs
from safe_passage.scan_segmentation import Planes, Segmentation
from safe_passage.scan_segmentation.basic_map import Colour, ColourMap
from safe_passage.scan_segmentation.scan import Level, Reason
from safe_passage.scan_segmentation.validation import ValidPlane

OCCUPANCY = np.array([-1, 0, 50, 100], np.int8)  # of Colour
WORSE = np.array([2, 0, 1, 3], np.uint8)  # of Colour: unknown is worse than orange
MOST_CELLS = 4_000_000  # of a published map


def to_planes(header: Header, planes: Planes) -> ScanPlanes:
    """Before the ground is known."""
    return ScanPlanes(header, [to_plane(valid, False) for valid in planes.valid])


def to_plane(valid: ValidPlane, ground: bool) -> ScanPlane:
    """One plane."""
    plane = valid.plane
    outlines = [
        Polygon([Point32(*corner) for corner in outline.tolist()]) for outline in valid.outline()
    ]
    normal = Vector3(*plane.normal.tolist())
    return ScanPlane(normal, plane.offset, plane.rms, valid.area, valid.points, ground, outlines)


def to_result(header: Header, found: Segmentation, robot: str, text: str) -> ScanSegmentation:
    """All of it."""
    ground = {plane.index for plane in found.ground}
    planes = [to_plane(valid, k in ground) for k, valid in enumerate(found.planes.valid)]
    doors = [
        Door(
            to_pose(found.level, door.middle, door.yaw),
            door.width,
            door.height,
            door.thickness,
            door.least_width,
            door.least_height,
            list(door.passable_by),
        )
        for door in found.doors
    ]
    stairs = [
        Stairs(to_pose(found.level, one.foot, one.yaw), one.steps, one.rise, one.run, one.width)
        for one in found.stairs
    ]
    grid = to_occupancy(header, found, found.drivable)
    return ScanSegmentation(
        header, True, ScanSegmentation.OK, text, robot, planes, doors, stairs, grid
    )


def to_failure(header: Header, reason: int, text: str, robot: str) -> ScanSegmentation:
    """Why there is nothing."""
    empty = OccupancyGrid(header=header)
    return ScanSegmentation(
        header=header, success=False, reason=reason, text=text, robot=robot, map=empty
    )


def reason_code(reason: Reason) -> int:
    """The message's number of it."""
    return int(getattr(ScanSegmentation, reason.name))


def to_pose(level: Level, place: tuple[float, float, float], yaw: float) -> Pose:
    """Pose of a place in the level frame, x along `yaw`, z up."""
    c, s = math.cos(yaw), math.sin(yaw)
    turned = level.R_level_scan.T @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    at = level.back(np.array(place))
    orientation = Quaternion(*Rotation.from_matrix(turned).as_quat().tolist())
    return Pose(Point(*at.tolist()), orientation)


def to_occupancy(header: Header, found: Segmentation, colours: ColourMap) -> OccupancyGrid:
    """On the height of the ground under the scanner."""
    small = reduced(colours, MOST_CELLS)
    grid = OccupancyGrid(header=header)
    grid.info.map_load_time = header.stamp
    grid.info.resolution = small.resolution
    grid.info.height, grid.info.width = small.cells.shape
    z = float(found.survey.ground.z(np.zeros((1, 2)))[0])
    x, y = small.origin.tolist()
    grid.info.origin = to_pose(found.level, (x, y, z), 0.0)
    grid.data = OCCUPANCY[small.cells].ravel().tolist()
    return grid


def reduced(colours: ColourMap, most: int) -> ColourMap:
    """With no more than about `most` cells: of those that become one the worst counts."""
    times = math.ceil(math.sqrt(colours.cells.size / most))
    if times <= 1:
        return colours
    rows, columns = (-(-size // times) for size in colours.cells.shape)
    worse = np.full((rows * times, columns * times), WORSE[Colour.UNKNOWN])
    worse[: colours.cells.shape[0], : colours.cells.shape[1]] = WORSE[colours.cells]
    worst = worse.reshape(rows, times, columns, times).max(axis=(1, 3))
    cells = np.argsort(WORSE).astype(np.uint8)[worst]
    return ColourMap(cells, colours.origin, colours.resolution * times)
