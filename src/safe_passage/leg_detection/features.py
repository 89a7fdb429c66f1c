"""The fourteen features of a scan's segments.

Arras, Mozos, Burgard, "Using boosted features for the detection of people in 2D range data",
ICRA 2007, section III; the numbers in this file are that paper's.
"""

from __future__ import annotations

import numpy as np

from safe_passage.leg_detection.scan import Scan
from safe_passage.leg_detection.segmentation import Segments

FEATURE_NAMES = (
    "number_of_points",
    "standard_deviation",  # [m]
    "mean_deviation_from_median",  # [m]
    "jump_from_preceding",  # [m]
    "jump_to_succeeding",  # [m]
    "width",  # [m]
    "linearity",  # [m^2]
    "circularity",  # [m^2]
    "radius",  # [m]
    "boundary_length",  # [m]
    "boundary_regularity",  # [m]
    "mean_curvature",  # [1/m]
    "mean_angular_difference",  # [rad]
    "mean_speed",  # [m/s]
)
MAX_JUMP = 5.0  # [m] longer jumps, and none because there is no neighbour, count as this
MAX_RADIUS = 5.0  # [m] of a fitted circle: flatter ones count as lines


def segment_features(segments: Segments, speeds: np.ndarray | None = None) -> np.ndarray:
    """Features (K, 14) of each segment, in the order of FEATURE_NAMES, always finite.

    What a segment has too few points for is 0, except a circle's radius: MAX_RADIUS.

    Args:
        segments: any sizes, one point included.
        speeds: (N,) [m/s] of the scan's beams, from `beam_speeds`; without it all speeds are 0.
    """
    if not len(segments):
        return np.zeros((0, len(FEATURE_NAMES)))
    squares, line, circle, radius = _fits(segments)
    return np.stack(
        [
            segments.sizes,  # 1
            np.sqrt(squares / np.maximum(segments.sizes - 1, 1)),  # 2
            _deviation_from_median(segments),  # 3
            *_jumps(segments),  # 4, 5
            np.linalg.norm(segments.points[segments.ends - 1] - _firsts(segments), axis=1),  # 6
            line,  # 7
            circle,  # 8
            radius,  # 9
            *_boundary(segments),  # 10, 11
            *_turns(segments),  # 12, 13
            _mean_speed(segments, speeds),  # 14
        ],
        axis=1,
    )


def beam_speeds(scan: Scan, before: Scan | None, max_gap: float) -> np.ndarray:
    """Change of range (N,) [m/s] of each beam since the scan before; NaN where it is not known.

    Positive: away from the scanner. The scanner's own motion is in it, as in the paper.

    Args:
        before: the scan before this one; None, other beams, a time that does not lie before, or
            more than `max_gap` [s] before: nothing is known.
    """
    unknown = np.full(len(scan.ranges), np.nan)
    if before is None or not scan.same_beams(before):
        return unknown
    gap = scan.stamp - before.stamp
    if not 0.0 < gap <= max_gap:
        return unknown
    both = scan.returns() & before.returns()
    change = np.subtract(scan.ranges, before.ranges, where=both, out=unknown)
    return change / gap


def _firsts(segments: Segments) -> np.ndarray:
    return segments.points[segments.starts]


def _fits(segments: Segments) -> tuple[np.ndarray, ...]:
    """Of each segment (K,): sum of squares about the mean, about the best line, about the best
    circle [m^2], and that circle's radius [m].

    Line: total least squares, whose residual is the scatter matrix's smaller eigenvalue. Circle:
    the algebraic fit of the paper, solved about the segment's mean. A circle beyond MAX_RADIUS is
    a line in the limit, and has its residual.
    """
    count = segments.sizes
    centres = segments.centres()
    u, v = (segments.points - centres[segments.owners]).T
    uu, vv, uv = (segments.sums(p) for p in (u * u, v * v, u * v))
    line = 0.5 * (uu + vv) - np.hypot(0.5 * (uu - vv), uv)
    square = u * u + v * v
    right_u, right_v = 0.5 * segments.sums(u * square), 0.5 * segments.sums(v * square)
    determinant = uu * vv - uv * uv
    with np.errstate(divide="ignore", invalid="ignore"):
        centre_u = (right_u * vv - right_v * uv) / determinant
        centre_v = (right_v * uu - right_u * uv) / determinant
        radius = np.sqrt(centre_u**2 + centre_v**2 + (uu + vv) / count)
        distance = np.hypot(u - centre_u[segments.owners], v - centre_v[segments.owners])
        circle = segments.sums((distance - radius[segments.owners]) ** 2)
        round_enough = (count >= 3) & (radius < MAX_RADIUS)
    line = np.maximum(line, 0.0)  # rounding
    return (
        uu + vv,
        line,
        np.where(round_enough, circle, line),
        np.where(round_enough, radius, MAX_RADIUS),
    )


def _deviation_from_median(segments: Segments) -> np.ndarray:
    """Mean distance (K,) [m] to the median, which is the paper's: that of x and that of y."""
    low = segments.starts + (segments.sizes - 1) // 2
    high = segments.starts + segments.sizes // 2
    ordered = [axis[np.lexsort((axis, segments.owners))] for axis in segments.points.T]
    median = np.stack([0.5 * (axis[low] + axis[high]) for axis in ordered], axis=1)
    away = np.linalg.norm(segments.points - median[segments.owners], axis=1)
    return segments.sums(away) / segments.sizes


def _jumps(segments: Segments) -> tuple[np.ndarray, np.ndarray]:
    """Distance (K,) [m] from the segment before and to the one after, counter-clockwise."""
    ends = segments.points[segments.ends - 1]
    gaps = np.linalg.norm(_firsts(segments) - np.roll(ends, 1, axis=0), axis=1)
    if not segments.all_round or len(segments) == 1:
        gaps[0] = MAX_JUMP
    gaps = np.minimum(gaps, MAX_JUMP)
    return gaps, np.roll(gaps, -1)


def _boundary(segments: Segments) -> tuple[np.ndarray, np.ndarray]:
    """Length of the polyline (K,) [m] and standard deviation of its pieces (K,) [m]."""
    pieces, owners = _pieces(segments)
    lengths = np.linalg.norm(pieces, axis=1)
    total = np.bincount(owners, lengths, len(segments))
    mean = total / np.maximum(segments.sizes - 1, 1)
    squares = np.bincount(owners, (lengths - mean[owners]) ** 2, len(segments))
    return total, np.sqrt(squares / np.maximum(segments.sizes - 1, 1))


def _turns(segments: Segments) -> tuple[np.ndarray, np.ndarray]:
    """Mean curvature (K,) [1/m] and mean turn (K,) [rad] of the polyline.

    Curvature at a point: 4 A / (d_ab d_bc d_ac) of the triangle with its neighbours. Turn: left is
    positive, so that what bulges towards the scanner is negative.
    """
    pieces, owners = _pieces(segments)
    inner = owners[1:] == owners[:-1]
    before, after, owner = pieces[:-1][inner], pieces[1:][inner], owners[1:][inner]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turn = np.arctan2(cross, (before * after).sum(axis=1))
    sides = np.prod([np.linalg.norm(s, axis=1) for s in (before, after, before + after)], axis=0)
    curvature = np.divide(2.0 * np.abs(cross), sides, out=np.zeros_like(sides), where=sides > 1e-12)
    corners = np.maximum(segments.sizes - 2, 1)
    mean_curvature, mean_turn = (
        np.bincount(owner, values, len(segments)) / corners for values in (curvature, turn)
    )
    return mean_curvature, mean_turn


def _pieces(segments: Segments) -> tuple[np.ndarray, np.ndarray]:
    """Vectors (P, 2) [m] from point to point inside the segments, and the segment (P,) of each."""
    owners = segments.owners
    inside = owners[1:] == owners[:-1]
    return np.diff(segments.points, axis=0)[inside], owners[1:][inside]


def _mean_speed(segments: Segments, speeds: np.ndarray | None) -> np.ndarray:
    """Mean over the points (K,) [m/s] whose beam's speed is known; 0 where none is."""
    if speeds is None:
        return np.zeros(len(segments))
    of_points = speeds[segments.beams]
    known = np.isfinite(of_points)
    total = segments.sums(np.where(known, of_points, 0.0))
    return total / np.maximum(segments.sums(known.astype(float)), 1.0)
