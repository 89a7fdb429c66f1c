"""People as squares of cells, exactly known, around a robot of 1.2 m by 0.72 m."""

from __future__ import annotations

import math

import numpy as np
from safe_passage.separation import (
    Assessment,
    Obstacles,
    RobotState,
    SeparationMonitor,
    SeparationParameters,
)

LENGTH, WIDTH = 1.2, 0.72  # [m] of the robot
CELL = 0.1  # [m]
BODY = 0.1 + CELL * math.sqrt(0.5)  # [m] from a person's middle along x, discs around cells
PARAMETERS = {
    "footprint": ((0.6, 0.36), (-0.6, 0.36), (-0.6, -0.36), (0.6, -0.36)),
    "footprint_padding": 0.0,
    "agility": 0.0,
}


def parameters(**changes) -> SeparationParameters:
    return SeparationParameters(**{**PARAMETERS, **changes})


def people(*states, deviation=0.0, **flags) -> Obstacles:
    """Of (x, y, vx, vy) each; all move, unless `moving` or `person` say otherwise."""
    x = np.array(states, float).reshape(-1, 4)
    steps = np.array([-CELL, 0.0, CELL])
    body = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    everyone = np.ones(len(x), bool)
    return Obstacles(
        np.arange(1, len(x) + 1),
        x[:, :2],
        x[:, 2:],
        np.tile(deviation**2 * np.eye(4), (len(x), 1, 1)),
        everyone & flags.get("moving", True),
        everyone & flags.get("person", False),
        [at + body for at in x[:, :2]],
        CELL,
    )


def assess(obstacles, command=(1.0, 0.0, 0.0), twist=None, path=None, **changes) -> Assessment:
    """By a monitor that has just begun; the robot does what it is told, unless told otherwise."""
    monitor = SeparationMonitor(parameters(**changes))
    robot = RobotState(command if twist is None else twist, path)
    return monitor.assess(0.0, obstacles, robot, command)
