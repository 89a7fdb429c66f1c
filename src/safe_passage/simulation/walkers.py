"""Where each person is at any time, and in which pose of its walk."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from safe_passage.simulation.worlds import PersonPlan


@dataclass(frozen=True)
class PersonState:
    """A person at one moment, frame map."""

    x: float  # [m] the floor under its middle
    y: float  # [m]
    yaw: float  # [rad] the way it faces
    velocity: tuple[float, float]  # [m/s]
    walked: float  # [m] since time 0: the pose of the legs follows from it

    @property
    def stands(self) -> bool:
        return self.velocity == (0.0, 0.0)


class Walker:
    """To and fro along a plan's way-points, with a pause at each end; a function of time alone."""

    def __init__(self, plan: PersonPlan) -> None:
        self.plan = plan
        points = np.array(plan.waypoints)
        new = np.append(True, (np.diff(points, axis=0) != 0.0).any(axis=1))
        self._points = points[new]  # a place named twice in a row is one
        legs = np.diff(self._points, axis=0)
        self._lengths = np.hypot(legs[:, 0], legs[:, 1])
        self._way = float(self._lengths.sum())
        self._ends = np.concatenate([[0.0], np.cumsum(self._lengths)])

    def at(self, time: float) -> PersonState:
        """State at `time` [s]."""
        if self._way == 0.0:
            x, y = self._points[0]
            return PersonState(float(x), float(y), self.plan.yaw, (0.0, 0.0), 0.0)
        walking = self._way / self.plan.speed
        lap = walking + self.plan.pause  # one way and the pause after it
        elapsed = time + self.plan.start / self.plan.speed
        laps, within = divmod(elapsed, lap)
        done = min(within / walking, 1.0) * self._way
        walked = laps * self._way + done
        back = int(laps) % 2 == 1
        x, y, yaw = self._place(self._way - done if back else done)
        if back:
            yaw = math.atan2(-math.sin(yaw), -math.cos(yaw))
        moving = within < walking
        speed = self.plan.speed if moving else 0.0
        return PersonState(
            x,
            y,
            yaw,
            (speed * math.cos(yaw), speed * math.sin(yaw)) if moving else (0.0, 0.0),
            walked,
        )

    def _place(self, along: float) -> tuple[float, float, float]:
        leg = int(
            np.clip(np.searchsorted(self._ends, along, "right") - 1, 0, len(self._lengths) - 1)
        )
        start, end = self._points[leg], self._points[leg + 1]
        share = (along - self._ends[leg]) / self._lengths[leg]
        x, y = start + share * (end - start)
        return float(x), float(y), math.atan2(end[1] - start[1], end[0] - start[0])
