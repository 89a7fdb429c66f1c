"""What a measurement saw free: how far its beams went in each direction (not in the paper)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Union

import numpy as np
from scipy.ndimage import minimum_filter

from safe_passage.core.geometry import Pose, compose, inverse

BINS = 720  # of a turn of a scanner: half a degree
BEYOND = 0.25  # [m] that a beam must have gone on, for noise, cells and drift
BESIDE = 0.12  # [m] to both sides that beams must have passed
SAMPLES = np.linspace(-1.0, 1.0, 5)[:, None]  # of a cell's width
STEP = math.radians(2.0)  # of a cloud's directions
TURN, RISE = round(2.0 * math.pi / STEP), round(math.pi / STEP)
NARROW = 0.5  # of a turn that a camera sees, at most; what sees more turns
HEIGHTS = (0.25, 0.5, 0.75)  # of a thing, from its lowest to its highest point


@dataclass(frozen=True)
class ScanView:
    """Of a scan. Looks along base's x from `origin` [m] in base at the scan's time."""

    origin: tuple[float, float]
    reach: np.ndarray  # (BINS,) [m] free up to there in each direction, 0: nobody knows

    @staticmethod
    def of(points: np.ndarray, origin: tuple[float, float]) -> ScanView:
        """Of obstacle points (N, 2+) [m] in base."""
        relative = points[:, :2] - np.array(origin)
        nearest = np.full(BINS, np.inf)
        np.minimum.at(nearest, _bins(np.arctan2(relative[:, 1], relative[:, 0])), _length(relative))
        between = np.minimum(np.roll(nearest, 1), np.roll(nearest, -1))  # of a coarse scan
        both = np.isfinite(np.roll(nearest, 1)) & np.isfinite(np.roll(nearest, -1))
        known = np.where(np.isfinite(nearest), nearest, np.where(both, between, 0.0))
        return ScanView(origin, known)

    def beams(self, at: np.ndarray, height: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which points (N, 2) [m] in base beams have passed, and at which they ended.

        height: is not asked; only who knows that a scanner sees these points may ask it.
        """
        relative = at - np.array(self.origin)
        distance = _length(relative)
        width = np.arcsin(np.minimum(BESIDE / np.maximum(distance, BESIDE), 1.0))
        bearing = np.arctan2(relative[:, 1], relative[:, 0])
        beyond = self.reach[_bins(bearing + SAMPLES * width)] - distance
        return beyond.min(axis=0) > BEYOND, (np.abs(beyond) < BESIDE).any(axis=0)


@dataclass(frozen=True)
class CloudView:
    """Of a depth camera's cloud, floor included."""

    origin: tuple[float, float, float]  # [m] in base
    reach: np.ndarray  # (RISE, TURN) [m] from below, axes of base; 0: nobody knows

    @staticmethod
    def of(points: np.ndarray, T_base_sensor: np.ndarray) -> CloudView | None:
        """None for what sees more than half a turn: between a 3D lidar's rings nobody knows.

        Args:
            points: (N, 3) [m] all that was measured, sensor's frame; NaN allowed.
        """
        distance = np.linalg.norm(points, axis=1)
        known = np.isfinite(distance) & (distance > 0.0)
        relative = points[known] @ T_base_sensor[:3, :3].T.astype(points.dtype)
        nearest = np.full(RISE * TURN, np.inf, np.float32)
        row, column = _directions(relative)
        np.minimum.at(nearest, row * TURN + column, distance[known])
        reach = np.where(np.isfinite(nearest), nearest, 0.0).reshape(RISE, TURN)
        if (reach > 0.0).any(axis=0).mean() > NARROW:
            return None
        x, y, z = T_base_sensor[:3, 3].tolist()
        return CloudView((x, y, z), minimum_filter(reach, 3, mode=("nearest", "wrap")))

    def beams(self, at: np.ndarray, height: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Through which things beams have passed, and at which they ended.

        Args:
            at: (N, 2) [m] in base.
            height: (N, 2) [m] lowest and highest point over base.
        """
        passed, ended = np.ones(len(at), bool), np.zeros(len(at), bool)
        for share in HEIGHTS:
            z = height[:, 0] + share * (height[:, 1] - height[:, 0])
            relative = np.column_stack([at, z]) - np.array(self.origin)
            row, column = _directions(relative)
            beyond = self.reach[row, column] - np.linalg.norm(relative, axis=1)
            passed &= beyond > BEYOND
            ended |= np.abs(beyond) < BESIDE
        return passed, ended


View = Union[ScanView, CloudView]


def seen_from(pose: Pose, other: Pose, points: np.ndarray) -> np.ndarray:
    """Points (N, 2) [m] of base at `pose` in base at `other`, both in the odometry's frame."""
    x, y, yaw = compose(inverse(other), pose)
    c, s = math.cos(yaw), math.sin(yaw)
    return points @ np.array([[c, s], [-s, c]]) + (x, y)


def _bins(angles: np.ndarray) -> np.ndarray:
    return np.floor(angles * (BINS / (2.0 * math.pi))).astype(np.int64) % BINS


def _directions(relative: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Row and column (N,) of `reach` for points (N, 3) around the sensor."""
    turn = np.arctan2(relative[:, 1], relative[:, 0])
    rise = np.arctan2(relative[:, 2], _length(relative)) + 0.5 * math.pi
    row = np.minimum(np.floor(rise / STEP).astype(np.int64), RISE - 1)
    return row, np.floor(turn / STEP).astype(np.int64) % TURN


def _length(vectors: np.ndarray) -> np.ndarray:
    return np.hypot(vectors[:, 0], vectors[:, 1])
