"""Where the robot's box fits, in all orientations (paper 003, section II-D). Frame: level."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

import safe_passage._scan_segmentation as kernels
from safe_passage.scan_segmentation.basic_map import Colour, ColourMap
from safe_passage.scan_segmentation.parameters import RobotConfiguration, SegmentationParameters


@dataclass(frozen=True)
class Rough:
    """What the two rough maps say of each rough cell."""

    free: np.ndarray  # (rows, columns) bool: the box fits wherever its centre is in the cell
    undecided: np.ndarray  # the same: the two maps differ


def orientations(walls: list[float], p: SegmentationParameters) -> np.ndarray:
    """(A,) [rad] of the box over half a turn: evenly spread, and along and across `walls`.

    A long box that stands a little askew needs more room in a door than a straight one.
    """
    even = math.pi * np.arange(p.orientations) / p.orientations
    along = np.array([w + turn for w in walls for turn in (0.0, math.pi / 2)]) % math.pi
    return np.unique(np.concatenate([along, even]).round(3))


def check_traversability(
    basic: ColourMap, robot: RobotConfiguration, walls: list[float], p: SegmentationParameters
) -> ColourMap:
    """Each cell's colour for the robot's centre: green, orange (narrow, or with care), else red."""
    angles = orientations(walls, p)
    blocked = (basic.cells == Colour.UNKNOWN) | (basic.cells == Colour.RED)
    times = round(p.rough_cell / basic.resolution)
    rough = rough_maps(blocked, robot, angles, times, basic.resolution)
    up = np.ones((times, times), np.uint8)
    fits = np.kron(rough.free.astype(np.uint8), up).astype(bool)
    narrow = fine_map(blocked, rough.undecided, robot, angles, times, basic.resolution)
    cells = np.where(basic.cells == Colour.UNKNOWN, Colour.UNKNOWN, Colour.RED).astype(np.uint8)
    cells[fits] = Colour.GREEN
    cells[narrow] = Colour.ORANGE
    careful = _reach(basic.cells == Colour.ORANGE, min(robot.box) / basic.resolution)
    cells[(cells == Colour.GREEN) & careful] = Colour.ORANGE
    return ColourMap(cells, basic.origin, basic.resolution)


def rough_maps(
    blocked: np.ndarray, robot: RobotConfiguration, angles: np.ndarray, times: int, fine: float
) -> Rough:
    """The box on the rough map, and the box enlarged.

    On a rough map an obstacle is somewhere in its cell, and so is the robot's centre. The first
    map takes both where they are farthest apart, so that no door is refused that the robot fits
    through; the second, its box half a cell larger for each of the two, where they are nearest.
    Where both agree no finer map would say anything else.
    """
    rows, columns = (n // times for n in blocked.shape)
    coarse = blocked.reshape(rows, times, columns, times).any(axis=(1, 3)).astype(np.uint8)
    row, column = np.mgrid[:rows, :columns]
    everywhere = np.stack([row.ravel(), column.ravel()], axis=1).astype(np.int32)
    half = [side / (times * fine) for side in robot.box]
    # middles of fine cells, in a rough one, are so far from its middle at most, seen at an angle
    off = (1.0 - 1.0 / times) * (np.abs(np.cos(angles)) + np.abs(np.sin(angles)))
    small = _fits(coarse, everywhere, angles, half, -off)
    large = np.zeros(rows * columns, bool)
    large[small] = _fits(coarse, everywhere[small], angles, half, off)
    large, small = large.reshape(rows, columns), small.reshape(rows, columns)
    return Rough(large, small & ~large)


def fine_map(
    blocked: np.ndarray,
    undecided: np.ndarray,
    robot: RobotConfiguration,
    angles: np.ndarray,
    times: int,
    fine: float,
) -> np.ndarray:
    """(rows, columns) bool: fine cells of undecided rough ones in which the box fits."""
    fits = np.zeros(blocked.shape, bool)
    ask = np.kron(undecided.astype(np.uint8), np.ones((times, times), np.uint8)).astype(bool)
    half_length, half_width = (side / fine for side in robot.box)
    free = np.pad((~blocked).astype(np.uint8), 1)  # nothing is known beyond the border
    room = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    fits |= ask & (room > math.hypot(half_length, half_width) + 1.0)
    ask &= ~fits & (room > min(half_length, half_width) - 1.0)
    at = np.argwhere(ask).astype(np.int32)
    if len(at):
        found = _fits(blocked.astype(np.uint8), at, angles, [half_length, half_width], 0.0)
        fits[at[found, 0], at[found, 1]] = True
    return fits


def _fits(
    blocked: np.ndarray,
    at: np.ndarray,
    angles: np.ndarray,
    half: list[float],
    grown: np.ndarray | float,
) -> np.ndarray:
    """(N,) bool: cells (N, 2) in which the box fits; half sizes, and what is added, in cells."""
    length = np.broadcast_to(half[0] + grown, angles.shape)
    width = np.broadcast_to(half[1] + grown, angles.shape)
    usable = (length >= 0.0) & (width >= 0.0)
    if not usable.all():  # a robot smaller than a cell: the first map excludes nothing
        return np.ones(len(at), bool)
    found = kernels.fit_box(
        np.ascontiguousarray(blocked), at, angles.tolist(), length.tolist(), width.tolist()
    )
    return np.asarray(found) >= 0


def _reach(cells: np.ndarray, radius: float) -> np.ndarray:
    """Cells within `radius` cells of the given."""
    if not cells.any():
        return cells
    away = cv2.distanceTransform((~cells).astype(np.uint8), cv2.DIST_L2, 3)
    return away <= radius
