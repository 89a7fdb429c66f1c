"""What the nodes' markers are made of."""

from __future__ import annotations

import numpy as np
import rospy
from geometry_msgs.msg import Point, Vector3
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker

LIFETIME = rospy.Duration(1)  # a tracker that stops must not leave obstacles behind


def to_points(places: np.ndarray, z: float) -> list[Point]:
    """`places` (N, 2) [m] at the height `z` [m]."""
    return [Point(x, y, z) for x, y in places.tolist()]


def to_colour(rgb: tuple[float, float, float], opacity: float) -> ColorRGBA:
    """Red, green, blue and opacity, 0 to 1."""
    return ColorRGBA(*rgb, opacity)


def to_marker(header: Header, name: str, number: int, kind: int, rgba: ColorRGBA) -> Marker:
    """At the frame's origin, of size 1, gone after LIFETIME without a newer one."""
    marker = Marker(header=header, ns=name, id=number, type=kind, color=rgba, lifetime=LIFETIME)
    marker.pose.orientation.w = 1.0
    marker.scale = Vector3(1.0, 1.0, 1.0)
    return marker
