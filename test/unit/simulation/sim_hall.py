"""A small hall and a plain robot, of which tests vary what they are about."""

from __future__ import annotations

from typing import Any

import numpy as np
from safe_passage.simulation import raycast
from safe_passage.simulation.robots import Robot, make_robot
from safe_passage.simulation.worlds import Block, World, make_world

BOXES = [
    {"x": 2.5, "y": 1.5, "size": [0.6, 0.4, 1.2]},
    {"x": 3.2, "y": -1.0, "yaw": 0.7, "size": [0.5, 1.0, 0.5]},
    {"x": -2.0, "y": 2.2, "yaw": -1.1, "size": [1.2, 0.3, 2.0]},
    {"x": 1.5, "y": -2.5, "z": 0.9, "size": [1.0, 1.0, 0.3]},  # above a low lidar
    {"x": -3.0, "y": -2.0, "yaw": 2.0, "size": [0.4, 0.4, 0.3]},
]


def make_hall(**values: Any) -> World:
    """10 m by 8 m, the robot in its middle."""
    return make_world({"name": "hall", "size": [10.0, 8.0], "start": [0.0, 0.0, 0.0], **values})


def make_cart(**values: Any) -> Robot:
    """0.6 m by 0.5 m, one lidar, one small camera."""
    cart = {
        "name": "cart",
        "footprint": [[0.3, 0.25], [-0.3, 0.25], [-0.3, -0.25], [0.3, -0.25]],
        "height": 1.2,
        "lidars": [{"z": 0.2, "beams": 361}],
        "cameras": [{"z": 1.0, "pitch": 0.3, "width": 160, "height": 120, "focal": 131.25}],
    }
    return make_robot({**cart, **values})


def distances_by_hand(blocks: tuple[Block, ...], origin: np.ndarray, rays: np.ndarray):
    """(N,) [m] from `origin` along unit `rays` (N, 3) to the nearest block."""
    nearest = np.full(len(rays), np.inf)
    for block in blocks:
        c, s = np.cos(block.yaw), np.sin(block.yaw)
        R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        half = 0.5 * np.array(block.size)
        middle = np.array([block.x, block.y, block.z + half[2]])
        there = raycast.box((origin - middle) @ R, rays @ R, -half, half)
        nearest = np.minimum(nearest, there)
    return nearest


def is_inside(blocks: tuple[Block, ...], point: np.ndarray) -> bool:
    """Whether a block holds the point, or nearly so."""
    for block in blocks:
        c, s = np.cos(block.yaw), np.sin(block.yaw)
        half = 0.5 * np.array(block.size)
        offset = point - (block.x, block.y, block.z + half[2])
        local = np.array([c * offset[0] + s * offset[1], c * offset[1] - s * offset[0], offset[2]])
        if (np.abs(local) < half + 0.01).all():
            return True
    return False
