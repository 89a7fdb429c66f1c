"""Where the scanners have seen nothing before: what is there now has come.

A beam that met something has passed through free space on its way. What stands now where beams have
passed a short while ago was not there then, whatever it touches now; what stands where they ended
was; of what lay behind their ends nothing is known. The paper knows moving from standing by tracks
alone, which cannot tell a walker close to a wall from the wall.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from safe_passage.core.geometry import Pose, compose, inverse
from safe_passage.monitoring.aggregation import Measurement
from safe_passage.monitoring.fusion_grid import FusionGrid

BINS = 720  # of a turn: half a degree
APART = 0.4  # [s] between the scans that are remembered
KEPT = 2.5  # [s] that they are
PASSING = 1.0  # [s] that a walker needs to pass a point; what was met before stands there
BEYOND = 0.25  # [m] that a beam must have gone on, for noise, cells and drift
BESIDE = 0.12  # [m] to both sides that beams must have passed
SAMPLES = np.linspace(-1.0, 1.0, 5)[:, None]  # of a cell's width


@dataclass(frozen=True)
class _View:
    """What one scan saw free."""

    stamp: float  # [s]
    pose: Pose  # of the scanner in the odometry's frame, looking along base's x
    reach: np.ndarray  # (BINS,) [m] free up to there in each direction, 0: nobody knows


class FreeSpace:
    """Remembers some scans of the last seconds."""

    def __init__(self) -> None:
        self._views: dict[str, deque[_View]] = {}
        self._last: dict[str, _View] = {}

    def add(self, measurement: Measurement) -> None:
        """Remember this one, if it is a scan and newer than its source's last."""
        last = self._last.get(measurement.source)
        if measurement.origin is None or (last and measurement.stamp <= last.stamp):
            return
        pose = compose(measurement.pose, (*measurement.origin, 0.0))
        relative = measurement.points[:, :2] - np.array(measurement.origin)
        view = _View(measurement.stamp, pose, _reach(relative))
        self._last[measurement.source] = view
        views = self._views.setdefault(measurement.source, deque())
        if not views or measurement.stamp - views[-1].stamp >= APART:
            views.append(view)

    def judged(self, grid: FusionGrid, pose: Pose, stamp: float) -> FusionGrid:
        """The grid around base at `pose`, with what is known of its cells a short while before, and
        whether the last scans still have what those put together show.

        Args:
            stamp: [s] now; what was seen too long ago is forgotten.
        """
        free, met = np.zeros((2, len(grid.cell)), bool)
        for views in self._views.values():
            while views and stamp - views[0].stamp > KEPT:
                views.popleft()
            for view in views:
                passed, ended = _beams(view, grid.position, pose)
                free |= passed
                if stamp - view.stamp > PASSING:
                    met |= ended
        left = np.zeros(len(grid.cell), bool)
        for view in self._last.values():
            if stamp - view.stamp < APART:
                left |= _beams(view, grid.position, pose)[0]
        left &= ~np.isfinite(grid.fresh[:, 2])
        return replace(grid, new=free & ~met, stood=met & ~free, left=left)

    def reset(self) -> None:
        """Forget everything."""
        self._views.clear()
        self._last.clear()


def _reach(points: np.ndarray) -> np.ndarray:
    """(BINS,) [m] nearest of `points` (N, 2) around the scanner; 0 where there is none."""
    nearest = np.full(BINS, np.inf)
    np.minimum.at(nearest, _bins(np.arctan2(points[:, 1], points[:, 0])), np.hypot(*points.T))
    between = np.minimum(np.roll(nearest, 1), np.roll(nearest, -1))  # of a coarse scan
    both = np.isfinite(np.roll(nearest, 1)) & np.isfinite(np.roll(nearest, -1))
    return np.where(np.isfinite(nearest), nearest, np.where(both, between, 0.0))


def _beams(view: _View, points: np.ndarray, pose: Pose) -> tuple[np.ndarray, np.ndarray]:
    """Through which points (N, 2), frame base at `pose`, beams have passed; at which they ended."""
    x, y, yaw = compose(inverse(view.pose), pose)
    c, s = math.cos(yaw), math.sin(yaw)
    px, py = c * points[:, 0] - s * points[:, 1] + x, s * points[:, 0] + c * points[:, 1] + y
    distance = np.hypot(px, py)
    width = np.arcsin(np.minimum(BESIDE / np.maximum(distance, BESIDE), 1.0))
    beyond = view.reach[_bins(np.arctan2(py, px) + SAMPLES * width)] - distance
    return beyond.min(axis=0) > BEYOND, (np.abs(beyond) < BESIDE).any(axis=0)


def _bins(angles: np.ndarray) -> np.ndarray:
    return np.floor(angles * (BINS / (2.0 * math.pi))).astype(np.int64) % BINS
