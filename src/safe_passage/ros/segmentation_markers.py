"""What a scan showed, in rviz. Frame of all: the cloud's."""

from __future__ import annotations

import colorsys
import math
from typing import Iterable

import numpy as np
import rospy
from geometry_msgs.msg import Point, Pose, Vector3
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from safe_passage.ros.markers import to_colour, to_marker
from safe_passage.ros.segmentation_conversions import to_pose
from safe_passage.scan_segmentation import Planes, Segmentation
from safe_passage.scan_segmentation.basic_map import Colour
from safe_passage.scan_segmentation.visualisation import Pictured
from safe_passage.scan_segmentation.writing import BGR, BOX, boxes

WHITE = to_colour((1.0, 1.0, 1.0), 1.0)
LIGHT = np.array([0.3, -0.4, 0.86])  # where it comes from: shapes without shades cannot be read
OVER = 0.02  # [m] that the ground's triangles are drawn over the cloud's points
LETTERS = 0.36  # [m]
YELLOW = to_colour((1.0, 0.95, 0.3), 1.0)


def result_markers(header: Header, found: Segmentation, shapes: Pictured) -> MarkerArray:
    """Drivable ground, cubes, cuboids, doors and stairs, in place of all that was there."""
    markers = [_delete_all(header)]
    mesh = shapes.ground
    raised = mesh.points + OVER * found.level.R_level_scan[2]
    for name, colour in (("drivable", Colour.GREEN), ("with care", Colour.ORANGE)):
        corners = raised[mesh.triangles[mesh.colours == colour]].reshape(-1, 3)
        markers.append(_triangles(header, name, corners, rgba(colour)))
    for name, (corners, colour) in zip(("low obstacles", "obstacles"), boxes(found, shapes)):
        markers.append(_boxes(header, name, corners, colour))
    markers += _scanner(header, found) + _doors(header, found) + _stairs(header, found)
    return MarkerArray(markers)


def wall_markers(header: Header, shapes: Pictured) -> MarkerArray:
    """Outlines of what is no ground."""
    lines = _outlines(header, "walls", 0, shapes.walls, rgba(Colour.RED))
    return MarkerArray([_delete_all(header), lines])


def plane_markers(header: Header, planes: Planes) -> MarkerArray:
    """Outlines of all planes, each in a colour of its own."""
    markers = [_delete_all(header)]
    for k, valid in enumerate(planes.valid):
        colour = to_colour(colorsys.hsv_to_rgb(0.61 * k % 1.0, 0.6, 1.0), 1.0)
        markers.append(_outlines(header, "planes", k, valid.outline(), colour))
    return MarkerArray(markers)


def segment_markers(header: Header, planes: Planes) -> MarkerArray:
    """Line segments, a colour for each plane before validation; grey: of none."""
    segments = planes.segments
    marker = _marker(header, "segments", 0, Marker.LINE_LIST, WHITE)
    marker.scale.x = 0.01
    ends = np.stack([segments.start, segments.end], axis=1).reshape(-1, 3)
    marker.points = _points(ends)
    grey = to_colour((0.5, 0.5, 0.5), 0.6)
    for owner in planes.owner.tolist():
        hue = colorsys.hsv_to_rgb(0.61 * owner % 1.0, 0.6, 1.0)
        marker.colors += [grey if owner < 0 else to_colour(hue, 1.0)] * 2
    return MarkerArray([_delete_all(header), marker])


def no_markers(header: Header) -> MarkerArray:
    """Nothing, in place of all that was there."""
    return MarkerArray([_delete_all(header)])


def rgba(colour: Colour, opacity: float = 1.0) -> ColorRGBA:
    """As in the pictures."""
    blue, green, red = (BGR[colour] / 255.0).tolist()
    return to_colour((red, green, blue), opacity)


def _scanner(header: Header, found: Segmentation) -> list[Marker]:
    """Where the operator is."""
    place = to_pose(found.level, (0.0, 0.0, 0.0), 0.0)
    ball = _marker(header, "scanner", 0, Marker.SPHERE, YELLOW)
    ball.pose, ball.scale = place, Vector3(0.2, 0.2, 0.2)
    return [ball, _text(header, "scanner", 1, place, "scanner", found, 0.3)]


def _doors(header: Header, found: Segmentation) -> list[Marker]:
    markers = []
    for k, door in enumerate(found.doors):
        pose = to_pose(found.level, door.middle, door.yaw)
        high = door.height if math.isfinite(door.height) else 2.0
        y = 0.5 * door.width
        frame = np.array([[0, -y, 0], [0, -y, high], [0, y, high], [0, y, 0]])
        line = _marker(header, "doors", 2 * k, Marker.LINE_STRIP, YELLOW)
        line.pose, line.scale.x, line.points = pose, 0.04, _points(frame)
        said = f"for {', '.join(door.passable_by)}" if door.passable_by else "too small"
        text = f"door {door.said_width}\n{said}"
        markers += [line, _text(header, "doors", 2 * k + 1, pose, text, found, high + 0.35)]
    return markers


def _stairs(header: Header, found: Segmentation) -> list[Marker]:
    markers = []
    for k, flight in enumerate(found.stairs):
        pose = to_pose(found.level, flight.foot, flight.yaw)
        steps = np.arange(flight.steps)
        edges = np.zeros((flight.steps, 2, 3))
        edges[..., 0] = (steps * flight.run)[:, None]
        edges[..., 1] = np.array([-0.5, 0.5]) * flight.width
        edges[..., 2] = ((steps + 1) * flight.rise)[:, None] + OVER
        lines = _marker(header, "stairs", 2 * k, Marker.LINE_LIST, YELLOW)
        lines.pose, lines.scale.x, lines.points = pose, 0.03, _points(edges.reshape(-1, 3))
        text = f"stairs up\n{flight.steps} steps of {flight.rise:.2f} m"
        top = flight.steps * flight.rise + 0.35
        markers += [lines, _text(header, "stairs", 2 * k + 1, pose, text, found, top)]
    return markers


def _text(
    header: Header, name: str, number: int, pose: Pose, text: str, found: Segmentation, above: float
) -> Marker:
    marker = _marker(header, name, number, Marker.TEXT_VIEW_FACING, YELLOW)
    place = np.array([pose.position.x, pose.position.y, pose.position.z])
    marker.pose.position = Point(*(place + above * found.level.R_level_scan[2]).tolist())
    marker.scale.z, marker.text = LETTERS, text
    return marker


def _boxes(header: Header, name: str, corners: np.ndarray, colour: Colour) -> Marker:
    """Boxes (N, 8, 3), each side as bright as it faces the light."""
    triangles = corners[:, BOX]  # (N, 12, 3, 3)
    marker = _triangles(header, name, triangles.reshape(-1, 3), rgba(colour))
    sides = np.cross(
        triangles[:, :, 1] - triangles[:, :, 0], triangles[:, :, 2] - triangles[:, :, 0]
    )
    length = np.maximum(np.linalg.norm(sides, axis=2), 1e-9)
    light = 0.75 + 0.25 * (sides @ LIGHT) / length
    red, green, blue = marker.color.r, marker.color.g, marker.color.b
    for shade in light.ravel().tolist():
        marker.colors += [ColorRGBA(shade * red, shade * green, shade * blue, 1.0)] * 3
    return marker


def _triangles(header: Header, name: str, corners: np.ndarray, colour: ColorRGBA) -> Marker:
    marker = _marker(header, name, 0, Marker.TRIANGLE_LIST, colour)
    marker.points = _points(corners)
    if not marker.points:
        marker.action = Marker.DELETE  # rviz takes an empty list for a mistake
    return marker


def _outlines(
    header: Header, name: str, number: int, outlines: Iterable[np.ndarray], colour: ColorRGBA
) -> Marker:
    marker = _marker(header, name, number, Marker.LINE_LIST, colour)
    marker.scale.x = 0.03
    for outline in outlines:
        marker.points += _points(np.stack([outline, np.roll(outline, -1, 0)], 1).reshape(-1, 3))
    if not marker.points:
        marker.action = Marker.DELETE
    return marker


def _marker(header: Header, name: str, number: int, kind: int, colour: ColorRGBA) -> Marker:
    """Stays until it is deleted: the robot stands while its operator looks."""
    marker = to_marker(header, name, number, kind, colour)
    marker.lifetime, marker.scale = rospy.Duration(0), Vector3(1.0, 1.0, 1.0)
    return marker


def _delete_all(header: Header) -> Marker:
    return Marker(header=header, ns="all", action=Marker.DELETEALL)


def _points(places: np.ndarray) -> list[Point]:
    return [Point(*place) for place in places.tolist()]
