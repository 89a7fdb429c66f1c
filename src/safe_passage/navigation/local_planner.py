"""Velocity choice: dynamic window (Fox, Burgard, Thrun 1997) on a navigation function."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable

import numpy as np

from safe_passage.core.geometry import outline, placed
from safe_passage.navigation.parameters import NavigatorParameters

PERIOD = 0.2  # [s] within which a new velocity is reached
STEP = 0.1  # [s] between the poses of a trajectory
SPEEDS, TURNS = 9, 17  # samples
LOOK_AHEAD = 0.5  # [m] before the robot, where the heading is judged
ROOM_SPEED = 0.15  # [m/s]
ROOM, ROOM_COST = 0.1, 1.0  # [m] of room that it likes to have; cost [m] of not having it
GRAZE = 6  # points of the outline that may touch more on the way to more room
LEAST_GAIN = 0.02  # [m] of cost that moving must bring

IsFree = Callable[[np.ndarray], np.ndarray]  # points (..., 2) of the robot's frame now -> bool
Cost = Callable[[np.ndarray], np.ndarray]  # the same points -> cost [m] to the goal


@dataclass(frozen=True)
class Velocity:
    """What to drive."""

    forward: float = 0.0  # [m/s]
    turn: float = 0.0  # [rad/s]


class LocalPlanner:
    """Chooses among arcs that are free for the horizon the one that ends cheapest."""

    def __init__(self, parameters: NavigatorParameters) -> None:
        self._p = parameters
        self._outline = _grown(parameters, parameters.footprint_padding)
        self._roomy = _grown(parameters, parameters.footprint_padding + ROOM)
        shares = np.array([0.0, 0.25, 0.5, 0.75, 1.0])[:, None, None]
        self._filled = (shares * self._outline).reshape(-1, 2)
        self._depths = np.repeat(1.0 + 20.0 * (1.0 - shares.ravel()), len(self._outline))
        self._rings = [_grown(parameters, margin) for margin in (0.05, 0.1, 0.2, 0.3)]  # [m]

    def choose(self, now: Velocity, is_free: IsFree, cost: Cost) -> Velocity | None:
        """The best velocity; None when nothing that is free comes nearer to the goal.

        now: what the robot drives; is_free, cost: at points of the robot's frame as it is now.
        """
        forward, turn = self._window(now)
        poses = trajectories(forward, turn, self._p.horizon)
        free = is_free(placed(self._outline, poses)).all(axis=(1, 2))
        ends = poses[:, -1]
        here = float(cost(np.zeros((1, 2)))[0])
        look = min(LOOK_AHEAD, 0.5 * here)  # not beyond the goal
        ahead = ends[:, :2] + look * np.stack([np.cos(ends[:, 2]), np.sin(ends[:, 2])], axis=1)
        value = 0.5 * (cost(ends[:, :2]) + cost(ahead))
        near = (~is_free(placed(self._roomy, poses))).any(axis=2).mean(axis=1)
        value += ROOM_COST * near
        value[~free] = np.inf
        best = int(np.argmin(value))
        standing = 0.5 * (here + float(cost(np.array([[look, 0.0]]))[0]))
        if not value[best] < standing - LEAST_GAIN:
            return None
        return Velocity(float(forward[best]), float(turn[best]))

    def make_room(self, is_free: IsFree) -> Velocity | None:
        """Slowly to where there is more room, when no way on is free; None: boxed in.

        The outline may already touch something: then it must not touch more of it in the end.
        """
        forward = np.repeat([-ROOM_SPEED, ROOM_SPEED], 5)
        turn = np.tile(np.linspace(-0.4, 0.4, 5), 2)
        poses = trajectories(forward, turn, 1.5)
        touched = (~is_free(placed(self._filled, poses))) @ self._depths
        now = float((~is_free(self._filled)) @ self._depths)
        allowed = (touched <= now + GRAZE).all(axis=1) & (touched[:, -1] <= now)
        if not allowed.any():
            return None
        crowded = sum(
            (~is_free(placed(grown, poses[:, -1:]))).sum(axis=(1, 2)) for grown in self._rings
        )
        best = int(np.argmin(np.where(allowed, crowded + 0.1 * np.abs(turn), np.inf)))
        return Velocity(float(forward[best]), float(turn[best]))

    def can_turn(self, turn: float, is_free: IsFree) -> bool:
        """Whether turning on the spot at `turn` [rad/s] is free for a while."""
        poses = trajectories(np.zeros(1), np.array([turn]), 0.5)
        return bool(is_free(placed(self._outline, poses)).all())

    def free_way(self, forward: float, turn: float, time: float, is_free: IsFree) -> bool:
        """Whether an arc is free for `time` [s]."""
        poses = trajectories(np.array([forward]), np.array([turn]), time)
        return bool(is_free(placed(self._outline, poses)).all())

    def _window(self, now: Velocity) -> tuple[np.ndarray, np.ndarray]:
        p = self._p
        change, turning = p.acceleration * PERIOD, p.turn_acceleration * PERIOD
        speeds = np.linspace(
            max(0.0, now.forward - change), min(p.max_speed, now.forward + change), SPEEDS
        )
        turns = np.linspace(
            max(-p.max_turn_rate, now.turn - turning),
            min(p.max_turn_rate, now.turn + turning),
            TURNS,
        )
        forward, turn = np.meshgrid(speeds, np.append(turns, 0.0), indexing="ij")
        return forward.ravel(), turn.ravel()


def _grown(parameters: NavigatorParameters, margin: float) -> np.ndarray:
    """Points of the footprint's outline, `margin` [m] out of it."""
    corners = np.array(parameters.footprint)
    grown = corners + margin * np.sign(corners)
    return outline(grown, spacing=0.04)  # finer than a cell: no corner slips between


def trajectories(forward: np.ndarray, turn: np.ndarray, time: float) -> np.ndarray:
    """Poses (N, K, 3) along arcs of constant velocities (N,), frame of the robot at their start."""
    times = STEP * np.arange(1, math.ceil(time / STEP) + 1)
    angles = turn[:, None] * times
    halves = 0.5 * angles
    chords = forward[:, None] * times * np.sinc(halves / np.pi)
    return np.stack([chords * np.cos(halves), chords * np.sin(halves), angles], axis=-1)
