"""What a tracking scenario is, and how its random details are drawn (the catalogue lists them)."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from typing import Sequence

import numpy as np

from safe_passage.core.errors import InputError
from safe_passage.core.geometry import Pose, outline, placed
from safe_passage.core.grid import GridMap
from safe_passage.simulation.drive import Base, Twist
from safe_passage.simulation.people_assets import list_people
from safe_passage.simulation.robots import Robot
from safe_passage.simulation.static_map import make_map
from safe_passage.simulation.walkers import Walker
from safe_passage.simulation.worlds import PersonPlan, World

BETWEEN_PEOPLE = 0.55  # [m] nobody walks through another
TO_ROBOT = 0.4  # [m] from its outline to a person's middle
TO_THINGS = 0.22  # [m] from a person's middle
STEP = 0.02  # [s] of the simulator: a scanner's 80 ms are four of them
CHECK = 5  # steps between two looks at whether everyone keeps apart
TRIES = 1000


@dataclass(frozen=True)
class Leg:
    """The robot wants this twist until a time."""

    until: float  # [s]
    twist: Twist


@dataclass(frozen=True)
class Lidar3D:
    """A spinning lidar of many rings over base's origin. Defaults: Velodyne HDL-32E."""

    name: str = "velodyne"
    z: float = 1.3  # [m] over the floor
    lowest: float = -0.5353  # [rad] elevation of the rings
    highest: float = 0.1862  # [rad]
    rings: int = 32
    columns: int = 1800
    range_max: float = 100.0  # [m]
    noise: float = 0.02  # [m] standard deviation of a range
    dropout: float = 0.01  # share of beams that come back without a range
    steps: int = 5  # of STEP a turn: 10 Hz

    def directions(self) -> np.ndarray:
        """(rings * columns, 3) unit vectors, its frame: that of base, higher."""
        up = np.linspace(self.lowest, self.highest, self.rings)[:, None]
        around = np.linspace(-math.pi, math.pi, self.columns, endpoint=False)
        flat = np.cos(up)
        rays = (flat * np.cos(around), flat * np.sin(around), np.sin(up) + 0.0 * around)
        return np.stack(rays, axis=-1).reshape(-1, 3)

    def pose_in_base(self) -> np.ndarray:
        """(4, 4) of its frame."""
        T = np.eye(4)
        T[2, 3] = self.z
        return T


@dataclass(frozen=True)
class TrackingScenario:
    """One recording's definition: with its seed all that it depends on."""

    name: str
    seed: int
    seconds: float
    world: World
    robot: Robot  # with the sensors that are recorded
    people: tuple[PersonPlan, ...]
    start: Pose  # of the robot, frame map
    program: tuple[Leg, ...] = ()  # afterwards the robot stands
    camera_rate: float = 0.0  # [Hz], 0: cameras are not looked at
    shift: float = 1.0  # [m] along its way that a person begins later, at most
    reach: float = 12.0  # [m] as far as the tracker looks along x and y: its grid's radius

    lidar3d: Lidar3D | None = None
    cycle_steps: int = 2  # between two looks at the truth: a robot's two scanners take turns

    @property
    def drives(self) -> bool:
        """Whether the robot moves at all."""
        return bool(self.program)

    def twist_at(self, time: float) -> Twist:
        """What the robot wants at `time` [s]."""
        return next((leg.twist for leg in self.program if time < leg.until), Twist())


def drawn(nominal: TrackingScenario) -> TrackingScenario:
    """`nominal` with its people's plans varied at random, such that all keep apart.

    Raises:
        InputError: chance finds no such plans.
    """
    rng = np.random.default_rng((nominal.seed, *nominal.name.encode()))
    static = make_map(nominal.world, nominal.robot.height)
    clearance = static.distances()
    poses = nominal_poses(nominal)
    bodies = rng.permutation(list_people())
    for _ in range(TRIES):
        plans = [varied(plan, nominal.shift, rng) for plan in nominal.people]
        plans = [replace(plan, body=str(bodies[i % len(bodies)])) for i, plan in enumerate(plans)]
        if keep_apart(plans, poses, nominal.robot, static, clearance):
            return replace(nominal, people=tuple(plans))
    raise InputError(f"{nominal.name}, seed {nominal.seed}: no plans in which all keep apart")


def varied(plan: PersonPlan, shift: float, rng: np.random.Generator) -> PersonPlan:
    """The same way at another speed, somewhat shifted, begun up to `shift` [m] later."""
    if len(plan.waypoints) == 1:
        return plan
    points = np.array(plan.waypoints) + rng.uniform(-0.12, 0.12, (len(plan.waypoints), 2))
    return replace(
        plan,
        waypoints=tuple((float(x), float(y)) for x, y in points),
        speed=plan.speed * float(rng.uniform(0.85, 1.2)),
        start=plan.start + float(rng.uniform(0.0, shift)),
    )


def nominal_poses(scenario: TrackingScenario) -> np.ndarray:
    """(N, 3) where the program leads the robot every STEP, frame map."""
    exact = replace(scenario.robot.drive, odometry_noise=0.0, odometry_scale=0.0)
    base = Base(exact, scenario.start, np.random.default_rng(0))
    poses = []
    for step in range(round(scenario.seconds / STEP) + 1):
        time = step * STEP
        poses.append(base.pose)
        if scenario.drives:
            base.command(scenario.twist_at(time), time)
            base.accept(*base.next(time, STEP), STEP)
    return np.array(poses)


def keep_apart(
    plans: Sequence[PersonPlan],
    poses: np.ndarray,
    robot: Robot,
    static: GridMap,
    clearance: np.ndarray,
) -> bool:
    """Whether nobody touches another, the robot on its `poses` (N, 3), or a thing."""
    times = np.arange(0, len(poses), CHECK) * STEP
    walkers = [Walker(plan) for plan in plans]
    ways = np.array([[(s.x, s.y) for s in map(w.at, times)] for w in walkers]).reshape(
        len(plans), len(times), 2
    )
    for a, b in itertools.combinations(ways, 2):
        if np.hypot(*(a - b).T).min() < BETWEEN_PEOPLE:
            return False
    bodies = placed(outline(np.array(robot.footprint), spacing=0.1), poses[::CHECK])
    for way in ways:
        if np.hypot(*np.moveaxis(bodies - way[:, None], -1, 0)).min() < TO_ROBOT:
            return False
        row, column, inside = static.cells(way)
        if not inside.all() or clearance[row, column].min() < TO_THINGS:
            return False
    return True
