"""Random crossings: a robot on its way, and a person who crosses it and does not look.

Metres, seconds, radians; frame map. About half of the crossings would end in a collision or nearly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from safe_passage.core.errors import InputError
from safe_passage.core.geometry import Pose, outline, placed
from safe_passage.core.grid import GridMap
from safe_passage.simulation.drive import Twist, moved
from safe_passage.simulation.people_assets import list_people
from safe_passage.simulation.static_map import make_map
from safe_passage.simulation.walkers import Walker
from safe_passage.simulation.worlds import PersonPlan, World, make_world

SETTLE = 2.0  # [s] the robot stands before it sets out: a tracker must learn who moves
UNTIL = 3.5  # [s] after the meeting at which a crossing ends
ROBOT_SPEEDS, PERSON_SPEEDS = (0.3, 1.2), (0.5, 2.0)  # [m/s]
LEAD = 1.5, 4.0  # [s] that the robot drives until it is where the ways cross
MISS = 1.8  # [m] by which the middles of both pass each other, at most
CURVED = 0.4  # share of the ways that are arcs
CURVATURE = 0.35  # [1/m] at most
TO_THINGS, ROBOT_TO_THINGS = 0.35, 0.2  # [m] from the person's middle, from the robot's outline
LENGTH = 9.0  # [m] of a person's way, at most, before the meeting
BEYOND = 4.0  # [m] of it after the meeting
STEP = 0.02  # [s] of the simulator
TRIES = 500

HALL = {
    "name": "crossings",
    "size": [20.0, 16.0],
    "start": [0.0, 0.0, 0.0],
    "benches": [{"x": -5.0, "y": 7.3, "length": 2.0}, {"x": 6.0, "y": -7.3, "length": 2.4}],
    "cabinets": [{"x": 0.0, "y": 7.6}, {"x": 1.0, "y": 7.6}],
    "shelves": [{"x": -9.6, "y": 1.0, "yaw": 0.5 * math.pi}],
    "boxes": [  # behind which somebody may come out
        {"x": 2.2, "y": 2.6, "size": [1.4, 0.5, 2.0], "material": "wall"},
        {"x": -2.4, "y": -2.4, "size": [0.6, 0.6, 2.0], "material": "wall"},
        {"x": 2.6, "y": -3.0, "size": [0.5, 1.6, 2.0], "material": "wall"},
        {"x": -3.2, "y": 3.0, "size": [0.5, 0.5, 2.0], "material": "wall"},
    ],
    "pallets": [{"x": 6.5, "y": 5.0, "goods": 0.6}, {"x": -6.0, "y": -5.5, "goods": 0.8}],
    "stools": [{"x": 4.9, "y": 0.5}],
}


@dataclass(frozen=True)
class Crossing:
    """One of them."""

    number: int
    seed: int
    start: Pose  # of the robot
    command: Twist  # that it follows from SETTLE on, if nobody slows it down
    person: PersonPlan
    meeting: float  # [s] when they are nearest, if nobody slows the robot down
    seconds: float  # at which it is over

    def way(self, time: float) -> Pose:
        """Where the robot would be if it had its speed at once and nobody slowed it down."""
        return moved(self.start, self.command, max(0.0, time - SETTLE))


@lru_cache(maxsize=1)
def hall() -> World:
    """Where they take place."""
    return make_world(HALL)


@lru_cache(maxsize=1)
def _floor() -> tuple[GridMap, np.ndarray]:
    static = make_map(hall(), robot_height=1.7)
    return static, static.distances()


def crossing(number: int, seed: int, footprint: np.ndarray) -> Crossing:
    """The crossing of this number.

    Args:
        seed: of all crossings of a benchmark.
        footprint: (C, 2) [m] of the robot.

    Raises:
        InputError: chance finds no place for it.
    """
    rng = np.random.default_rng((seed, number))
    for _ in range(TRIES):
        found = _drawn(number, seed, rng)
        if _has_room(found, footprint):
            return found
    raise InputError(f"crossing {number}, seed {seed}: no place for it in the hall")


def _drawn(number: int, seed: int, rng: np.random.Generator) -> Crossing:
    speed = rng.uniform(*ROBOT_SPEEDS)
    curve = rng.uniform(-CURVATURE, CURVATURE) if rng.random() < CURVED else 0.0
    command = Twist(speed, 0.0, speed * curve)
    heading = rng.uniform(-math.pi, math.pi)
    start = (rng.uniform(-4.0, 4.0), rng.uniform(-3.0, 3.0), heading)
    meeting_time = SETTLE + rng.uniform(*LEAD)
    x, y, yaw = moved(start, command, meeting_time - SETTLE)
    walks = rng.uniform(*PERSON_SPEEDS)
    direction = yaw + rng.uniform(-math.pi, math.pi)
    ahead = np.array([math.cos(direction), math.sin(direction)])
    relative = walks * ahead - speed * np.array([math.cos(yaw), math.sin(yaw)])
    aside = np.array([-relative[1], relative[0]]) / max(float(np.hypot(*relative)), 1e-6)
    place = np.array([x, y]) + rng.uniform(-MISS, MISS) * aside
    length = min(LENGTH, walks * meeting_time)
    first, last = place - length * ahead, place + BEYOND * ahead
    stands = meeting_time - length / walks
    way, pause = length + BEYOND, 60.0
    plan = PersonPlan(
        body=str(rng.choice(list_people())),
        waypoints=((float(last[0]), float(last[1])), (float(first[0]), float(first[1]))),
        speed=float(walks),
        start=float(way + (pause - stands) * walks),  # at `first`, where it still stands so long
        pause=pause,
    )
    return Crossing(number, seed, start, command, plan, meeting_time, meeting_time + UNTIL)


def _has_room(found: Crossing, footprint: np.ndarray) -> bool:
    """Whether neither meets a thing, and the person does not begin on the robot."""
    static, clearance = _floor()
    times = np.arange(0.0, found.seconds, 0.1)
    walker = Walker(found.person)
    person = np.array([(s.x, s.y) for s in map(walker.at, times)])
    poses = np.array([found.way(time) for time in times])
    bodies = placed(outline(footprint, spacing=0.1), poses)
    for points, least in ((person, TO_THINGS), (bodies.reshape(-1, 2), ROBOT_TO_THINGS)):
        row, column, inside = static.cells(points)
        if not inside.all() or clearance[row, column].min() < least:
            return False
    return float(np.hypot(*(bodies[0] - person[0]).T).min()) > 1.5
