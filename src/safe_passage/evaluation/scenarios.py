"""Random scenarios of paper 002, Fig. 9: a robot goes to a pallet, a person is near its way."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from safe_passage.core.geometry import Pose, compose
from safe_passage.core.grid import GridMap
from safe_passage.costmap.footprint import inscribed_radius
from safe_passage.navigation import NavigatorParameters
from safe_passage.navigation.global_planner import GlobalPlanner
from safe_passage.simulation.people_assets import list_people
from safe_passage.simulation.worlds import PersonPlan, World

GAP = 0.10  # [m] between the robot's front and the pallet at the goal
PALLET_LENGTH = 1.2  # [m]
KINDS = ("standing", "walking")


@dataclass(frozen=True)
class Scenario:
    """One run's task."""

    kind: str  # standing or walking
    start: Pose  # frame map
    goal: Pose
    pallet: Pose
    people: tuple[PersonPlan, ...]


class ScenarioMaker:
    """Draws scenarios in a world.

    Args:
        world, static: hall and its map.
        navigator: of the robot, for its outline.
        way: [m] least and greatest length of the way to the goal.
    """

    def __init__(
        self,
        world: World,
        static: GridMap,
        navigator: NavigatorParameters,
        way: tuple[float, float] = (5.0, 14.0),
    ) -> None:
        self._world, self._static, self._way = world, static, way
        self._clearance = static.distances()
        corners = np.array(navigator.footprint)
        self._front = float(corners[:, 0].max())
        radius = inscribed_radius(corners)
        self._planner = GlobalPlanner(static, radius, navigator.area_cost)

    def draw(self, kind: str, rng: np.random.Generator) -> Scenario:
        """The next scenario of `kind`."""
        while True:
            pallet = self._world.pallets[rng.integers(len(self._world.pallets))]
            goal = compose(pallet, (-0.5 * PALLET_LENGTH - GAP - self._front, 0.0, 0.0))
            start = self._start(rng)
            if not self._fits(goal) or start is None:
                continue
            self._planner.plan(goal, np.empty((0, 2)))
            way = self._planner.way(start)
            length = float(np.hypot(*np.diff(way, axis=0).T).sum()) if len(way) > 1 else 0.0
            if not self._way[0] <= length <= self._way[1]:
                continue
            person = self._person(kind, way, start, goal, rng)
            if person is not None:
                return Scenario(kind, start, goal, pallet, (person,))

    def _start(self, rng: np.random.Generator) -> Pose | None:
        """Anywhere with room to turn."""
        half = 0.5 * np.array(self._world.size)
        x, y = rng.uniform(-half, half)
        room = self._room(np.array([x, y]))
        return (float(x), float(y), float(rng.uniform(-math.pi, math.pi))) if room > 0.7 else None

    def _person(
        self, kind: str, way: np.ndarray, start: Pose, goal: Pose, rng: np.random.Generator
    ) -> PersonPlan | None:
        """Beside the way, not where the robot starts or where it must stand in the end."""
        index = int(rng.integers(len(way) // 4, max(len(way) // 4 + 1, 4 * len(way) // 5)))
        along = way[min(index + 3, len(way) - 1)] - way[max(index - 3, 0)]
        heading = math.atan2(along[1], along[0])
        side = np.array([-math.sin(heading), math.cos(heading)])
        place = way[index] + side * rng.uniform(-1.6, 1.6)
        body = str(rng.choice(list_people()))
        if kind == "standing":
            yaw = float(rng.uniform(-math.pi, math.pi))
            if self._far(place, start, goal) and self._room(place) > 0.35:
                return PersonPlan(body, (_pair(place),), yaw=yaw)
            return None
        # walks towards the robot beside its way, or across the way, once
        if rng.random() < 0.5:
            direction = -along / max(float(np.hypot(*along)), 1e-9)
            end = place + direction * rng.uniform(3.0, 6.0)
        else:
            end = way[index] - (place - way[index]) * rng.uniform(1.0, 2.0)
            if np.hypot(*(end - place)) < 1.0:
                return None
        if not self._clear_line(place, end) or not self._far(place, start, goal):
            return None
        if not self._far(end, start, goal):
            return None
        speed = float(rng.uniform(0.6, 1.3))
        return PersonPlan(body, (_pair(place), _pair(end)), speed=speed, pause=3600.0)

    def _far(self, place: np.ndarray, start: Pose, goal: Pose) -> bool:
        return bool(np.hypot(*(place - start[:2])) > 2.5 and np.hypot(*(place - goal[:2])) > 2.0)

    def _clear_line(self, a: np.ndarray, b: np.ndarray) -> bool:
        return all(self._room(a + share * (b - a)) > 0.35 for share in np.linspace(0, 1, 30))

    def _room(self, place: np.ndarray) -> float:
        """[m] to the nearest thing of the map."""
        row, column, inside = self._static.cells(place)
        return float(self._clearance[row, column]) if inside else 0.0

    def _fits(self, pose: Pose) -> bool:
        """Whether nothing stands where the robot must turn before its goal."""
        return self._room(np.array(compose(pose, (-0.8, 0.0, 0.0))[:2])) > 0.6


def _pair(point: np.ndarray) -> tuple[float, float]:
    return float(point[0]), float(point[1])
