"""The simulator's map, odometry and truth as messages."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np
from geometry_msgs.msg import Point, Quaternion, Vector3
from nav_msgs.msg import OccupancyGrid, Odometry
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from safe_passage.core.geometry import Pose, placed
from safe_passage.core.grid import GridMap
from safe_passage.msg import Person, PersonArray
from safe_passage.simulation import materials
from safe_passage.simulation.drive import Twist
from safe_passage.simulation.people_assets import BodyMesh
from safe_passage.simulation.robots import Robot
from safe_passage.simulation.walkers import PersonState
from safe_passage.simulation.worlds import Block, World

BOX_FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
FACE_LIGHT = (0.6, 0.6, 0.75, 0.75, 0.55, 1.0)  # -x +x -y +y -z +z
CUT = 1.9  # [m] the world is shown up to this height, so that one sees into it from above


def to_quaternion(yaw: float) -> Quaternion:
    """Turn about z."""
    return Quaternion(0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw))


def to_map(header: Header, grid: GridMap) -> OccupancyGrid:
    """0 free, 100 occupied."""
    message = OccupancyGrid(header=header)
    message.info.map_load_time = header.stamp
    message.info.resolution = grid.resolution
    message.info.height, message.info.width = grid.occupied.shape
    message.info.origin.position.x, message.info.origin.position.y = grid.origin
    message.info.origin.orientation.w = 1.0
    message.data = np.where(grid.occupied, 100, 0).astype(np.int8).ravel().tolist()
    return message


def to_odometry(header: Header, child: str, pose: Pose, twist: Twist) -> Odometry:
    """Pose in the header's frame, twist in the child's."""
    message = Odometry(header=header, child_frame_id=child)
    message.pose.pose.position = Point(pose[0], pose[1], 0.0)
    message.pose.pose.orientation = to_quaternion(pose[2])
    message.twist.twist.linear = Vector3(twist.forward, twist.left, 0.0)
    message.twist.twist.angular = Vector3(0.0, 0.0, twist.turn)
    return message


def to_persons(
    header: Header, states: Sequence[PersonState], heights: Sequence[float]
) -> PersonArray:
    """The truth; ids count from 1."""
    message = PersonArray(header=header)
    for i, (state, height) in enumerate(zip(states, heights)):
        person = Person(id=i + 1, height=height, confidence=1.0, method=Person.METHOD_NONE)
        person.position = Point(state.x, state.y, 0.0)
        person.velocity = Vector3(*state.velocity, 0.0)
        person.box_pose.position = Point(state.x, state.y, 0.5 * height)
        person.box_pose.orientation = to_quaternion(state.yaw)
        person.box_size = Vector3(0.5, 0.6, height)
        message.persons.append(person)
    return message


def world_markers(header: Header, world: World) -> MarkerArray:
    """All blocks as one list of triangles, cut off at CUT."""
    marker = _marker(header, "world", 0, Marker.TRIANGLE_LIST)
    colours = {name: materials.paint(name).mean(axis=(0, 1)) / 255.0 for name in materials.PAINTERS}
    for block in world.blocks:
        if block.z < CUT:
            _add_block(marker, block, colours[block.material] * block.shade)
    marker.frame_locked = True
    return MarkerArray([marker])


def live_markers(
    header: Header,
    states: Sequence[PersonState],
    bodies: Sequence[BodyMesh],
    pose: Pose,
    robot: Robot,
) -> MarkerArray:
    """People as the silhouettes of a trunk, a head and a nose; the robot as its boxes."""
    markers = []
    for i, (state, body) in enumerate(zip(states, bodies)):
        jacket = body.palette[list(body.region_names).index("jacket")] / 255.0
        skin = body.palette[list(body.region_names).index("head")] / 255.0
        tall = body.height_m
        parts = (
            (Marker.CYLINDER, 0.0, 0.5 * (tall - 0.25), (0.30, 0.46, tall - 0.25), jacket),
            (Marker.SPHERE, 0.0, tall - 0.13, (0.24, 0.20, 0.26), skin),
            (Marker.SPHERE, 0.13, tall - 0.15, (0.06, 0.05, 0.05), skin),
        )
        for k, (kind, ahead, z, size, colour) in enumerate(parts):
            marker = _marker(header, "people", 3 * i + k, kind)
            x, y = state.x + ahead * math.cos(state.yaw), state.y + ahead * math.sin(state.yaw)
            marker.pose.position = Point(x, y, z)
            marker.pose.orientation = to_quaternion(state.yaw)
            marker.scale = Vector3(*size)
            marker.color = ColorRGBA(*colour, 1.0)
            markers.append(marker)
    for i, part in enumerate(robot.parts):
        marker = _marker(header, "robot", i, Marker.CUBE)
        x, y = placed(np.array([[part.x, part.y]]), pose)[0]
        marker.pose.position = Point(x, y, part.z + 0.5 * part.size[2])
        marker.pose.orientation = to_quaternion(pose[2])
        marker.scale = Vector3(*part.size)
        marker.color = ColorRGBA(*part.colour, 1.0)
        markers.append(marker)
    return MarkerArray(markers)


def _marker(header: Header, namespace: str, number: int, kind: int) -> Marker:
    marker = Marker(header=header, ns=namespace, id=number, type=kind, action=Marker.ADD)
    marker.pose.orientation.w = 1.0
    marker.scale = Vector3(1.0, 1.0, 1.0)
    marker.color.a = 1.0
    return marker


def _add_block(marker: Marker, block: Block, colour: np.ndarray) -> None:
    top = min(block.z + block.size[2], CUT)
    half = 0.5 * np.array(block.size[:2])
    signs = np.array([[i >> 2 & 1, i >> 1 & 1] for i in range(8)]) * 2 - 1
    corners = placed(signs * half, (block.x, block.y, block.yaw))
    points = [Point(x, y, (block.z, top)[i & 1]) for i, (x, y) in enumerate(corners)]
    for face, light in zip(BOX_FACES, FACE_LIGHT):
        a, b, c, d = (points[i] for i in face)
        shade = ColorRGBA(*np.clip(light * colour, 0.0, 1.0), 1.0)
        marker.points += [a, b, c, a, c, d]
        marker.colors += [shade] * 6
