"""The tracking scenarios: who walks where, and what the robot does meanwhile.

Frame of all places: map. Metres, metres a second, seconds.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any, Callable, Mapping, Sequence

from safe_passage.evaluation.tracking_scenarios import Leg, TrackingScenario, drawn
from safe_passage.simulation.drive import Twist
from safe_passage.simulation.robots import Robot, load_robot
from safe_passage.simulation.worlds import PersonPlan, World, load_world, make_world

NORTH = 0.5 * math.pi
TUNING_SEED = 1  # what parameters are chosen with; benchmarks have seeds of their own

HALL: Mapping[str, Any] = {  # things along the walls, the middle free
    "name": "hall",
    "size": [12.0, 10.0],
    "start": [0.0, -3.5, NORTH],
    "benches": [
        {"x": -3.5, "y": 4.3, "length": 2.0},
        {"x": 3.2, "y": 4.3, "length": 2.4},
        {"x": -5.4, "y": -3.4, "yaw": NORTH},
    ],
    "cabinets": [{"x": 0.0, "y": 4.6}, {"x": 1.0, "y": 4.6}, {"x": 5.6, "y": -1.5, "yaw": -NORTH}],
    "shelves": [{"x": -5.65, "y": 1.0, "yaw": NORTH}, {"x": 4.2, "y": -4.7, "yaw": math.pi}],
    "stools": [{"x": -3.2, "y": 3.5}, {"x": 4.9, "y": -3.6, "yaw": 0.4}],
    "pallets": [{"x": -3.0, "y": -4.3, "yaw": 0.1, "goods": 0.6}],
    "trolleys": [{"x": 5.2, "y": 3.4, "yaw": 1.2}],
}
PILLARS = [
    {"x": -2.2, "y": 0.6, "size": [0.5, 0.5, 3.0], "material": "wall"},
    {"x": 0.5, "y": 0.3, "size": [0.4, 0.4, 3.0], "material": "wall"},
    {"x": 2.9, "y": 0.8, "size": [0.7, 0.4, 3.0], "material": "wall"},
]
TABLES: Mapping[str, Sequence[Mapping[str, Any]]] = {  # in the middle, to be passed
    "benches": [{"x": -2.0, "y": 0.0, "length": 2.0}, {"x": 1.9, "y": 0.4, "yaw": NORTH}],
    "boxes": [{"x": 0.0, "y": 2.2, "size": [1.2, 0.6, 0.9], "material": "wood"}],
    "stools": [{"x": -3.2, "y": 3.5}, {"x": 4.9, "y": -3.6, "yaw": 0.4}],
}
YARD = {  # wider than the tracker looks, rooms at both ends
    "name": "yard",
    "size": [34.0, 14.0],
    "start": [0.0, -4.0, NORTH],
    "walls": [
        {"points": [[-6.5, 7.0], [-6.5, 2.4]]},
        {"points": [[-6.5, 0.9], [-6.5, -1.5], [-10.0, -1.5]]},
        {"points": [[7.5, 7.0], [7.5, 4.0], [10.0, 4.0]]},
    ],
    "boxes": [
        {"x": 3.5, "y": 5.5, "size": [1.0, 1.0, 1.2]},
        {"x": -3.0, "y": 4.5, "size": [0.3, 0.3, 3.0], "material": "wall"},
        {"x": 4.0, "y": -2.5, "size": [0.3, 0.3, 3.0], "material": "wall"},
    ],
    "pallets": [{"x": -4.5, "y": -4.0, "goods": 0.8}, {"x": 6.5, "y": -5.0, "goods": 0.5}],
}


def walk(
    *waypoints: tuple[float, float], speed: float = 1.1, start: float = 0.0, pause: float = 0.5
) -> PersonPlan:
    return PersonPlan(waypoints=waypoints, speed=speed, start=start, pause=pause)


def stand(x: float, y: float, yaw: float = 0.0) -> PersonPlan:
    return PersonPlan(waypoints=((x, y),), yaw=yaw)


def later(
    first: tuple[float, float], to: tuple[float, float], stands: float, speed: float, pause: float
) -> PersonPlan:
    """Stands at `first` for `stands` [s], walks `to` there, pauses, comes back and so on."""
    way = math.dist(first, to)
    return walk(to, first, speed=speed, start=way + (pause - stands) * speed, pause=pause)


def drive(until: float, forward: float = 0.0, left: float = 0.0, turn: float = 0.0) -> Leg:
    return Leg(until, Twist(forward, left, turn))


def hall(**more: Sequence[Mapping[str, Any]]) -> World:
    return make_world({**HALL, **more})


class Catalogue:
    """Makes the scenarios for a robot.

    Args:
        config: folder of the package's worlds and robots.
        seed: of people's ways and all noise.
        camera_rate: [Hz] at which each camera looks; 0: only where the scenario is about cameras.
    """

    def __init__(self, config: Path, seed: int, camera_rate: float = 0.0) -> None:
        self._config, self._seed, self._camera_rate = config, seed, camera_rate
        self._robot = load_robot(config / "robots" / "omnirob.yaml").without_arm()

    def names(self) -> tuple[str, ...]:
        """Of all scenarios, in the order of reports."""
        return tuple(self._makers())

    def make(self, name: str) -> TrackingScenario:
        """The scenario of this name."""
        return drawn(replace(self._makers()[name](), name=name))

    def all(self) -> list[TrackingScenario]:
        """Every one."""
        return [self.make(name) for name in self.names()]

    def _makers(self) -> dict[str, Callable[[], TrackingScenario]]:
        return {
            "crossing_standing": self._crossing_standing,
            "crossing_driving": self._crossing_driving,
            "crossing_corridors": self._crossing_corridors,
            "occlusion_pillars": self._occlusion_pillars,
            "occlusion_people": self._occlusion_people,
            "past_table": self._past_table,
            "past_table_driving": self._past_table_driving,
            "stand_walk_stand": self._stand_walk_stand,
            "enter_leave": self._enter_leave,
            "fig6": self._fig6,
            "workshop_driving": self._workshop_driving,
            "static_driving": self._static_driving,
            "static_turning": self._static_turning,
        }

    def _scenario(
        self,
        world: World,
        seconds: float,
        people: Sequence[PersonPlan],
        start: tuple[float, float, float],
        program: Sequence[Leg] = (),
        camera_rate: float = 0.0,
        shift: float = 1.0,
    ) -> TrackingScenario:
        camera_rate = self._camera_rate or camera_rate
        robot: Robot = self._robot if camera_rate else replace(self._robot, cameras=())
        return TrackingScenario(
            *("", self._seed, seconds, world, robot, tuple(people), start, tuple(program)),
            camera_rate=camera_rate,
            shift=shift,
        )

    def _crossing_standing(self) -> TrackingScenario:
        people = [
            walk((-4.5, -0.8), (4.5, -0.6)),
            walk((4.2, 1.6), (-4.2, -1.8), speed=1.2),
            walk((0.8, 3.4), (-0.8, -1.9), speed=0.9),
        ]
        return self._scenario(hall(), 24.0, people, (0.0, -3.5, NORTH), shift=5.0)

    def _crossing_driving(self) -> TrackingScenario:
        people = [
            walk((-4.0, -2.0), (3.0, 3.2)),
            walk((3.5, -1.9), (-3.5, 2.5), speed=1.2),
            walk((-4.6, 0.6), (4.8, 0.3), speed=1.0),
        ]
        program = [drive(9.0, 0.5), drive(12.0), drive(21.0, -0.4, 0.05, 0.05)]
        return self._scenario(hall(), 24.0, people, (-2.6, -3.3, 0.0), program, shift=5.0)

    def _crossing_corridors(self) -> TrackingScenario:
        world = load_world(self._config / "worlds" / "crossing.yaml")
        people = [
            walk((0.4, -6.0), (0.4, 6.0), speed=1.2),
            walk((-0.3, 5.0), (-0.3, -0.5), (6.5, -0.7), start=3.0),
            walk((6.4, 0.2), (-1.2, 0.25), speed=0.9, pause=2.0),
        ]
        program = [drive(8.0, 0.5), drive(12.0), drive(15.0, turn=0.5), drive(20.0, turn=-0.5)]
        return self._scenario(world, 24.0, people, (-6.8, -0.2, 0.0), program, shift=4.0)

    def _occlusion_pillars(self) -> TrackingScenario:
        people = [
            walk((-5.0, 2.0), (5.0, 2.0), speed=1.2),
            walk((4.2, 3.0), (-5.0, 2.8), start=2.0),
            walk((-4.0, -1.2), (4.0, -1.3), speed=0.9),
        ]
        return self._scenario(hall(boxes=PILLARS), 24.0, people, (0.0, -3.4, NORTH))

    def _occlusion_people(self) -> TrackingScenario:
        people = [
            walk((-4.0, -0.8), (4.0, -0.8), speed=0.8),
            walk((-4.0, 0.4), (4.0, 0.4), speed=1.25),
            stand(1.0, 1.8, -NORTH),
            walk((-4.5, 2.9), (4.0, 2.6)),
        ]
        program = [drive(4.0), drive(9.0, turn=0.4), drive(20.0, turn=-0.4)]
        return self._scenario(hall(), 22.0, people, (0.0, -3.3, NORTH), program)

    def _past_table(self) -> TrackingScenario:
        return self._scenario(hall(**TABLES), 24.0, self._table_walkers(), (-0.2, -2.9, NORTH))

    def _past_table_driving(self) -> TrackingScenario:
        program = [drive(10.0, 0.5), drive(13.0), drive(23.0, -0.4, turn=0.05)]
        return self._scenario(
            hall(**TABLES), 24.0, self._table_walkers(), (-2.4, -3.2, 0.0), program
        )

    @staticmethod
    def _table_walkers() -> list[PersonPlan]:
        return [
            walk((-4.3, -0.85), (-0.5, -0.85), (1.0, -1.3), (4.2, -1.2), speed=1.0),
            walk((2.75, 3.0), (2.75, -0.4), speed=0.9, pause=1.5),
            walk((-1.6, 3.2), (-1.0, 1.5), (1.0, 1.5), (1.1, -0.3), start=2.0),
        ]

    def _stand_walk_stand(self) -> TrackingScenario:
        world = load_world(self._config / "worlds" / "workshop.yaml")
        people = [
            later((-0.9, -2.0), (3.6, -1.8), 4.0, 1.0, 5.0),
            later((0.1, -2.8), (-2.8, -2.6), 6.0, 1.1, 7.0),
            later((-4.6, 0.2), (-2.8, 0.5), 3.0, 0.8, 4.0),
            stand(4.4, -1.2, 1.5),
        ]
        program = [drive(5.0), drive(12.0, turn=0.3), drive(20.0, turn=-0.3)]
        return self._scenario(world, 26.0, people, (-4.6, -2.0, 0.0), program)

    def _enter_leave(self) -> TrackingScenario:
        people = [
            walk((-15.0, 1.6), (15.5, 1.0), speed=1.4),
            walk((14.5, -0.6), (-5.4, -0.6), speed=1.3, start=2.0),
            walk((-8.5, 4.6), (-7.6, 1.7), (-4.0, 2.8), (6.5, 3.2), speed=1.2, pause=1.0),
        ]
        return self._scenario(make_world(YARD), 28.0, people, (0.0, -4.0, NORTH))

    def _fig6(self) -> TrackingScenario:
        """Once around the robot, and some more; a closed way is begun anywhere."""
        angles = [2.3 + 2.0 * math.pi * i / 16 for i in range(19)]
        loop = [(2.3 * math.cos(a), 1.9 * math.sin(a) - 0.3) for a in angles]
        return self._scenario(
            hall(), 19.0, [walk(*loop, speed=0.95, pause=3.0)], (0.0, -0.3, 0.0), camera_rate=4.0
        )

    def _workshop_driving(self) -> TrackingScenario:
        world = load_world(self._config / "worlds" / "workshop.yaml")
        people = [
            walk((3.85, 2.2), (3.85, -1.2), (3.3, -3.0), speed=1.0, pause=1.0),
            walk((-4.2, 3.2), (-4.2, 0.9), (-3.0, -0.6), speed=1.0, start=1.0),
            later((2.6, -0.3), (1.3, -1.0), 3.0, 0.8, 3.0),
        ]
        return self._scenario(world, 24.0, people, (-4.6, -2.2, 0.0), self._tour())

    def _static_driving(self) -> TrackingScenario:
        world = load_world(self._config / "worlds" / "workshop.yaml")
        people = [stand(-2.4, -0.9, 1.4), stand(3.4, -1.4, 1.6)]
        return self._scenario(world, 24.0, people, (-4.6, -2.2, 0.0), self._tour())

    def _static_turning(self) -> TrackingScenario:
        world = load_world(self._config / "worlds" / "workshop.yaml")
        program = [
            drive(6.0, turn=0.7),
            drive(8.5, left=-0.3),
            drive(15.0, turn=-0.8),
            drive(20.0, 0.1, 0.0, 0.5),
        ]
        people = [stand(-0.9, -1.25, 1.4)]
        return self._scenario(world, 22.0, people, (3.2, -1.4, 0.0), program)

    @staticmethod
    def _tour() -> list[Leg]:
        return [
            drive(7.6, 0.5),
            drive(9.0),
            drive(12.5, turn=0.3),
            drive(15.5, turn=-0.3),
            drive(22.0, -0.45, 0.12, -0.02),
        ]
