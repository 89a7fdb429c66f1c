"""How far off a result may be, by how much the arm's poses disagree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np
from scipy.spatial import cKDTree

from safe_passage.calibration.arm_surface import VisibleSurface
from safe_passage.calibration.quality import in_words

LEAST_POSES = 3  # of which a spread can come
SINGULAR = 1e-9  # of the largest eigenvalue, under which a direction is not held at all


@dataclass(frozen=True)
class Uncertainty:
    """Standard deviations of the camera's pose; inf: nothing holds it."""

    translation: float  # [m] of its place
    rotation: float  # [rad]
    direction: str = ""  # the least certain one in words: turns about the camera, shifts

    def __str__(self) -> str:
        return f"{1e3 * self.translation:.1f} mm, {np.degrees(self.rotation):.2f} degrees"

    def exceeds(self, allowed: Uncertainty) -> bool:
        """Whether place or rotation may be farther off."""
        return self.translation > allowed.translation or self.rotation > allowed.rotation


@dataclass(frozen=True)
class Offsets:
    """Of the sensor's points in one pose."""

    points: np.ndarray  # (N, 3) [m]
    normals: np.ndarray  # (N, 3) of the model's surface nearest to them
    distances: np.ndarray  # (N,) [m] out of that surface


def offsets(sensor: np.ndarray, model: VisibleSurface, near: float) -> Offsets:
    """Between sensor points (N, 3) and what is seen of the model within `near` [m] of them."""
    if not len(sensor) or not len(model.points):
        return Offsets(np.empty((0, 3)), np.empty((0, 3)), np.empty(0))
    found, nearest = cKDTree(model.points).query(sensor, distance_upper_bound=near)
    points, nearest = sensor[np.isfinite(found)], nearest[np.isfinite(found)]
    normals = model.normals[nearest]
    along = np.einsum("ij,ij->i", points - model.points[nearest], normals)
    return Offsets(points, normals, along)


def uncertainty(poses: Sequence[Offsets], place: np.ndarray) -> Uncertainty | None:
    """Of a camera for which the sum of the squared distances has its minimum, or nearly.

    Neighbours err alike (edges, steps of the depth, the mesh), so that many points are not many
    times as sure. But one pose of the arm errs as independently of another as can be: the
    covariance of Liang and Zeger (Biometrika 1986) for clustered data, from what each pose pulls
    elsewhere than all do together. None: of fewer than three poses nothing can be said.

    Args:
        place: (3,) [m] of the camera.
    """
    pulls, H, reach = [], np.zeros((6, 6)), []
    for one in poses:
        if not len(one.points):
            continue
        arms = one.points - place
        J = np.hstack([np.cross(arms, one.normals), one.normals])
        H += J.T @ J
        reach.append(np.linalg.norm(arms, axis=1).mean())
        pulls.append(J.T @ one.distances)
    if len(pulls) < LEAST_POSES:
        return None
    values = np.linalg.eigvalsh(H)
    if values[0] < SINGULAR * values[-1]:
        return Uncertainty(np.inf, np.inf)
    G, inverse = np.array(pulls) - np.mean(pulls, axis=0), np.linalg.inv(H)
    covariance = inverse @ (G.T @ G) @ inverse * len(G) / (len(G) - 1)
    scale = np.repeat([np.mean(reach), 1.0], 3)  # turns count by what they move
    vectors = np.linalg.eigh(covariance * np.outer(scale, scale))[1]
    return Uncertainty(
        float(np.sqrt(np.trace(covariance[3:, 3:]))),
        float(np.sqrt(np.trace(covariance[:3, :3]))),
        in_words(vectors[:, -1]),
    )
