"""The monitor's picture, after Fig. 7 of paper 000.

Obstacles red where they are and grey where they are predicted; the robot's way black.
"""

from __future__ import annotations

import math

import numpy as np
from geometry_msgs.msg import Point, Vector3
from std_msgs.msg import Header
from visualization_msgs.msg import Marker, MarkerArray

from safe_passage.core.geometry import placed
from safe_passage.ros.markers import to_colour, to_marker, to_points
from safe_passage.separation import Assessment, Level, Outlook, Reason
from safe_passage.separation.prediction import Prediction
from safe_passage.separation.robot_motion import Shape

RED, GREY, BLACK, ROBOT = (0.9, 0.1, 0.1), (0.45, 0.45, 0.48), (0.0, 0.0, 0.0), (0.95, 0.55, 0.15)
BLUE = (0.1, 0.2, 0.8)
LEVELS = {Level.FREE: (0.1, 0.6, 0.2), Level.SLOW: (0.95, 0.6, 0.0), Level.STOP: (0.85, 0.1, 0.1)}
EVERY = 0.5  # [s] between two drawn predictions
PRESENT_HEIGHT, PREDICTED_HEIGHT = 0.06, 0.02  # [m] over the floor, so that one hides the other
CIRCLE = np.linspace(0.0, 2.0 * math.pi, 25)


def draw(outlook: Outlook | None, assessment: Assessment, header: Header) -> MarkerArray:
    """Everything; the last picture is deleted. Without outlook: the reason alone."""
    markers = [Marker(header=header, action=Marker.DELETEALL), _text(header, assessment)]
    if outlook is not None:
        markers += _obstacles(header, outlook.prediction)
        markers += _robot(header, outlook, assessment)
        markers += _speeds(header, outlook)
    return MarkerArray(markers)


def _obstacles(header: Header, prediction: Prediction) -> list[Marker]:
    """Discs of the shapes: now, and every half second enlarged by their growth."""
    owner = np.repeat(np.arange(len(prediction)), np.diff(prediction.start))
    markers = []
    step = max(1, round(EVERY / prediction.times[1]))
    for k in range(0, len(prediction.times), step):
        way = prediction.velocity * prediction.times[k]
        places = (prediction.centre + way)[owner] + prediction.discs[:, :2]
        radii = prediction.discs[:, 2] + (prediction.growth[owner, k] if k else 0.0)
        colour = to_colour(GREY, 0.3) if k else to_colour(RED, 1.0)
        height = PREDICTED_HEIGHT if k else PRESENT_HEIGHT
        for radius in np.unique(np.round(radii, 2)):
            some = places[np.round(radii, 2) == radius]
            name = "predicted" if k else "present"
            kind = Marker.CUBE_LIST if k == 0 else Marker.SPHERE_LIST
            marker = to_marker(header, name, len(markers), kind, colour)
            side = 2.0 * radius * (math.sqrt(0.5) if k == 0 else 1.0)
            marker.scale = Vector3(side, side, 0.01)
            marker.points = to_points(some, height)
            markers.append(marker)
    return markers


def _robot(header: Header, outlook: Outlook, assessment: Assessment) -> list[Marker]:
    """Outlines along the way, the first one in the robot's own colour."""
    motion, shape = outlook.motion, outlook.shape
    times = np.arange(0.0, outlook.prediction.times[-1] + 1e-6, EVERY)
    poses = motion.at(times)
    markers = []
    for k, pose in enumerate(poses):
        for line in _outlines(shape):
            rgb = BLACK if k else ROBOT
            marker = to_marker(
                header, "robot", len(markers), Marker.LINE_STRIP, to_colour(rgb, 1.0)
            )
            marker.scale.x = 0.03 if k else 0.08
            marker.points = to_points(placed(line, pose), 0.09 if k else 0.12)
            markers.append(marker)
        if motion.stands:
            return markers
    way = to_marker(header, "way", 0, Marker.LINE_STRIP, to_colour(BLACK, 1.0))
    way.scale.x = 0.05
    way.points = to_points(motion.poses[:, :2], 0.1)
    return [*markers, way]


def _outlines(shape: Shape) -> list[np.ndarray]:
    """Closed lines (L, 2) [m] around platform and parts."""
    ring = np.stack([np.cos(CIRCLE), np.sin(CIRCLE)], axis=1)
    if len(shape.corners) > 1:
        lines = [np.concatenate([shape.corners, shape.corners[:1]])]
    else:
        lines = [shape.corners + shape.padding * ring]
    for part in shape.parts:
        along = math.atan2(part.end[1] - part.start[1], part.end[0] - part.start[0])
        half = CIRCLE[:13] + along - 0.5 * math.pi
        cap = part.radius * np.stack([np.cos(half), np.sin(half)], axis=1)
        line = np.concatenate([part.end + cap, part.start - cap])
        lines.append(np.concatenate([line, line[:1]]))
    return lines


def _speeds(header: Header, outlook: Outlook) -> list[Marker]:
    """Arrows as long as a second, of who moves and of the robot."""
    prediction = outlook.prediction
    moves = np.flatnonzero(np.hypot(*prediction.velocity.T) > 0.1)
    pairs = [(prediction.centre[i], prediction.velocity[i]) for i in moves]
    ahead = np.diff(outlook.motion.at(np.array([0.0, 0.1]))[:, :2], axis=0)[0] / 0.1
    if np.hypot(*ahead) > 0.05:
        pairs.append((np.zeros(2), ahead))
    markers = []
    for at, velocity in pairs:
        arrow = to_marker(
            header, "velocity", len(markers), Marker.ARROW, to_colour((0.1, 0.2, 0.8), 1.0)
        )
        arrow.points = to_points(np.stack([at, at + velocity]), 0.2)
        arrow.scale = Vector3(0.06, 0.18, 0.2)
        markers.append(arrow)
    return markers


def _text(header: Header, found: Assessment) -> Marker:
    """Level, scale, why; behind the robot, where it hides nothing."""
    marker = to_marker(
        header, "state", 0, Marker.TEXT_VIEW_FACING, to_colour(LEVELS[found.level], 1.0)
    )
    marker.pose.position = Point(-1.7, 0.0, 0.5)
    marker.scale.z = 0.35
    lines = [f"{found.level.name} {100.0 * found.scale:.0f} %"]
    if found.reason is not Reason.OK:
        lines.append(found.reason.name)
    if math.isfinite(found.time_to_collision):
        lines.append(f"collision in {found.time_to_collision:.1f} s")
    if math.isfinite(found.present_distance):
        lines.append(f"{found.present_distance:.1f} m, least {found.predicted_distance:.1f} m")
    marker.text = "\n".join(lines)
    return marker
