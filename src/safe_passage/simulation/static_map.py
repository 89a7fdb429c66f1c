"""The map of a world's blocks: what does not move and a robot could touch."""

from __future__ import annotations

import cv2
import numpy as np

from safe_passage.core.grid import GridMap
from safe_passage.simulation.worlds import World

MARGIN = 0.3  # [m] around the hall, all occupied
FLAT = 0.03  # [m] lower blocks are driven over
FINE = 4  # a cell is occupied if any of its FINE x FINE parts is
INSET = 0.1  # of a part: what only touches a cell's border does not reach into it


def make_map(world: World, robot_height: float, resolution: float = 0.05) -> GridMap:
    """Cells that a block covers below `robot_height` [m]; frame map."""
    origin = (-0.5 * world.size[0] - MARGIN, -0.5 * world.size[1] - MARGIN)
    rows, columns = (round((side + 2 * MARGIN) / resolution) for side in world.size[::-1])
    picture = np.zeros((FINE * rows, FINE * columns), np.uint8)
    shift = 4  # bits of OpenCV's fixed-point coordinates
    for block in world.blocks:
        if block.z < robot_height and block.z + block.size[2] > FLAT:
            outline = block.corners(INSET * resolution / FINE)
            corners = (outline - np.array(origin)) / resolution * FINE - 0.5  # in parts' middles
            fixed = np.rint(corners * 2**shift).astype(np.int32)
            cv2.fillConvexPoly(picture, fixed, 1, shift=shift)
    occupied = picture.reshape(rows, FINE, columns, FINE).any(axis=(1, 3))
    middles = ((np.arange(count) + 0.5) * resolution for count in (columns, rows))
    beyond_x, beyond_y = (np.abs(at + low) > -low - MARGIN for at, low in zip(middles, origin))
    return GridMap(occupied | beyond_x | beyond_y[:, None], origin, resolution)
