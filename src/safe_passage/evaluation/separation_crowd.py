"""Many tracks around a robot that drives: what a cycle of the separation monitor costs."""

from __future__ import annotations

import math
import time

import numpy as np

from safe_passage.separation import (
    Obstacles,
    RobotState,
    SeparationMonitor,
    SeparationParameters,
)

RADIUS = 12.0  # [m] half the side of the tracker's grid
CLEAR = 0.9  # [m] around the robot's origin
PERIOD = 0.04  # [s] of a cycle
COMMAND = (0.8, 0.0, 0.1)  # [m/s, m/s, rad/s]
CELL = 0.12  # [m]
CELLS = 14  # of an obstacle
DEVIATION = 0.1, 0.3  # of places [m] and velocities [m/s]


def crowd(count: int, moving: float, rng: np.random.Generator) -> Obstacles:
    """Persons all around who walk anywhere; `moving`: share of them, the others never have."""
    radius = np.sqrt(rng.uniform((CLEAR / RADIUS) ** 2, 1.0, count)) * RADIUS
    bearing = rng.uniform(-math.pi, math.pi, count)
    position = radius[:, None] * np.stack([np.cos(bearing), np.sin(bearing)], axis=1)
    heading, speed = rng.uniform(-math.pi, math.pi, count), rng.uniform(0.3, 2.0, count)
    moves = rng.random(count) < moving
    velocity = (moves * speed)[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=1)
    variance = np.repeat(np.square(DEVIATION), 2)
    shapes = np.floor(rng.normal(0.0, 0.15, (count, CELLS, 2)) / CELL) * CELL
    return Obstacles(
        np.arange(1, count + 1), position, velocity,
        np.broadcast_to(np.diag(variance), (count, 4, 4)), moves, np.zeros(count, bool),
        list(position[:, None] + shapes), CELL,
    )  # fmt: skip


def cycle_times(
    count: int, moving: float, cycles: int, parameters: SeparationParameters, seed: int
) -> np.ndarray:
    """[ms] of each cycle after some to warm up: everybody is assessed, the command limited."""
    rng, monitor, taken = np.random.default_rng(seed), SeparationMonitor(parameters), []
    robot = RobotState(COMMAND)
    for cycle in range(cycles + 20):
        obstacles = crowd(count, moving, rng)
        began = time.perf_counter()
        monitor.assess(cycle * PERIOD, obstacles, robot, COMMAND)
        monitor.limit(COMMAND)
        taken.append(1e3 * (time.perf_counter() - began))
    return np.array(taken[20:])
