"""How good a calibration is: residuals, what has been seen, what is weakly determined."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from safe_passage.calibration.arm_surface import VisibleSurface

AXES = ("turn about x", "turn about y", "turn about z", "shift in x", "shift in y", "shift in z")


@dataclass(frozen=True)
class Observability:
    """How well each direction of the pose is held by the surfaces seen (point to plane).

    A turn is about the arm's middle and counts by what it moves the arm's points.
    """

    eigenvalues: np.ndarray  # (6,) ascending, their sum is 1
    directions: np.ndarray  # (6, 6), a row each: turns about, shifts in the root's x, y, z

    @property
    def weakest(self) -> str:
        """The least determined direction in words."""
        return in_words(self.directions[0])


def in_words(row: np.ndarray) -> str:
    """A direction (6,) of the pose: turns about, shifts in x, y, z."""
    parts = [f"{row[i]:+.1f} {AXES[i]}" for i in np.argsort(-np.abs(row)) if abs(row[i]) > 0.3]
    return ", ".join(parts)


def observability(surfaces: list[VisibleSurface]) -> Observability:
    """Of what is seen of the arm in all its poses."""
    points = np.concatenate([one.points for one in surfaces])
    normals = np.concatenate([one.normals for one in surfaces])
    centred = points - points.mean(axis=0)
    size = np.sqrt((centred**2).sum(axis=1).mean())
    J = np.hstack([np.cross(centred, normals) / max(size, 1e-9), normals])
    values, vectors = np.linalg.eigh(J.T @ J / len(J))
    return Observability(values / values.sum(), vectors.T)


@dataclass(frozen=True)
class Residual:
    """Of one pose."""

    rms: float  # [m] of the sensor's points near the model to the model
    median: float  # [m] the same
    inliers: float  # share of the model's visible points that have been seen
    points: int  # of the sensor, near the model


def residual(sensor: np.ndarray, model: VisibleSurface, near: float, inlier: float) -> Residual:
    """Between a pose's sensor points (N, 3) and the model's visible surface, in one frame.

    Args:
        near: [m] from the model, within which a sensor's point is taken to be the arm's.
        inlier: [m] within which a model's point must have a sensor's to have been seen.
    """
    if not len(sensor) or not len(model.points):
        return Residual(np.nan, np.nan, 0.0, 0)
    distance = cKDTree(model.points).query(sensor, distance_upper_bound=near)[0]
    distance = distance[np.isfinite(distance)]
    seen = cKDTree(sensor).query(model.points, distance_upper_bound=inlier)[0]
    if not len(distance):
        return Residual(np.nan, np.nan, 0.0, 0)
    return Residual(
        float(np.sqrt((distance**2).mean())),
        float(np.median(distance)),
        float(np.isfinite(seen).mean()),
        len(distance),
    )
