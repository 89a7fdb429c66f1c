"""The separation monitor: tracked obstacles and the robot's motion -> how fast it may go."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

import numpy as np

from safe_passage.separation.distances import Nearest, make_table, nearest_along
from safe_passage.separation.failsafe import Reason
from safe_passage.separation.limiter import Allowed, Courses, Release, largest_scale
from safe_passage.separation.parameters import SeparationParameters
from safe_passage.separation.prediction import Obstacles, Prediction, predict
from safe_passage.separation.robot_motion import (
    Motion,
    RobotState,
    Shape,
    Velocity,
    make_shape,
    plan_motion,
)
from safe_passage.separation.zones import protective_distance, stopping_time, towards

STAND: Velocity = (0.0, 0.0, 0.0)
FASTEST = 2.0  # of its command the robot is believed to do at most


class Level(enum.IntEnum):
    """As in SeparationState.msg."""

    FREE = 0
    SLOW = 1
    STOP = 2


@dataclass(frozen=True)
class Assessment:
    """How things stand between the robot and everybody. NaN: not known."""

    stamp: float  # [s]
    level: Level
    reason: Reason
    scale: float  # [0, 1] of the command that is allowed
    time_to_collision: float = math.nan  # [s] until predicted shapes touch; inf: they do not
    present_distance: float = math.nan  # [m] least, now; inf: nobody is there
    predicted_distance: float = math.nan  # [m] least, over the horizon, at the full command
    required_distance: float = math.nan  # [m] S_p of the obstacle that decides; 0: there is none
    obstacle_id: int = 0  # that obstacle, 0: none
    on_path: bool = False  # the robot was taken to follow its path, not the arc of its command


@dataclass(frozen=True)
class Outlook:
    """What an assessment was made of, to be drawn. Frame: base."""

    prediction: Prediction
    motion: Motion
    shape: Shape


class SeparationMonitor:
    """Limits a robot's commands so that it keeps away from where people will be."""

    def __init__(self, parameters: SeparationParameters) -> None:
        self._p = parameters
        self._release = Release(parameters)
        self._robot = RobotState()
        self._command: Velocity | None = None
        self._shape = make_shape(parameters)
        self.outlook: Outlook | None = None
        self._assessment = Assessment(0.0, Level.FREE, Reason.OK, 1.0)

    def tune(self, parameters: SeparationParameters) -> None:
        """Other parameters from the next assessment on; the release goes on where it is."""
        self._p = parameters
        self._release.tune(parameters)

    def assess(
        self, stamp: float, obstacles: Obstacles, robot: RobotState, command: Velocity | None = None
    ) -> Assessment:
        """How things stand, and what of `command` is allowed.

        Args:
            stamp: [s] now.
            obstacles: now, frame base.
            robot: now.
            command: what it is told to do; None: to go on as it does.
        """
        command = robot.twist if command is None else command
        if not all(math.isfinite(part) for part in command):
            return self.refuse(stamp, Reason.BAD_COMMAND)
        self._robot, self._command = robot, command
        self._shape = make_shape(self._p, robot.parts)
        return self._judge(stamp, predict(obstacles, self._p))

    def limit(self, command: Velocity) -> tuple[Velocity, Assessment]:
        """The command as far as the last assessment's obstacles allow it; its direction is kept.

        It is judged by its own motion: one that leads away from them passes.
        """
        if not all(math.isfinite(part) for part in command):
            return STAND, self.refuse(self._assessment.stamp, Reason.BAD_COMMAND)
        if self._assessment.reason > Reason.ESCAPE or self.outlook is None:
            return STAND, self._assessment
        if command != self._command:
            self._command = command
            self._judge(self._assessment.stamp, self.outlook.prediction)
        scale = self._assessment.scale
        limited = command[0] * scale, command[1] * scale, command[2] * scale
        return limited, self._assessment

    def refuse(self, stamp: float, reason: Reason) -> Assessment:
        """Stop for another reason than obstacles."""
        self._release.stop(stamp)
        self.outlook, self._command = None, None
        self._assessment = Assessment(stamp, Level.STOP, reason, 0.0)
        return self._assessment

    def _judge(self, stamp: float, prediction: Prediction) -> Assessment:
        p, robot, command = self._p, self._robot, self._command or STAND
        now = _share(robot.twist, command, self._shape.reach)
        motion = plan_motion(command, robot.path, max(1.0, now) * p.horizon, p)
        courses = Courses(motion, now, prediction.times, p)
        ahead = prediction.times[prediction.times <= p.horizon + 0.5 * p.step]
        nearest = nearest_along(prediction, motion.at(ahead), self._shape)
        enough = p.kept + p.release_margin + p.tolerance
        table = make_table(prediction, motion, self._shape, courses.reach, enough)
        allowed = largest_scale(table, courses, prediction.times, motion, self._release.hurries, p)
        scale = self._release.update(stamp, _weighed(command, self._shape.reach), allowed)
        self.outlook = Outlook(prediction, motion, self._shape)
        self._assessment = Assessment(
            stamp,
            _level(scale),
            _reason(scale, allowed),
            scale,
            nearest.time_to_collision,
            nearest.least_present,
            nearest.least_predicted,
            self._required(nearest, prediction, motion),
            int(prediction.id[nearest.deciding]) if nearest.deciding >= 0 else 0,
            motion.on_path,
        )
        return self._assessment

    def _required(self, nearest: Nearest, prediction: Prediction, motion: Motion) -> float:
        """[m] S_p towards the obstacle that decides."""
        i, p = nearest.deciding, self._p
        if i < 0:
            return 0.0
        apart = prediction.centre[i]
        human = p.human_speed if prediction.unknown[i] else towards(prediction.velocity[i], -apart)
        first = motion.at(np.array([0.0, p.step]))[:, :2]
        heading = np.diff(first, axis=0)[0] / p.step
        braking = stopping_time(motion.speed, motion.turn, p)
        at = np.searchsorted(prediction.times, p.reaction_time + braking)
        known = min(int(at), len(prediction.times) - 1)
        come = p.human_speed * prediction.times[known] if prediction.unknown[i] else 0.0
        growth = float(prediction.growth[i, known]) - come
        return protective_distance(human, towards(heading, apart), braking, growth, p)


def _level(scale: float) -> Level:
    if scale <= 0.0:
        return Level.STOP
    return Level.SLOW if scale < 1.0 else Level.FREE


def _reason(scale: float, allowed: Allowed) -> Reason:
    if allowed.inside and scale > 0.0:
        return Reason.ESCAPE
    return Reason.OBSTACLE if scale < 1.0 else Reason.OK


def _weighed(command: Velocity, reach: float) -> np.ndarray:
    """(3,) [m/s], the turn as what it moves the robot's farthest point by."""
    return np.array([command[0], command[1], reach * command[2]])


def _share(twist: Velocity, command: Velocity, reach: float) -> float:
    """What part of the command the robot does already, in [0, FASTEST]."""
    told, does = _weighed(command, reach), _weighed(twist, reach)
    size = float(told @ told)
    return min(max(float(told @ does) / size, 0.0), FASTEST) if size > 1e-9 else 0.0
