"""Distances from a point along rays to simple solids, exactly. Metres; NaN-free: a miss is inf."""

from __future__ import annotations

import numpy as np

Array = np.ndarray


def plane_z(origin: Array, directions: Array, z: float) -> Array:
    """Distance (N,) along unit `directions` (N, 3) from `origin` (3,) to the plane z = `z`."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        distance = (z - origin[2]) / directions[:, 2]
    return np.where(distance > 0.0, distance, np.inf)


def box(origin: Array, directions: Array, low: Array, high: Array) -> Array:
    """Distance (N,) to an axis-aligned box, by slabs; inf where it is missed."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        to_low = (low - origin) / directions
        to_high = (high - origin) / directions
    near = np.nanmax(np.minimum(to_low, to_high), axis=1)
    far = np.nanmin(np.maximum(to_low, to_high), axis=1)
    return np.where((near <= far) & (near > 0.0), near, np.inf)


def sphere(origin: Array, directions: Array, centre: Array, radius: float) -> Array:
    """Distance (N,) to a sphere; inf where it is missed."""
    offset = origin - centre
    half_b = directions @ offset
    discriminant = half_b**2 - (offset @ offset - radius**2)
    distance = -half_b - np.sqrt(np.maximum(discriminant, 0.0))
    return np.where((discriminant >= 0.0) & (distance > 0.0), distance, np.inf)


def capsule(origin: Array, directions: Array, a: Array, b: Array, radius: float) -> Array:
    """Distance (N,) to all points within `radius` of the segment from `a` to `b`."""
    axis, offset = b - a, origin - a
    length2 = axis @ axis
    axis_d, axis_o = directions @ axis, axis @ offset
    # |offset + t d - axis * s|^2 = radius^2 with s the foot on the axis: a quadratic in t
    qa = length2 - axis_d**2
    qb = length2 * (directions @ offset) - axis_o * axis_d
    qc = length2 * (offset @ offset - radius**2) - axis_o**2
    discriminant = qb**2 - qa * qc
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        distance = (-qb - np.sqrt(np.maximum(discriminant, 0.0))) / qa
    foot = axis_o + distance * axis_d
    side = (discriminant >= 0.0) & (distance > 0.0) & (foot >= 0.0) & (foot <= length2)
    ends = np.minimum(sphere(origin, directions, a, radius), sphere(origin, directions, b, radius))
    return np.minimum(np.where(side, distance, np.inf), ends)


def rectangle(
    origin: Array, directions: Array, corner: Array, along: Array, across: Array
) -> Array:
    """Distance (N,) to the parallelogram at `corner` with the sides `along`, `across` (3,)."""
    normal = np.cross(along, across)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        distance = ((corner - origin) @ normal) / (directions @ normal)
        from_corner = origin - corner + distance[:, None] * directions
        u = from_corner @ np.cross(across, normal) / (along @ np.cross(across, normal))
        v = from_corner @ np.cross(along, normal) / (across @ np.cross(along, normal))
        inside = (u >= 0.0) & (u <= 1.0) & (v >= 0.0) & (v <= 1.0)
    return np.where(inside & (distance > 0.0), distance, np.inf)
