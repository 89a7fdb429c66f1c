"""Where the obstacles will be, and how far they then reach (paper 000, 5). Frame: base, now."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Sequence

import numpy as np

from safe_passage.core.geometry import Pose, rotation
from safe_passage.separation.parameters import SeparationParameters

SPARSE = 3  # steps between two moments beyond the horizon
STANDS = 0.1  # [m/s] slower is standing; carried on for seconds, noise would come near
STRIDE = 0.6  # [m] from its place a moving thing that reaches farther is no walker
MOST_CELLS = 32  # of an obstacle; a larger one is looked at in larger cells


@dataclass(frozen=True)
class Obstacles:
    """N tracked obstacles at one time, frame base."""

    id: np.ndarray  # (N,) int
    position: np.ndarray  # (N, 2) [m]
    velocity: np.ndarray  # (N, 2) [m/s] over ground
    covariance: np.ndarray  # (N, 4, 4) of (x, y, vx, vy) [m, m/s]
    moving: np.ndarray  # (N,) bool
    person: np.ndarray  # (N,) bool
    cells: Sequence[np.ndarray]  # N of (M, 2) [m], M > 0, centres of squares
    resolution: float  # [m] side of a square

    def __len__(self) -> int:
        return len(self.id)

    def keep(self, which: np.ndarray) -> Obstacles:
        """Those of the mask `which` (N,)."""
        names = ("id", "position", "velocity", "covariance", "moving", "person")
        arrays = {name: getattr(self, name)[which] for name in names}
        return replace(self, **arrays, cells=[self.cells[i] for i in np.flatnonzero(which)])


def no_obstacles(resolution: float = 0.1) -> Obstacles:
    """Looked, and nobody is there."""
    none = np.empty(0)
    flags = none > 0
    flat, square = np.empty((0, 2)), np.empty((0, 4, 4))
    return Obstacles(none.astype(int), flat, flat, square, flags, flags, [], resolution)


def carried_on(
    obstacles: Obstacles, age: float, motion: Pose, p: SeparationParameters
) -> Obstacles:
    """The same obstacles `age` [s] later, seen from where base is then.

    motion: of the robot in the meantime, the later base in the former.
    """
    R = rotation(-motion[2])
    F, turned = np.eye(4), np.kron(np.eye(2), R)
    F[:2, 2:] = age * np.eye(2)
    P = turned @ F @ obstacles.covariance @ F.T @ turned.T
    P[:, [0, 1], [0, 1]] += p.agility * age**3 / 3.0
    P[:, [2, 3], [2, 3]] += p.agility * age
    P[:, [0, 1, 2, 3], [2, 3, 0, 1]] += p.agility * age**2 / 2.0
    way = age * obstacles.velocity
    return replace(
        obstacles,
        position=(obstacles.position + way - motion[:2]) @ R.T,
        velocity=obstacles.velocity @ R.T,
        covariance=P,
        cells=[(own + step - motion[:2]) @ R.T for own, step in zip(obstacles.cells, way)],
    )


@dataclass(frozen=True)
class Prediction:
    """N obstacles at T times. A shape is discs, which all move along."""

    id: np.ndarray  # (N,)
    times: np.ndarray  # (T,) [s] from now, the first is 0; beyond the horizon only for stops
    centre: np.ndarray  # (N, 2) [m] now
    velocity: np.ndarray  # (N, 2) [m/s]; 0 where it is not known, or next to nothing
    growth: np.ndarray  # (N, T) [m] by which the shape is enlarged
    unknown: np.ndarray  # (N,) bool: may come from anywhere, so it grows at human speed
    discs: np.ndarray  # (M, 3) [m] place from the centre and radius, one obstacle behind the other
    start: np.ndarray  # (N + 1,) where each obstacle's discs begin
    radius: np.ndarray  # (N,) [m] of the circle about the centre that holds the shape

    def __len__(self) -> int:
        return len(self.id)


def predict(obstacles: Obstacles, p: SeparationParameters) -> Prediction:
    """Constant velocity over the horizon, for those that count."""
    counts = obstacles.moving | obstacles.person | p.stationary_obstacles
    chosen = obstacles.keep(counts) if not np.all(counts) else obstacles
    times = _times(p)
    P = chosen.covariance
    spread = np.sqrt(_largest_variance(P[:, None, 2:, 2:]))[:, 0]
    unknown = (spread > p.max_speed_deviation) | p.worst_case
    growth = np.minimum(p.sigmas * position_deviation(P, times, p.agility), p.max_growth)
    growth[unknown] += p.human_speed * times
    stands = unknown | (np.hypot(*chosen.velocity.T) < STANDS)
    velocity = np.where(stands[:, None], 0.0, chosen.velocity)
    around = [cells - place for cells, place in zip(chosen.cells, chosen.position)]
    body = max(p.body_radius - chosen.resolution * math.sqrt(0.5), 0.0)
    bodies = [_body(own, body) if walks else own for own, walks in zip(around, chosen.moving)]
    shapes = [_discs(own, chosen.resolution) for own in bodies]
    lengths = [len(points) for points, _ in shapes]
    start = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
    points = np.concatenate([points for points, _ in shapes]) if shapes else np.empty((0, 2))
    radii = np.repeat([radius for _, radius in shapes], lengths)
    discs = np.column_stack([points, radii])
    reach = np.hypot(points[:, 0], points[:, 1]) + radii
    radius = np.maximum.reduceat(reach, start[:-1]) if shapes else np.empty(0)
    at = chosen.position
    return Prediction(chosen.id, times, at, velocity, growth, unknown, discs, start, radius)


def _times(p: SeparationParameters) -> np.ndarray:
    """(T,) [s] every `step` up to the horizon, then every so many, up to the stops' horizon."""
    near = np.arange(0.0, p.horizon + 0.5 * p.step, p.step)
    count = round((p.stop_horizon - near[-1]) / (SPARSE * p.step))
    return np.concatenate([near, near[-1] + SPARSE * p.step * np.arange(1, count + 1)])


def position_deviation(P: np.ndarray, times: np.ndarray, agility: float) -> np.ndarray:
    """(N, T) [m] largest standard deviation of positions with covariances `P` (N, 4, 4) later on.

    White acceleration noise of spectral density `agility` [m^2/s^3], as in the tracker's filter.
    """
    t = times[:, None, None]
    cross = P[:, None, :2, 2:] + P[:, None, 2:, :2]
    noise = agility * t**3 / 3.0 * np.eye(2)
    later = P[:, None, :2, :2] + t * cross + t**2 * P[:, None, 2:, 2:] + noise
    return np.sqrt(_largest_variance(later))


def _largest_variance(S: np.ndarray) -> np.ndarray:
    """(...) larger eigenvalue of symmetric `S` (..., 2, 2)."""
    mean = 0.5 * (S[..., 0, 0] + S[..., 1, 1])
    half = np.hypot(0.5 * (S[..., 0, 0] - S[..., 1, 1]), 0.5 * (S[..., 0, 1] + S[..., 1, 0]))
    return np.maximum(mean + half, 0.0)


def _body(cells: np.ndarray, radius: float) -> np.ndarray:
    """`cells` (N, 2) [m] around a place, of a walker no farther from it than `radius` [m].

    Scanners see feet, which swing half a step before and behind the body.
    """
    away = np.hypot(cells[:, 0], cells[:, 1])
    if away.max() > STRIDE:
        return cells
    return cells * np.minimum(1.0, radius / np.maximum(away, 1e-9))[:, None]


def _discs(cells: np.ndarray, side: float) -> tuple[np.ndarray, float]:
    """Middles (M, 2) [m] and radius [m] of discs that cover the square `cells` (N, 2)."""
    if len(cells) <= MOST_CELLS:
        return cells, side * math.sqrt(0.5)
    coarse, squares = side, cells
    while len(squares) > MOST_CELLS:
        coarse *= 2.0
        rows, columns = np.floor(cells / coarse).astype(np.int64).T
        _, first = np.unique(rows * 2**24 + columns, return_index=True)
        squares = np.stack([rows[first], columns[first]], axis=1)
    # a cell whose middle is in the larger square sticks out by half its side
    return coarse * (squares + 0.5), (coarse + side) * math.sqrt(0.5)
