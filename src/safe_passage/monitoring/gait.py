"""How people walk, as scanners at the height of ankles see it: they swing along their way.

The legs' centroid goes to and fro with each step, by 0.1 to 0.15 m, while the body moves evenly; to
the side it hardly strays. And who walks changes his pace less readily than his direction. So for
the body both the noise of what is measured and that of the model have an axis, the way. In paper
000, 4.3, they are the same in all directions; so they stay for finding what is seen again, because
legs are where they are. The body is what is told.
"""

from __future__ import annotations

import numpy as np

from safe_passage.monitoring.motion import process_noise, update
from safe_passage.monitoring.parameters import TrackerParameters
from safe_passage.monitoring.tracks import Tracks

WALKS = 0.3  # [m/s] slower, it is the less plain which way somebody walks
STRAY = 0.2  # [m] farther from where it is expected no step brings the legs: he turns, or stops,
STEP = 0.3  # [s] and has changed his pace for so long already


def agilities(tracks: Tracks, parameters: TrackerParameters) -> tuple[np.ndarray, np.ndarray]:
    """Spectral densities (N, 2, 2) [m^2/s^3] of the models' noise: of what is seen, of bodies."""
    p = parameters
    seen = np.where(tracks.moving, p.moving_agility, p.agility)[:, None, None] * np.eye(2)
    steadier = max(p.moving_agility - p.pace_agility, 0.0)
    return seen, seen - steadier * _along_way(tracks, p)


def follow(
    tracks: Tracks,
    known: np.ndarray,
    z: np.ndarray,
    R: np.ndarray,
    age: np.ndarray,
    parameters: TrackerParameters,
) -> tuple[np.ndarray, np.ndarray]:
    """States (N, 4) and covariances (N, 4, 4) of the bodies, once their legs have been seen.

    What does not walk is where it is seen.

    Args:
        tracks: their legs' states are those after having been seen, their bodies' those before.
        known: (M,) the tracks that were seen.
        z, R, age: as in `update`.
    """
    way = _along_way(tracks, parameters)
    body, P, axis = tracks.body.copy(), tracks.body_covariance.copy(), way[known]
    off = z - (body[known, :2] - age[:, None] * body[known, 2:])
    turns = (np.einsum("ni,nij,nj->n", off, axis, off) > STRAY**2)[:, None, None]
    P[known] += np.where(turns, process_noise(STEP, parameters.moving_agility * axis), 0.0)
    noise = R + np.where(turns, 0.0, parameters.stride_noise**2 * axis)
    body[known], P[known] = update(body[known], P[known], z, noise, age)
    walks = way.any(axis=(1, 2))
    return np.where(walks[:, None], body, tracks.x), np.where(walks[:, None, None], P, tracks.P)


def _along_way(tracks: Tracks, parameters: TrackerParameters) -> np.ndarray:
    """(N, 2, 2) u u^T of walkers' directions u, less of slow ones; 0 of all else."""
    speed = np.hypot(*tracks.velocity.T)
    walks = tracks.moving & (tracks.size <= parameters.alignment_size)
    certainty = np.where(walks, np.minimum(speed / WALKS, 1.0), 0.0)
    u = tracks.velocity / np.maximum(speed, 1e-9)[:, None]
    return certainty[:, None, None] * u[:, :, None] * u[:, None, :]
