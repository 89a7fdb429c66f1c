"""Moving obstacles for other packages, where their messages are installed.

In the odometry's frame: TEB and the social layers take velocities over ground without turning them.
"""

from __future__ import annotations

import importlib

import numpy as np
import rospy
from geometry_msgs.msg import Point, Point32, Polygon
from std_msgs.msg import Header

from safe_passage.core.geometry import placed
from safe_passage.monitoring.persons import Persons
from safe_passage.monitoring.pipeline import Snapshot
from safe_passage.ros.tracker_conversions import hull


class ObstacleBridge:
    """`~obstacles` for TEB: polygons with velocities of what moves; its costmap has the rest."""

    PACKAGE = "costmap_converter"

    def __init__(self, messages) -> None:
        self._messages = messages
        self.publisher = rospy.Publisher("~obstacles", messages.ObstacleArrayMsg, queue_size=1)

    def make(self, snapshot: Snapshot, _: Persons, header: Header):
        """An ObstacleArrayMsg; the header's frame is the odometry's."""
        array = self._messages.ObstacleArrayMsg(header=header)
        for i, number, _, velocity in _told(snapshot, snapshot.tracks.moving):
            cells = placed(snapshot.shapes[i], snapshot.pose)
            message = self._messages.ObstacleMsg(header=header, id=number)
            outline = hull(cells, snapshot.grid.resolution)
            message.polygon = Polygon([Point32(x, y, 0.0) for x, y in outline])
            message.orientation.w = 1.0
            linear = message.velocities.twist.linear
            linear.x, linear.y = velocity
            array.obstacles.append(message)
        return array


class PeopleBridge:
    """`people`: persons, and whatever else moves, because it may be one."""

    PACKAGE = "people_msgs"

    def __init__(self, messages) -> None:
        self._messages = messages
        self.publisher = rospy.Publisher("people", messages.People, queue_size=1)

    def make(self, snapshot: Snapshot, persons: Persons, header: Header):
        """A People message; the header's frame is the odometry's."""
        people = self._messages.People(header=header)
        which = snapshot.tracks.moving | persons.labelled
        for _, number, at, velocity in _told(snapshot, which):
            person = self._messages.Person(name=str(number), reliability=1.0)
            person.position, person.velocity = Point(*at, 0.0), Point(*velocity, 0.0)
            people.people.append(person)
        return people


def make_bridges() -> list:
    """Those whose messages can be imported."""
    bridges = []
    for bridge in (ObstacleBridge, PeopleBridge):
        try:
            messages = importlib.import_module(bridge.PACKAGE + ".msg")
        except ImportError:
            continue
        bridges.append(bridge(messages))
    return bridges


def _told(snapshot: Snapshot, mask: np.ndarray):
    """Index, id, position [m] and velocity [m/s] of confirmed tracks, the odometry's frame."""
    tracks = snapshot.tracks
    which = np.flatnonzero(snapshot.confirmed & mask)
    x, y, yaw = snapshot.pose
    at = placed(tracks.position[which], (x, y, yaw))
    velocity = placed(tracks.velocity[which], (0.0, 0.0, yaw))
    return zip(which.tolist(), tracks.id[which].tolist(), at.tolist(), velocity.tolist())
