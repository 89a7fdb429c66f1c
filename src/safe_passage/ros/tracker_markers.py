"""The tracker's picture, after Fig. 6 of paper 000.

Standing obstacles grey, moving ones red with their way and their velocity; what is not seen now is
faint. Persons are yellow discs. The sensors' fields of view are sectors of one colour each.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from geometry_msgs.msg import Point, Vector3
from std_msgs.msg import Header
from visualization_msgs.msg import Marker, MarkerArray

from safe_passage.core.geometry import placed
from safe_passage.monitoring.persons import Persons
from safe_passage.monitoring.pipeline import Snapshot
from safe_passage.ros.fields_of_view import FieldOfView
from safe_passage.ros.markers import to_colour, to_marker, to_points
from safe_passage.ros.tracker_parameters import TrackerNodeParameters

GREY, RED = (0.72, 0.72, 0.74), (0.95, 0.15, 0.12)
WHITE, ROBOT, YELLOW = (1.0, 1.0, 1.0), (0.95, 0.55, 0.15), (1.0, 0.9, 0.1)
SENSORS = [(0.25, 0.75, 0.35), (0.30, 0.55, 1.0), (0.95, 0.85, 0.25), (0.75, 0.45, 0.95)]
SEEN, UNSEEN, WAY, SECTOR, RIM = 1.0, 0.35, 0.7, 0.1, 0.7  # opacity
STILL = 0.1  # [m/s] slower tracks have no arrow
LABEL_DISTANCE = 0.6  # [m] from the middle of an obstacle
PERSON_WIDTH = 0.7  # [m] of a person's disc
THICKNESS = 0.05  # [m] of what is drawn on the floor


class TrackerMarkers:
    """Draws snapshots, and remembers the ways of what moves."""

    def __init__(self, parameters: TrackerNodeParameters) -> None:
        self._paths: dict[int, deque] = {}  # id -> places (x, y) [m], the odometry's frame
        self.tune(parameters)

    def tune(self, parameters: TrackerNodeParameters) -> None:
        """Other parameters from the next picture on; the ways stay."""
        self._p = parameters
        self._length = 1 + int(parameters.path_duration * parameters.debug_rate)
        self._paths = {i: deque(path, self._length) for i, path in self._paths.items()}

    def draw(
        self,
        snapshot: Snapshot,
        persons: Persons,
        in_base: Header,
        in_odom: Header,
        views: list[FieldOfView],
    ) -> MarkerArray:
        """Everything; the last picture is deleted."""
        self._remember(snapshot)
        markers = [Marker(header=in_base, action=Marker.DELETEALL)]
        names = [source.name for source in self._p.sources]
        for view in views:
            markers += _sector(in_base, names.index(view.source), view, self._p.sector_radius)
        markers += _cells(in_base, snapshot, self._p.resolution)
        markers += [_path(in_odom, number, path) for number, path in self._paths.items()]
        markers += _arrows_and_labels(in_base, snapshot)
        markers += _persons(in_odom, persons)
        if self._p.footprint:
            markers.append(_robot(in_base, np.array(self._p.footprint)))
        return MarkerArray(markers)

    def _remember(self, snapshot: Snapshot) -> None:
        tracks = snapshot.tracks
        which = snapshot.confirmed & tracks.moving
        places = placed(tracks.position[which], snapshot.pose)
        now = dict(zip(tracks.id[which].tolist(), places.tolist()))
        self._paths = {number: path for number, path in self._paths.items() if number in now}
        for number, at in now.items():
            self._paths.setdefault(number, deque(maxlen=self._length)).append(at)


def _cells(header: Header, snapshot: Snapshot, resolution: float) -> list[Marker]:
    """The cells of all tracks, in a list each for what stands or moves, is seen or not."""
    tracks, shapes = snapshot.tracks, snapshot.shapes
    markers = []
    for moving in (False, True):
        for seen in (False, True):
            which = snapshot.confirmed & (tracks.moving == moving) & ((tracks.misses == 0) == seen)
            cells = shapes.values[which[shapes.owner]]
            colour = to_colour(RED if moving else GREY, SEEN if seen else UNSEEN)
            name = "moving" if moving else "standing"
            marker = to_marker(header, name, int(seen), Marker.CUBE_LIST, colour)
            marker.scale = Vector3(resolution, resolution, THICKNESS)
            marker.points = to_points(cells, THICKNESS)
            if marker.points:
                markers.append(marker)
    return markers


def _arrows_and_labels(header: Header, snapshot: Snapshot) -> list[Marker]:
    """For a moving track, the way of the next second in white; beside it id and speed."""
    tracks, markers = snapshot.tracks, []
    for i in np.flatnonzero(snapshot.confirmed & tracks.moving).tolist():
        number, at, velocity = int(tracks.id[i]), tracks.position[i], tracks.velocity[i]
        speed = float(np.hypot(*velocity))
        if speed > STILL:
            arrow = to_marker(header, "velocity", number, Marker.ARROW, to_colour(WHITE, 1.0))
            arrow.points = to_points(np.stack([at, at + velocity]), 4 * THICKNESS)
            arrow.scale = Vector3(0.07, 0.2, 0.25)
            markers.append(arrow)
        beside = at - np.array([math.copysign(LABEL_DISTANCE, velocity[0]), 0.0])
        markers.append(_label(header, "id", number, beside, f"{number}: {speed:.1f} m/s"))
    return markers


def _persons(header: Header, persons: Persons) -> list[Marker]:
    """A disc each, the surer the less faint."""
    markers = []
    for i, places in persons.places.items():
        for at in places.tolist():
            colour = to_colour(YELLOW, 0.6 * float(persons.probability[i]))
            disc = to_marker(header, "person", len(markers), Marker.CYLINDER, colour)
            disc.pose.position = Point(*at, THICKNESS)
            disc.scale = Vector3(PERSON_WIDTH, PERSON_WIDTH, THICKNESS)
            markers.append(disc)
    return markers


def _path(header: Header, number: int, path: deque) -> Marker:
    marker = to_marker(header, "path", number, Marker.LINE_STRIP, to_colour(RED, WAY))
    marker.scale.x = 0.04
    marker.points = to_points(np.array(path), 2 * THICKNESS)
    return marker


def _robot(header: Header, footprint: np.ndarray) -> Marker:
    marker = to_marker(header, "robot", 0, Marker.LINE_STRIP, to_colour(ROBOT, 1.0))
    marker.scale.x = 0.08
    marker.points = to_points(np.concatenate([footprint, footprint[:1]]), 2 * THICKNESS)
    return marker


def _sector(header: Header, index: int, view: FieldOfView, radius: float) -> list[Marker]:
    """The field of view on the floor, up to `radius` [m] from the sensor, with its name."""
    rgb = SENSORS[index % len(SENSORS)]
    near, far = view.reach[0], min(view.reach[1], radius)
    directions = np.stack([np.cos(view.bearings), np.sin(view.bearings)], axis=1)
    inner, outer = view.origin + near * directions, view.origin + far * directions
    triangles = np.stack([inner[:-1], outer[:-1], outer[1:], inner[:-1], outer[1:], inner[1:]], 1)
    area = to_marker(header, "field of view", index, Marker.TRIANGLE_LIST, to_colour(rgb, SECTOR))
    height = -0.01 * (index + 1)  # one over the other, none in another's plane
    area.points = to_points(triangles.reshape(-1, 2), height)
    rim = to_marker(header, "rim", index, Marker.LINE_STRIP, to_colour(rgb, RIM))
    rim.points = to_points(np.concatenate([inner, outer[::-1], inner[:1]]), height)
    rim.scale.x = 0.03
    middle = outer[len(outer) // 2] - 0.3 * directions[len(outer) // 2]
    return [area, rim, _label(header, "sensor", index, middle, view.source, rgb, 0.25)]


def _label(
    header: Header,
    name: str,
    number: int,
    at: np.ndarray,
    text: str,
    rgb: tuple[float, float, float] = WHITE,
    size: float = 0.35,
) -> Marker:
    """size: [m] of a capital letter."""
    marker = to_marker(header, name, number, Marker.TEXT_VIEW_FACING, to_colour(rgb, 1.0))
    marker.pose.position = Point(*at, 6 * THICKNESS)
    marker.scale.z = size
    marker.text = text
    return marker
