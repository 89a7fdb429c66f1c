"""Ground planes among all planes, and the height of the ground everywhere (paper 003, II-D)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from safe_passage.scan_segmentation.parameters import SegmentationParameters
from safe_passage.scan_segmentation.scan import Level, Reason, SegmentationError, unique_cells
from safe_passage.scan_segmentation.validation import ValidPlane

SEAM_CELLS = 4  # rough cells along which two planes meet, at least
SEAM_REACH = 3  # rough cells between their points there


@dataclass(frozen=True)
class GroundPlane:
    """z = slope . (x, y) + height. Frame: level."""

    index: int  # in the list of valid planes
    slope: np.ndarray  # (2,)
    height: float  # [m] under the scanner: negative

    def z(self, xy: np.ndarray) -> np.ndarray:
        """[m] at points (..., 2)."""
        return xy @ self.slope + self.height

    @property
    def angle(self) -> float:
        """[rad] to the horizontal."""
        return math.atan(float(np.linalg.norm(self.slope)))


def ground_candidates(
    planes: list[ValidPlane], level: Level, max_slope: float
) -> list[GroundPlane]:
    """Planes that are not too steep and lie under the scanner.

    Raises:
        SegmentationError: there is none.
    """
    found, above = [], 0
    for i, valid in enumerate(planes):
        normal = level.R_level_scan @ valid.plane.normal
        if abs(normal[2]) < math.cos(max_slope) - 1e-9:
            continue
        if normal[2] < 0.0:  # normals point to the scanner: a ceiling
            above += 1
            continue
        offset = float(valid.plane.distance(level.origin))
        found.append(GroundPlane(i, -normal[:2] / normal[2], -offset / float(normal[2])))
    if not found:
        if above:
            raise SegmentationError(
                Reason.SCANNER_BELOW_GROUND, f"all {above} level planes lie above the scanner"
            )
        raise SegmentationError(Reason.NO_GROUND, f"none of {len(planes)} planes is level enough")
    return found


def select_ground(
    candidates: list[GroundPlane],
    planes: list[ValidPlane],
    points: np.ndarray,
    labels: np.ndarray,
    p: SegmentationParameters,
) -> list[GroundPlane]:
    """The largest plane, whatever a seam joins to it, and what is large enough by itself.

    A table's or a crate's top is level and under the scanner, too, but nothing leads up to it.

    Args:
        points: (N, 3) [m] all points. Frame: level.
        labels: (N,) their planes.
    """
    largest = max(candidates, key=lambda g: planes[g.index].area)
    chosen, rest = [largest], [g for g in candidates if g is not largest]
    cells = {}
    if rest:
        cells = {g.index: _cells(points[labels == g.index], p.rough_cell) for g in candidates}
    grew = True
    while grew:
        joined = [g for g in rest if any(_seam(g, c, cells, p) for c in chosen)]
        chosen += joined
        rest = [g for g in rest if g not in joined]
        grew = bool(joined)
    chosen += [g for g in rest if planes[g.index].area >= p.apart_area]
    area = sum(planes[g.index].area for g in chosen)
    if area < p.ground_area:
        raise SegmentationError(
            Reason.FEW_GROUND_POINTS, f"{area:.1f} m^2 of ground, {p.ground_area:.1f} are needed"
        )
    return chosen


def _cells(points: np.ndarray, cell: float) -> set[tuple[int, int]]:
    return set(map(tuple, unique_cells(points[:, :2], cell)[0].tolist()))


def _seam(a: GroundPlane, b: GroundPlane, cells: dict, p: SegmentationParameters) -> bool:
    """Whether points of both lie side by side where the planes are equally high."""
    others = cells[b.index]
    reach = range(-SEAM_REACH, SEAM_REACH + 1)
    meeting = 0
    for column, row in cells[a.index]:
        at = (np.array([column, row]) + 0.5) * p.rough_cell
        if abs(float(a.z(at) - b.z(at))) > 2.0 * p.ground_tolerance:
            continue
        meeting += any((column + i, row + k) in others for i in reach for k in reach)
        if meeting >= SEAM_CELLS:
            return True
    return False


@dataclass(frozen=True)
class GroundHeight:
    """The ground plane of each rough cell; where none was seen, the nearest one's."""

    planes: list[GroundPlane]
    which: np.ndarray  # (rows, columns) int, index into `planes`
    origin: np.ndarray  # (2,) [m] lower-left corner
    cell: float  # [m]

    def z(self, xy: np.ndarray) -> np.ndarray:
        """[m] of the ground at points (N, 2); frame: level."""
        slopes = np.array([g.slope for g in self.planes])
        heights = np.array([g.height for g in self.planes])
        of = self.plane_at(xy)
        return np.einsum("ij,ij->i", xy, slopes[of]) + heights[of]

    def plane_at(self, xy: np.ndarray) -> np.ndarray:
        """(N,) index into `planes` at points (N, 2)."""
        rows, columns = self.which.shape
        at = np.floor((xy - self.origin) / self.cell)
        column = np.clip(at[:, 0], 0, columns - 1).astype(int)
        row = np.clip(at[:, 1], 0, rows - 1).astype(int)
        return self.which[row, column]


def ground_height(
    planes: list[GroundPlane],
    points: np.ndarray,
    labels: np.ndarray,
    origin: np.ndarray,
    shape: tuple[int, int],
    cell: float,
) -> GroundHeight:
    """Of cells where several planes have points, the lowest: what is above it stands on it.

    Args:
        points: (N, 3) [m] points of ground planes. Frame: level.
        labels: (N,) their valid planes.
        shape: rows, columns of the rough map.
    """
    rows, columns = shape
    z = np.full(shape, np.inf)
    which = np.full(shape, -1)
    row, column = np.mgrid[:rows, :columns]
    centres = origin + (np.stack([column, row], axis=-1) + 0.5) * cell
    for k, plane in enumerate(planes):
        own = points[labels == plane.index]
        at = np.floor((own[:, :2] - origin) / cell).astype(int)
        inside = ((at >= 0) & (at < [columns, rows])).all(axis=1)
        flat = at[inside, 1] * columns + at[inside, 0]
        seen = np.bincount(flat, minlength=rows * columns).reshape(shape) > 0
        height = plane.z(centres)
        lower = seen & (height < z)
        z[lower], which[lower] = height[lower], k
    nearest = ndimage.distance_transform_edt(which < 0, return_distances=False, return_indices=True)
    return GroundHeight(planes, which[tuple(nearest)], origin, cell)
