"""Planes that exist: enough support, spread over enough area (paper 003, section II-C, fig. 6)."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import cv2
import numpy as np

import safe_passage._scan_segmentation as kernels
from safe_passage.scan_segmentation.lines import Segments
from safe_passage.scan_segmentation.parameters import SegmentationParameters
from safe_passage.scan_segmentation.planes import Plane
from safe_passage.scan_segmentation.scan import OrganisedScan

ALONG_SINE = 0.25  # of the angle between a plane and a segment whose points support it, at most
LEAST_POINTS = 20  # that lie on a plane and on no other
REFITS = 3
TRIM = 3.0  # times the median distance of points that a refit is made of: two standard deviations
NEAREST = 0.004  # [m] within which points always count


@dataclass(frozen=True)
class ValidPlane:
    """A plane of the scan and where on it there is something."""

    plane: Plane
    area: float  # [m^2] bright cells
    points: int  # that support it
    image: np.ndarray  # (rows, columns) bool, validated cells
    basis: np.ndarray  # (2, 3) unit, along the image's columns and rows
    corner: tuple[float, float]  # [m] of the image, along the basis
    cell: float  # [m]

    def contains(self, points: np.ndarray) -> np.ndarray:
        """(N,) whether points (N, 3) project into a validated cell or beside one."""
        grown = cv2.dilate(self.image.astype(np.uint8), np.ones((3, 3), np.uint8))
        return _look_up(grown, points @ self.basis.T, self.corner, self.cell)

    def outline(self) -> list[np.ndarray]:
        """Polygons (M, 3) [m] around the validated cells."""
        contours, _ = cv2.findContours(
            np.kron(self.image, np.ones((2, 2))).astype(np.uint8),
            cv2.RETR_EXTERNAL,
            cv2.CHAIN_APPROX_TC89_L1,
        )
        found = []
        for contour in contours:
            at = (contour[:, 0] + 0.5) * 0.5 * self.cell + np.array(self.corner)
            if len(at) >= 3:
                corners = at @ self.basis
                found.append(corners - self.plane.distance(corners)[:, None] * self.plane.normal)
        return found


def validate(
    scan: OrganisedScan,
    segments: Segments,
    planes: list[Plane],
    owner: np.ndarray,
    p: SegmentationParameters,
) -> tuple[list[ValidPlane], np.ndarray]:
    """Planes that exist, largest first, and the plane (H, W) of each point, -1: none.

    Args:
        owner: (S,) the plane that each segment is of, -1: none.
    """
    labels = np.full(scan.points.shape[:2], -1, np.int32)
    inside = scan.valid
    points = scan.points[inside].astype(np.float64)
    own = segments.of_points(labels.shape)[inside]
    equations = np.array([[*plane.normal, plane.offset] for plane in planes]).reshape(-1, 4)
    pairs = kernels.supporting(
        points, own, segments.directions, equations, p.plane_tolerance, ALONG_SINE
    )
    order = np.argsort(pairs[:, 0], kind="stable")
    pairs = pairs[order]
    bounds = np.searchsorted(pairs[:, 0], np.arange(len(planes) + 1))
    found = []
    for k, plane in enumerate(planes):
        support = pairs[bounds[k] : bounds[k + 1], 1]
        valid = _validated(plane, points[support], own[support] >= 0, p)
        if valid is not None:
            mine = owner[own[support]] == k if len(owner) else np.zeros(len(support), bool)
            mine &= own[support] >= 0
            better = dataclasses.replace(valid, plane=_refined(plane, points[support[mine]]))
            found.append((better, support, mine))
    found.sort(key=lambda one: -one[0].area)
    of = _labelled(points, found)
    # a plane whose points all lie nearer to others is another's double
    kept = np.bincount(of[of >= 0], minlength=len(found)) >= LEAST_POINTS
    renumbered = np.append(np.where(kept, np.cumsum(kept) - 1, -1), -1).astype(np.int32)
    labels[inside] = renumbered[of]
    return [valid for (valid, _, _), keep in zip(found, kept) if keep], labels


def _validated(
    plane: Plane, points: np.ndarray, on_segment: np.ndarray, p: SegmentationParameters
) -> ValidPlane | None:
    """The grey-scale image of supporting points, its bright areas that are large enough."""
    if not on_segment.any():
        return None
    basis = plane.basis()
    at = points @ basis.T
    corner = np.floor(at[on_segment].min(axis=0) / p.validation_cell) * p.validation_cell
    cells = np.floor((at[on_segment] - corner) / p.validation_cell).astype(int)
    columns, rows = cells.max(axis=0) + 1
    grey = np.bincount(cells[:, 1] * columns + cells[:, 0], minlength=rows * columns)
    bright = (grey.reshape(rows, columns) >= p.validation_points).astype(np.uint8)
    # a wall that crosses the plane lights a strip one or two cells wide: opening puts it out
    core = cv2.morphologyEx(bright, cv2.MORPH_OPEN, np.ones((2, 2), np.uint8))
    _, areas, stats, _ = cv2.connectedComponentsWithStats(core, connectivity=4)
    large = stats[:, cv2.CC_STAT_AREA] * p.validation_cell**2 >= p.validation_area
    large[0] = False
    if not large.any():
        return None
    image = large[areas]
    area = float(image.sum()) * p.validation_cell**2
    at_corner = (float(corner[0]), float(corner[1]))
    return ValidPlane(plane, area, len(points), image, basis, at_corner, p.validation_cell)


def _refined(plane: Plane, points: np.ndarray) -> Plane:
    """The plane of most of its points (N, 3): those of other surfaces beside it lie farther off."""
    for _ in range(REFITS):
        off = plane.distance(points)
        near = points[np.abs(off) <= max(NEAREST, TRIM * float(np.median(np.abs(off))))]
        if len(near) < 10:
            return plane
        centre = near.mean(axis=0)
        values, vectors = np.linalg.eigh(np.cov((near - centre).T))
        normal = vectors[:, 0] * np.sign(vectors[:, 0] @ plane.normal)
        plane = Plane(normal, float(-normal @ centre), float(np.sqrt(max(values[0], 0.0))))
    return plane


def _labelled(
    points: np.ndarray, found: list[tuple[ValidPlane, np.ndarray, np.ndarray]]
) -> np.ndarray:
    """(N,) its segment's plane, or the nearest that each point supports in its validated cells."""
    nearest = np.full(len(points), np.inf)
    labels = np.full(len(points), -1, np.int32)
    for k, (valid, support, mine) in enumerate(found):
        there = valid.contains(points[support])
        support, mine = support[there], mine[there]
        off = np.where(mine, -1.0, np.abs(valid.plane.distance(points[support])))
        closer = off < nearest[support]
        nearest[support[closer]] = off[closer]
        labels[support[closer]] = k
    return labels


def _look_up(
    image: np.ndarray, at: np.ndarray, corner: tuple[float, float], cell: float
) -> np.ndarray:
    column, row = np.floor((at - np.array(corner)) / cell).astype(int).T
    rows, columns = image.shape
    inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
    return inside & (image[np.where(inside, row, 0), np.where(inside, column, 0)] > 0)
