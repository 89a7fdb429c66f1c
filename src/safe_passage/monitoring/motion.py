"""Constant-velocity Kalman filters, all tracks at once (paper 000, 4.3).

State x = (px, py, vx, vy) in base, the velocity over ground; N tracks side by side.
"""

from __future__ import annotations

import math

import numpy as np
from filterpy.common import Q_continuous_white_noise

from safe_passage.core.geometry import Pose, rotation

Array = np.ndarray


def transition(dt: float) -> Array:
    """F (4, 4) of the linear motion model."""
    F = np.eye(4)
    F[0, 2] = F[1, 3] = dt
    return F


def process_noise(dt: float, agility: Array) -> Array:
    """Q (N, 4, 4) of white acceleration noise, spectral density `agility` (N, 2, 2) [m^2/s^3].

    Noise drawn anew each cycle, as in the paper, would make objects the less agile the higher the
    rate; this way their speed may change by sqrt(agility) in a second whatever dt.
    """
    one = Q_continuous_white_noise(2, dt)
    blocks = one[:, None, :, None] * agility[:, None, :, None, :]
    return blocks.reshape(-1, 4, 4)


def predict(x: Array, P: Array, dt: float, agility: Array) -> tuple[Array, Array]:
    """States (N, 4) and covariances (N, 4, 4), dt [s] later; agility (N, 2, 2) of each."""
    F = transition(dt)
    return x @ F.T, F @ P @ F.T + process_noise(dt, agility)


def move_frame(x: Array, P: Array, motion: Pose, drift: float) -> tuple[Array, Array]:
    """The same states seen after the robot has moved by `motion` (new base in the old).

    drift: error of the odometry, a share of way [m/m] and of turn [rad/rad].
    """
    R = rotation(-motion[2])
    turned = np.zeros((4, 4))
    turned[:2, :2] = turned[2:, 2:] = R
    moved = x.copy()
    moved[:, :2] -= motion[:2]
    moved = moved @ turned.T
    way, turn = drift * math.hypot(motion[0], motion[1]), drift * abs(motion[2])
    swing = np.zeros((len(x), 4))  # change of the state by a turn of 1 rad
    swing[:, 0], swing[:, 1] = -moved[:, 1], moved[:, 0]
    swing[:, 2], swing[:, 3] = -moved[:, 3], moved[:, 2]
    noise = turn**2 * swing[:, :, None] * swing[:, None, :]
    noise[:, [0, 1], [0, 1]] += way**2
    return moved, turned @ P @ turned.T + noise


def update(x: Array, P: Array, z: Array, R: Array, age: Array) -> tuple[Array, Array]:
    """States and covariances after measured positions.

    Args:
        z: (N, 2) [m]. R: (N, 2, 2) their covariances.
        age: (N,) [s] since they were measured: put-together scans show where an object was, so
            H = [I, -age I]. The paper leaves that lag in the estimate.
    """
    H = np.zeros((len(x), 2, 4))
    H[:, [0, 1], [0, 1]] = 1.0
    H[:, 0, 2] = H[:, 1, 3] = -age
    PHt = P @ H.transpose(0, 2, 1)
    S = H @ PHt + R
    K = PHt @ np.linalg.inv(S)
    residual = z - np.einsum("nij,nj->ni", H, x)
    better = x + np.einsum("nij,nj->ni", K, residual)
    I_KH = np.eye(4) - K @ H
    covariance = I_KH @ P @ I_KH.transpose(0, 2, 1) + K @ R @ K.transpose(0, 2, 1)
    return better, covariance


def squared_mahalanobis(offset: Array, covariance: Array) -> Array:
    """(N,) of `offset` (N, 2) under `covariance` (N, 2, 2)."""
    a, b, d = covariance[:, 0, 0], covariance[:, 0, 1], covariance[:, 1, 1]
    x, y = offset[:, 0], offset[:, 1]
    return (d * x * x - 2.0 * b * x * y + a * y * y) / np.maximum(a * d - b * b, 1e-12)
