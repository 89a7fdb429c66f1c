"""Planes of similar line segments (paper 003, sections II-B and II-C)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import safe_passage._scan_segmentation as kernels
from safe_passage.scan_segmentation.lines import Segments
from safe_passage.scan_segmentation.parameters import SegmentationParameters
from safe_passage.scan_segmentation.scan import OrganisedScan


@dataclass(frozen=True)
class Plane:
    """normal . p + offset = 0. Frame: the scanner's; the normal points to the scanner."""

    normal: np.ndarray  # (3,)
    offset: float  # [m]
    rms: float  # [m] of the points of its segments

    def distance(self, points: np.ndarray) -> np.ndarray:
        """[m] of points (..., 3), positive on the scanner's side."""
        return points @ self.normal + self.offset

    def basis(self) -> np.ndarray:
        """(2, 3) unit vectors in the plane."""
        aside = np.eye(3)[np.argmin(np.abs(self.normal))]
        u = np.cross(self.normal, aside)
        u /= np.linalg.norm(u)
        return np.stack([u, np.cross(self.normal, u)])


def line_spacing(beta: np.ndarray) -> float:
    """[rad] between neighbouring scan lines."""
    steps = np.abs(np.diff(np.unwrap(beta)))
    return float(np.median(steps)) if len(steps) else 0.0


def is_closed(beta: np.ndarray) -> bool:
    """Whether the first line is the last one's neighbour: a whole revolution."""
    turned = np.ptp(np.unwrap(beta)) + 2.0 * line_spacing(beta)
    return bool(turned >= 2.0 * np.pi)


def cluster_segments(
    scan: OrganisedScan, segments: Segments, p: SegmentationParameters
) -> tuple[list[Plane], np.ndarray]:
    """Planes, and the plane (S,) of each segment, -1: none."""
    origin = np.asarray(scan.origin, float)
    where = np.stack([segments.row, segments.first, segments.last], axis=1)
    ends = np.hstack([segments.start - origin, segments.end - origin])
    owner, found = kernels.cluster_segments(
        scan.points.astype(np.float64) - origin,
        where,
        ends,
        p.similar_distance,
        p.similar_angle,
        p.first_fit,
        p.refit_every,
        p.segments_for(len(scan.beta)),
        p.plane_tolerance,
        p.merge_angle,
        line_spacing(scan.beta),
        is_closed(scan.beta),
    )
    planes = [Plane(row[:3], float(row[3] - row[:3] @ origin), float(row[4])) for row in found]
    return planes, owner
