"""Jump-distance segmentation: a scan falls into pieces where neighbouring points lie far apart.

Arras, Mozos, Burgard, "Using boosted features for the detection of people in 2D range data",
ICRA 2007, section III.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from safe_passage.core.parameters import check_range
from safe_passage.leg_detection.scan import Scan


@dataclass(frozen=True)
class SegmentationParameters:
    """How a scan becomes segments with features: a model is trained for one of these only."""

    jump_distance: float = 0.13  # [m] neighbours farther apart belong to two segments
    min_points: int = 3  # segments of fewer points are not classified
    max_scan_gap: float = 0.5  # [s] between two scans, for the speed of a segment

    def __post_init__(self) -> None:
        check_range("jump_distance", self.jump_distance, 0.01, 2.0, "m")
        check_range("min_points", self.min_points, 2, 1000, "points")
        check_range("max_scan_gap", self.max_scan_gap, 0.0, 10.0, "s")


@dataclass(frozen=True)
class Segments:
    """All points of a scan, counter-clockwise, those of a segment one after the other."""

    points: np.ndarray  # (M, 2) [m] in the scanner's frame
    beams: np.ndarray  # (M,) int, the beam of each point
    starts: np.ndarray  # (K,) int, index of each segment's first point
    all_round: bool = False  # the last segment is the first one's neighbour

    def __len__(self) -> int:
        return len(self.starts)

    @property
    def ends(self) -> np.ndarray:
        """Index (K,) after each segment's last point."""
        return np.append(self.starts[1:], len(self.points)) if len(self) else self.starts

    @property
    def sizes(self) -> np.ndarray:
        """Number of points (K,) of each segment."""
        return self.ends - self.starts

    @property
    def owners(self) -> np.ndarray:
        """Segment (M,) of each point."""
        return np.repeat(np.arange(len(self)), self.sizes)

    def sums(self, values: np.ndarray) -> np.ndarray:
        """Sum (K,) over each segment of `values` (M,)."""
        return np.bincount(self.owners, weights=values, minlength=len(self))

    def centres(self) -> np.ndarray:
        """Mean point (K, 2) [m] of each segment."""
        return np.stack([self.sums(axis) for axis in self.points.T], axis=1) / self.sizes[:, None]


def segment(scan: Scan, jump_distance: float) -> Segments:
    """Cut `scan` where two neighbouring returns are farther apart than `jump_distance` [m].

    Beams without return are skipped: they cut only where the points beside them lie far apart.
    Where the scanner sees all round, a segment across the seam stays in one piece.
    """
    beams = np.flatnonzero(scan.returns())
    if scan.angle_increment < 0.0:
        beams = beams[::-1]
    angles = scan.angles()[beams]
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    points = np.asarray(scan.ranges, float)[beams, None] * directions
    jumps = np.linalg.norm(np.diff(points, axis=0), axis=1) > jump_distance
    starts = np.flatnonzero(np.concatenate([[True], jumps])[: len(points)])
    if scan.all_round and len(starts) > 1 and _near(points[0], points[-1], jump_distance):
        before_seam = len(points) - starts[-1]
        points, beams = np.roll(points, before_seam, axis=0), np.roll(beams, before_seam)
        starts = np.concatenate([[0], starts[1:-1] + before_seam])
    return Segments(points, beams, starts, scan.all_round)


def _near(a: np.ndarray, b: np.ndarray, distance: float) -> bool:
    return bool(np.linalg.norm(a - b) <= distance)
