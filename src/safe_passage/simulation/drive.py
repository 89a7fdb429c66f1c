"""The base: follows velocity commands as far as it can, and keeps its odometry, which drifts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from safe_passage.core.geometry import Pose, compose
from safe_passage.simulation.robots import DriveModel


@dataclass(frozen=True)
class Twist:
    """Velocity of base_footprint in its own frame."""

    forward: float = 0.0  # [m/s]
    left: float = 0.0  # [m/s], 0 unless the drive is omni-directional
    turn: float = 0.0  # [rad/s]


class Base:
    """Pose, twist and odometry of a robot without inertia but with limited acceleration.

    Args:
        model: of the drive.
        pose: where it starts, frame map; odometry starts at (0, 0, 0).
        rng: of the odometry's errors.
    """

    def __init__(self, model: DriveModel, pose: Pose, rng: np.random.Generator) -> None:
        self.model, self.pose = model, pose
        self.twist = Twist()
        self.odometry: Pose = (0.0, 0.0, 0.0)
        self.drift = 0.0  # share by which odometry overrates the way, besides the model's: a fault
        self.bumped = False  # the last step ended at an obstacle
        self._rng = rng
        self._command, self._commanded = Twist(), -math.inf

    def command(self, twist: Twist, time: float) -> None:
        """Want `twist` from `time` [s] on; anything that is not finite means: stop."""
        finite = all(map(math.isfinite, (twist.forward, twist.left, twist.turn)))
        self._command, self._commanded = twist if finite else Twist(), time

    def next(self, time: float, step: float) -> tuple[Pose, Twist]:
        """Pose and twist after `step` [s] from `time` on, if nothing is in the way."""
        fresh = time - self._commanded <= self.model.command_timeout
        twist = self._towards(self._command if fresh else Twist(), step)
        return moved(self.pose, twist, step), twist

    def accept(self, pose: Pose, twist: Twist, step: float) -> None:
        """It went there."""
        self.pose, self.twist, self.bumped = pose, twist, False
        self.odometry = moved(self.odometry, self._mismeasured(twist, step), step)

    def refuse(self) -> None:
        """An obstacle is in the way: it stands, where it was."""
        self.twist, self.bumped = Twist(), True

    def _towards(self, wanted: Twist, step: float) -> Twist:
        m, now = self.model, self.twist
        velocity = np.array([wanted.forward, wanted.left if m.omni else 0.0])
        speed = np.hypot(*velocity)
        if speed > m.max_speed:
            velocity *= m.max_speed / speed
        change = velocity - (now.forward, now.left)
        most = m.acceleration * step
        if np.hypot(*change) > most:
            change *= most / np.hypot(*change)
        turn = float(np.clip(wanted.turn, -m.max_turn_rate, m.max_turn_rate))
        turning = float(
            np.clip(turn - now.turn, -m.turn_acceleration * step, m.turn_acceleration * step)
        )
        return Twist(
            now.forward + float(change[0]), now.left + float(change[1]), now.turn + turning
        )

    def _mismeasured(self, twist: Twist, step: float) -> Twist:
        """Errors that add up to odometry_noise * way over a second, whatever the step."""
        sigma = self.model.odometry_noise / math.sqrt(step)
        factors = (
            1.0 + self.model.odometry_scale + self.drift + sigma * self._rng.standard_normal(3)
        )
        return Twist(twist.forward * factors[0], twist.left * factors[1], twist.turn * factors[2])


def moved(pose: Pose, twist: Twist, step: float) -> Pose:
    """`pose` after `step` [s] of a constant twist: an arc, exactly."""
    turned = twist.turn * step
    if abs(turned) < 1e-9:
        along, across = twist.forward * step, twist.left * step
    else:
        s, c = math.sin(turned) / twist.turn, (1.0 - math.cos(turned)) / twist.turn
        along = twist.forward * s - twist.left * c
        across = twist.forward * c + twist.left * s
    return compose(pose, (along, across, turned))
