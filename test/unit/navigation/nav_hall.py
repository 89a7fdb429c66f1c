"""A robot that a navigator drives in a hall, without sensors: obstacles are told."""

from __future__ import annotations

from typing import Callable

import numpy as np
from safe_passage.core.geometry import Pose, outline, placed
from safe_passage.core.grid import GridMap
from safe_passage.navigation import Navigator, NavigatorParameters
from safe_passage.navigation.local_planner import Velocity
from safe_passage.simulation.drive import Base, Twist
from safe_passage.simulation.robots import DriveModel
from safe_passage.simulation.static_map import make_map
from safe_passage.simulation.worlds import make_world

STEP, CYCLE = 0.025, 4  # [s], steps
Seen = Callable[[float], np.ndarray]  # time [s] -> obstacles (N, 2) [m], frame map


def hall(**elements) -> GridMap:
    """The map of a hall of 10 m by 8 m."""
    world = make_world({"name": "hall", "size": [10.0, 8.0], "start": [0, 0, 0], **elements})
    return make_map(world, 1.7)


def nothing(time: float) -> np.ndarray:
    return np.empty((0, 2))


class Drive:
    """A navigator at the wheel; `T_map_seen` is where the costmap's frame lies."""

    def __init__(
        self,
        static: GridMap,
        start: Pose,
        seen: Seen = nothing,
        T_map_seen: Pose = (0.0, 0.0, 0.0),
        **parameters,
    ) -> None:
        self.parameters = NavigatorParameters(**parameters)
        self.navigator = Navigator(self.parameters, static)
        self.base = Base(DriveModel(), start, np.random.default_rng(0))
        self.time, self.states, self.touched = 0.0, [], 0
        self._static, self._seen, self._T = static, seen, T_map_seen
        self._outline = outline(np.array(self.parameters.footprint), 0.04)

    def until(self, time: float) -> Drive:
        """Drive to the goal, or until `time` [s]."""
        while self.navigator.active and self.time < time:
            twist = self.base.twist
            seen = self._grid()
            now = Velocity(twist.forward, twist.turn)
            wanted = self.navigator.step(self.time, self.base.pose, now, seen, self._T)
            self.states.append(self.navigator.state)
            self.base.command(Twist(wanted.forward, 0.0, wanted.turn), self.time)
            for _ in range(CYCLE):
                self.base.accept(*self.base.next(self.time, STEP), STEP)
                self.time += STEP
            at = placed(self._outline, self.base.pose)
            self.touched += bool(self._static.at(at, outside=True).any())
        return self

    @property
    def corners(self) -> np.ndarray:
        """Of the robot (4, 2) [m], frame map."""
        return placed(np.array(self.parameters.footprint), self.base.pose)

    def _grid(self) -> GridMap:
        """What is seen, in cells of a frame of its own, 16 m around its origin."""
        empty = GridMap(np.zeros((320, 320), bool), (-8.0, -8.0), 0.05)
        c, s = np.cos(self._T[2]), np.sin(self._T[2])
        points = (self._seen(self.time) - self._T[:2]) @ np.array([[c, -s], [s, c]])
        return empty.with_cells_of(points)
