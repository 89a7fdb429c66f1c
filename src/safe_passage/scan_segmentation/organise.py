"""Scan lines of clouds that come without them: by azimuth about the rotation axis."""

from __future__ import annotations

import math

import numpy as np

from safe_passage.core.errors import InputError
from safe_passage.scan_segmentation.reading import Cloud
from safe_passage.scan_segmentation.scan import OrganisedScan, Vector, axis_rotation

FLAT = 0.02  # [m] rms of a line's points from a plane
LEAST_POINTS = 20  # of a line that tells where its plane is
FEWEST, MOST = 8, 20_000  # lines that a cloud can have
GAPS = (3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5)  # [rad] between lines, tried from wide to fine
TIGHT = 0.25  # of the way to the next line that a line may be wide
SHARED = 0.002  # of the points may fall into a cell with another, which is lost
MADE_UP = math.radians(0.5)  # between lines where the cloud has none
ON_AXIS = 0.03  # [m] that a scanner may be beside the axis and counts as on it


def organise(
    cloud: Cloud,
    up: Vector = (0.0, 0.0, 1.0),
    axis: Vector | None = None,
    origin: Vector | None = None,
) -> OrganisedScan:
    """Its scan lines.

    Rows (or columns) of an organised cloud that lie in planes are its lines, and the planes' common
    direction is the axis. Of others the azimuth tells the lines, about `axis` or, without one, the
    axis about which azimuths repeat.

    Args:
        up: unit, against gravity.
        axis: of the rotation, if it is known.
        origin: [m] of the scanner, if it is not the cloud's.
    """
    known = np.isfinite(cloud.points).all(axis=2)
    if not known.any():
        raise InputError("all points are NaN or infinite")
    if cloud.points.shape[0] > 1:
        for turned in (False, True):
            points = cloud.points.swapaxes(0, 1) if turned else cloud.points
            found = _planar_lines(points, axis)
            if found is None:
                continue
            remission = cloud.remission
            if remission is not None and turned:
                remission = remission.T
            found_axis, beta, seen_origin = found
            place = tuple(origin or (cloud.origin if any(cloud.origin) else seen_origin))
            return OrganisedScan(points, beta, remission, found_axis, place, up)  # type: ignore
    return _by_azimuth(cloud, known, up, axis, origin or cloud.origin)


def _planar_lines(
    points: np.ndarray, axis: Vector | None
) -> tuple[Vector, np.ndarray, Vector] | None:
    """Axis, beta and origin of rows that lie in planes about one axis; None: they do not."""
    normals, centres, weights, rows = [], [], [], []
    flat = 0
    for row, line in enumerate(points):
        line = line[np.isfinite(line).all(axis=1)]
        if len(line) < LEAST_POINTS:
            continue
        centre = line.mean(axis=0)
        values, vectors = np.linalg.eigh(np.cov((line - centre).T))
        flat += bool(values[0] < FLAT**2)
        normals.append(vectors[:, 0])
        centres.append(centre)
        weights.append(values[1])  # a straight line lies in many planes
        rows.append(row)
    if len(rows) < FEWEST or flat < 0.8 * len(rows):
        return None
    n, c, w = np.array(normals), np.array(centres), np.sqrt(np.array(weights))
    spread, vectors = np.linalg.eigh((n * w[:, None]).T @ n)
    unit = np.array(axis) if axis is not None else vectors[:, 0]
    if axis is None and not spread[0] < 0.05 * spread[1]:
        return None
    unit = unit * np.sign(unit[np.argmax(np.abs(unit))])
    # all planes pass the scanner: the place that is nearest to all of them, on the axis
    A = np.vstack([n * w[:, None], unit[None] * w.sum()])
    b = np.append(np.einsum("ij,ij->i", n, c) * w, 0.0)
    place, *_ = np.linalg.lstsq(A, b, rcond=None)
    if np.linalg.norm(place) < ON_AXIS:
        place = np.zeros(3)
    return _vector(unit), _row_angles(points - place, unit), _vector(place)


def _row_angles(points: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """(H,) [rad] of rows about the axis, rows without points between their neighbours."""
    R = axis_rotation(_vector(axis))
    x, y = points @ R[0], points @ R[1]
    # of both sides of the axis the doubled angle is the same
    doubled = np.array([_mean_angle(2.0 * np.arctan2(b, a), np.hypot(a, b)) for a, b in zip(x, y)])
    known = np.isfinite(doubled)
    beta = np.full(len(points), np.nan)
    beta[known] = 0.5 * np.unwrap(doubled[known])
    rows = np.arange(len(points))
    return np.interp(rows, rows[known], beta[known])


def _mean_angle(angles: np.ndarray, weights: np.ndarray) -> float:
    inside = np.isfinite(angles)
    if not inside.any():
        return math.nan
    return float(np.angle((weights[inside] * np.exp(1j * angles[inside])).sum()))


def _by_azimuth(
    cloud: Cloud, known: np.ndarray, up: Vector, axis: Vector | None, origin: Vector
) -> OrganisedScan:
    """Lines of an unordered cloud."""
    points = cloud.points[known].astype(np.float64)
    remission = None if cloud.remission is None else cloud.remission[known]
    from_origin = points - np.asarray(origin)
    notes: tuple[str, ...] = ()
    tried, azimuth, seen = _found_lines(from_origin, axis)
    line = np.zeros(len(points), int) if seen is None else seen
    if seen is None:
        tried = axis or up
        azimuth = _azimuth(from_origin, tried)
        made = np.floor(azimuth / MADE_UP).astype(int)
        line = np.unique(made, return_inverse=True)[1]
        notes = ("the cloud shows no scan lines: half a degree each, about the vertical",)
    R = axis_rotation(tried)
    elevation = np.arctan2(from_origin @ R[2], np.hypot(from_origin @ R[0], from_origin @ R[1]))
    order = np.lexsort((elevation, line))
    line = line[order]
    counts = np.bincount(line)
    column = _columns(line, elevation[order], counts)
    shape = len(counts), int(column.max()) + 1
    organised = np.full((*shape, 3), np.nan)
    organised[line, column] = points[order]
    beta = np.zeros(shape[0])
    np.add.at(beta, line, azimuth[order])
    image = None
    if remission is not None:
        image = np.zeros(shape)
        image[line, column] = remission[order]
    beta /= counts
    return OrganisedScan(organised, beta, image, _vector(tried), _vector(origin), up, notes)


def _columns(line: np.ndarray, elevation: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """(N,) of points sorted by line and elevation: beams at one angle in one column, lost ones too.

    Where no even steps of the elevation part the points they are numbered along their lines.
    """
    ranked = np.arange(len(line)) - (np.cumsum(counts) - counts)[line]
    steps = np.diff(elevation)[np.diff(line) == 0]
    step = float(np.median(steps)) if len(steps) else 0.0
    if step <= 0.0:
        return ranked
    column = np.round((elevation - elevation.min()) / step).astype(int)
    shared = (np.diff(column) == 0) & (np.diff(line) == 0)
    return column if shared.mean() < SHARED and column.max() < 4 * ranked.max() else ranked


def _found_lines(
    points: np.ndarray, axis: Vector | None
) -> tuple[Vector, np.ndarray, np.ndarray | None]:
    """The first axis that shows lines, the azimuths (N,) about it, and the lines (N,)."""
    for tried in _axes(points, axis):
        azimuth = _azimuth(points, tried)
        line = _lines(azimuth)
        if line is not None:
            break
    return tried, azimuth, line


def _azimuth(points: np.ndarray, axis: Vector) -> np.ndarray:
    """(N,) [rad] about the axis, from the widest gap on: no line lies at both ends."""
    R = axis_rotation(axis)
    azimuth = np.arctan2(points @ R[1], points @ R[0])
    order = np.sort(azimuth)
    steps = np.diff(order, append=order[0] + 2.0 * math.pi)
    widest = int(steps.argmax())
    cut = order[widest] + 0.5 * steps[widest]
    return cut + (azimuth - cut) % (2.0 * math.pi)


def _axes(points: np.ndarray, axis: Vector | None) -> list[Vector]:
    """Axes to try: the one given, else the one that the points' order tells, else x, y, z."""
    if axis is not None:
        return [axis]
    found: list[Vector] = [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
    some = points[:: max(1, len(points) // 50_000)] if len(points) < 50 else points[:50_000]
    normals = np.cross(some[:-5], some[5:])
    length = np.linalg.norm(normals, axis=1)
    normals = normals[length > 1e-6] / length[length > 1e-6][:, None]
    if len(normals) > 100:
        values, vectors = np.linalg.eigh(normals.T @ normals)
        if values[0] < 0.02 * values[1]:
            found.append(_vector(vectors[:, 0]))
    return found


def _lines(azimuth: np.ndarray) -> np.ndarray | None:
    """(N,) line of each azimuth; None: they do not gather in lines."""
    order = np.argsort(azimuth)
    steps = np.diff(azimuth[order])
    for gap in GAPS:
        new = steps > gap
        count = int(new.sum()) + 1
        if not FEWEST <= count <= min(MOST, len(azimuth) // 8):
            continue
        line = np.concatenate([[0], np.cumsum(new)])
        middle = np.bincount(line, azimuth[order]) / np.bincount(line)
        width = np.sqrt(np.mean((azimuth[order] - middle[line]) ** 2))
        spacing = float(np.median(np.diff(middle)))
        if width < TIGHT * spacing:
            found = np.empty(len(azimuth), int)
            found[order] = line
            return found
    return None


def _vector(values: np.ndarray | Vector) -> Vector:
    x, y, z = (float(v) for v in values)
    return x, y, z
