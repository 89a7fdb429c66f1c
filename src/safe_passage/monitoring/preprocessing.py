"""Obstacle points from raw measurements (paper 000, 3.2 and 3.3): what is specific to a sensor."""

from __future__ import annotations

import math

import numpy as np

from safe_passage.monitoring.parameters import SourceParameters

SHADOW = 0.8  # [m] by which a thing must be nearer to hide another: one leg before the other is not
FILL = 0.06  # [m] between the points put on a surface seen at a glancing angle
OFF_LINE = 0.02  # [m] that a point may lie off a straight surface, besides a tenth of its distance


def scan_points(
    ranges: np.ndarray,
    angle_min: float,
    angle_increment: float,
    T_base_laser: np.ndarray,
    source: SourceParameters,
) -> np.ndarray:
    """Obstacle points of a scan.

    Args:
        ranges: (N,) [m]; NaN, inf, 0 and what lies outside the source's range is no obstacle.
        angle_min, angle_increment: [rad], the increment may be negative.
        T_base_laser: (4, 4) of the laser, mounted in any way.
        source: of the scan.

    Returns:
        (M, 4) x, y, z [m], frame base, and 1 where the object may go on behind a nearer one.
    """
    ranges = np.asarray(ranges, float)
    angles = angle_min + angle_increment * np.arange(len(ranges))
    valid = (ranges > max(source.range_min, 0.0)) & (ranges <= source.range_max)
    if source.crop_margin > 0.0 and len(ranges):
        margin = math.ceil(source.crop_margin / max(abs(angle_increment), 1e-9))
        valid[:margin], valid[len(ranges) - margin :] = False, False
    if source.veil_angle > 0.0:
        valid &= ~veiling(ranges, angle_increment, source.veil_angle, source.veil_points)
    beams = np.where(valid, ranges, np.nan)[:, None] * np.stack([np.cos(angles), np.sin(angles)], 1)
    between = between_beams(beams, source.glancing_gap)
    flat = np.concatenate([beams[valid], between])
    points = np.column_stack([flat, np.zeros(len(flat))])
    seen = np.where(ranges > source.range_max, 0.0, ranges)  # what lies beyond is cut off too
    seen = np.where(np.isinf(ranges), np.inf, seen)
    hidden = np.concatenate([shadowed(seen, valid)[valid], np.zeros(len(between), bool)])
    return np.column_stack([points @ T_base_laser[:3, :3].T + T_base_laser[:3, 3], hidden])


def shadowed(ranges: np.ndarray, valid: np.ndarray) -> np.ndarray:
    """Which points (N,) are the last that is seen of something: before a nearer thing hides the
    rest, or at the end of the scan.

    What moves there may be the shadow's edge, not the thing.

    Args:
        ranges: (N,) [m], inf: nothing there, 0: something that does not count.
        valid: (N,) which of them are points.
    """
    if not len(ranges):
        return np.zeros(0, bool)
    with np.errstate(invalid="ignore"):
        r = np.where(ranges >= 0.0, ranges, np.inf)  # NaN: nobody knows
    edge = np.concatenate([[0.0], r, [0.0]])  # beyond the scan everything is hidden
    nearer = np.minimum(edge[:-2], edge[2:])
    return valid & (nearer < r - SHADOW)


def veiling(ranges: np.ndarray, increment: float, least: float, longest: int) -> np.ndarray:
    """Which of `ranges` (N,) [m] float between a near and a far surface (3.2).

    A beam that meets the edge of a near object gives a mean of near and far, so the step to each of
    its neighbours is steep: the line between them and the beam form less than the angle `least`
    [rad]. A single steep step is the edge itself; one or some (`longest`) points amid such steps
    float; steps that go on farther than that are a wall seen at a glancing angle.

    Args:
        increment: [rad] between beams.
    """
    r = np.where(np.isfinite(ranges) & (ranges > 0.0), ranges, np.nan)
    if len(r) < 3:
        return np.zeros(len(r), bool)
    step = np.diff(r)
    with np.errstate(invalid="ignore"):
        nearer = np.minimum(r[:-1], r[1:])
        steep = nearer * math.sin(abs(increment)) < np.abs(step) * math.tan(least)
    direction = np.where(steep, np.sign(step), 0.0)  # 0 too where there is no return
    start = np.flatnonzero(np.append(True, direction[1:] != direction[:-1]))
    length = np.diff(np.append(start, len(direction)))
    run = np.repeat(np.arange(len(start)), length)
    floats = (direction[start] != 0.0) & (length >= 2) & (length <= longest + 1)
    within = np.zeros(len(r), bool)
    within[1:-1] = (run[:-1] == run[1:]) & floats[run[:-1]]
    return within


def between_beams(points: np.ndarray, longest: float) -> np.ndarray:
    """What a surface seen at a glancing angle has between its beams, so that it stays one object.

    Two neighbouring points belong to one straight surface where those before and after them lie on
    the same line, at distances that change as they do along a line.

    Args:
        points: (N, 2) [m] of the beams in their order, NaN: no return.
        longest: [m] gap that is closed.

    Returns:
        (M, 2) [m], FILL apart.
    """
    if len(points) < 4 or longest <= 0.0:
        return np.empty((0, 2))
    before, start, end, after = points[:-3], points[1:-2], points[2:-1], points[3:]
    gap = np.hypot(*(end - start).T)
    with np.errstate(invalid="ignore", divide="ignore"):
        along = (end - start) / gap[:, None]
        straight = (gap > FILL) & (gap <= longest)
        for outer, inner in ((before, start), (after, end)):
            step = outer - inner
            off = np.abs(along[:, 0] * step[:, 1] - along[:, 1] * step[:, 0])
            length = np.hypot(*step.T)
            straight &= (
                (off < OFF_LINE + 0.1 * length) & (length < 2.5 * gap) & (gap < 2.5 * length)
            )
    start, end, count = start[straight], end[straight], (gap[straight] / FILL).astype(int)
    owner = np.repeat(np.arange(len(count)), count)
    share = (np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count) + 1) / (count + 1)[
        owner
    ]
    return start[owner] + share[:, None] * (end - start)[owner]


def cloud_points(
    points: np.ndarray, T_base_sensor: np.ndarray, source: SourceParameters
) -> np.ndarray:
    """Obstacle points of a cloud: those in the height band between floor and ceiling (3.3).

    Args:
        points: (N, 3) [m] in the sensor's frame, NaN and inf allowed.
        T_base_sensor: (4, 4).
        source: of the cloud.

    Returns:
        (M, 3) [m], frame base.
    """
    points = np.asarray(points)
    R, t = T_base_sensor[:3, :3].astype(points.dtype), T_base_sensor[:3, 3].astype(points.dtype)
    with np.errstate(invalid="ignore", over="ignore"):
        squared = np.einsum("ij,ij->i", points, points)
        near = (squared >= source.range_min**2) & (squared <= source.range_max**2)
    in_base = points[near] @ R.T + t  # NaN compares false: gone
    z = in_base[:, 2]
    return in_base[(z >= source.min_height) & (z <= source.max_height)]


def outside(points: np.ndarray, polygon: np.ndarray, padding: float) -> np.ndarray:
    """Which of `points` (N, 2+) lie outside the convex `polygon` (M, 2), grown by `padding` [m]."""
    if not len(polygon):
        return np.ones(len(points), bool)
    x, y = points[:, 0], points[:, 1]
    signed_area = float(np.cross(polygon, np.roll(polygon, -1, axis=0)).sum())
    turn = 1.0 if signed_area > 0.0 else -1.0
    inside = np.ones(len(points), bool)
    for (ax, ay), (bx, by) in zip(polygon, np.roll(polygon, -1, axis=0)):
        length = math.hypot(bx - ax, by - ay)
        left = turn * ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / max(length, 1e-9)
        inside &= left > -padding
    return ~inside
