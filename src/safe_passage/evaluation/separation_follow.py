"""A person walks out of the camera's view and around the robot: does the safety area follow?

Detections (of the truth, late and noisy, in the camera's view alone) and real scans go through the
tracker, its labels of persons and the safety areas' own code.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

import safe_passage._safety_area as safety
from safe_passage.core.geometry import Pose, compose, inverse, matrix
from safe_passage.evaluation.person_tracker import PersonTracker
from safe_passage.evaluation.separation_crossings import STEP
from safe_passage.evaluation.separation_runs import (
    CYCLE_STEPS,
    crossing_robot,
    lidar_tracker,
)
from safe_passage.evaluation.tracking_catalogue import HALL
from safe_passage.evaluation.tracking_recording import SCAN_STEPS
from safe_passage.evaluation.tracking_runs import scan_measurement
from safe_passage.monitoring.aggregation import Measurement
from safe_passage.monitoring.person_looks import Look, View
from safe_passage.monitoring.persons import PersonLabelParameters
from safe_passage.simulation.drive import Twist
from safe_passage.simulation.people_assets import list_people
from safe_passage.simulation.robots import LidarModel
from safe_passage.simulation.simulator import Simulator
from safe_passage.simulation.walkers import PersonState
from safe_passage.simulation.worlds import PersonPlan, World, make_world

VIEW, NEAR, FAR = 1.0, 1.0, 5.0  # [rad], [m] in which the camera finds persons
LOOK_STEPS = 10  # of STEP between two pictures: 5 Hz
LATE = 10  # steps until the detector has its answer: 0.2 s
NOISE = 0.1  # [m] of a detection's place, each way
RECALL = 0.9  # share of pictures in which the person in view is found
AWAY = 1.0  # [m] areas farther from the person are somebody else's
LOOPS = 1.25  # times around the robot
FIRST = 0.4  # [s] from the first detection's arrival until an area must be there


@dataclass(frozen=True)
class Round:
    """Somebody goes around a robot that stands, turns or drives slowly."""

    number: int
    seed: int
    plan: PersonPlan
    start: Pose
    command: Twist
    seconds: float


@dataclass(frozen=True)
class FollowJob:
    """One round for one process."""

    round: Round
    config: Path


@dataclass(frozen=True)
class Followed:
    """Per scan of the front lidar, from shortly after the first detection on."""

    error: np.ndarray  # (K,) [m] from the person to the nearest area's middle, inf: there is none
    in_view: np.ndarray  # (K,) bool
    strangers: np.ndarray  # (K,) areas where nobody is
    times: np.ndarray  # (K,) [s]


@lru_cache(maxsize=1)
def _hall() -> World:
    return make_world(HALL)


class _Arena(Simulator):
    STEP = STEP


def make_round(number: int, seed: int) -> Round:
    """The robot is in the hall's middle, the person begins before it."""
    rng = np.random.default_rng((seed, number))
    radius, speed = rng.uniform(1.9, 2.7), rng.uniform(0.6, 1.4)
    turn = rng.choice([-1.0, 1.0])
    angles = turn * np.linspace(-0.2, 2.0 * math.pi * LOOPS, 40)
    points = [(radius * math.cos(a), 0.9 * radius * math.sin(a)) for a in angles]
    way = float(np.hypot(*np.diff(points, axis=0).T).sum())
    commands = Twist(), Twist(turn=float(rng.uniform(-0.25, 0.25))), Twist(0.04, 0.0, 0.03)
    plan = PersonPlan(
        body=str(rng.choice(list_people())), waypoints=tuple(points), speed=speed, pause=60.0
    )
    start = (0.0, -0.3, 0.0)
    return Round(number, seed, plan, start, commands[number % 3], way / speed + 2.0)


def follow_round(job: FollowJob) -> Followed:
    """Run it."""
    return _Follower(job.round, job.config).run()


class _Follower:
    def __init__(self, one: Round, config: Path) -> None:
        self._round = one
        robot = crossing_robot(config)
        self._arena = _Arena(_hall(), robot, one.seed + one.number, [one.plan], one.start)
        parameters = lidar_tracker(config)
        self._sources = {source.name: source for source in parameters.sources}
        self._tracker = PersonTracker(parameters, PersonLabelParameters())
        self._merger = safety.Pipeline(safety.PipelineParameters())
        self._rng = np.random.default_rng((one.seed, one.number, 1))
        self._answers: list[tuple[int, Look]] = []  # step in which it comes
        self._first = math.inf

    def run(self) -> Followed:
        arena, rows, pending = self._arena, [], []
        for step in range(1, round(self._round.seconds / STEP) + 1):
            arena.command(self._round.command)
            arena.step()
            if step % LOOK_STEPS == 0:
                self._look(step)
            for i, lidar in enumerate(arena.robot.lidars):
                if step % SCAN_STEPS == (SCAN_STEPS // 2 * i) % SCAN_STEPS:
                    ranges = arena.scan(lidar).ranges
                    source, pose = self._sources[lidar.name], arena.base.odometry
                    pending.append(scan_measurement(lidar, ranges, source, arena.time, pose))
                    if i == 0 and arena.time > self._first + FIRST:
                        rows.append(self._merge(lidar, ranges))
            if step % CYCLE_STEPS == 0:
                self._track(step, pending)
                pending = []
        arena.close()
        error, in_view, strangers, times = (np.array(column) for column in zip(*rows))
        return Followed(error, in_view, strangers, times)

    def _person(self) -> Pose:
        """Frame of the odometry, as seen from the robot."""
        base, state = self._arena.base, self._arena.people()[0]
        return compose(base.odometry, compose(inverse(base.pose), (state.x, state.y, state.yaw)))

    def _sees(self, state: PersonState) -> bool:
        x, y, _ = compose(inverse(self._arena.base.pose), (state.x, state.y, 0.0))
        return abs(math.atan2(y, x)) < 0.5 * VIEW and NEAR < math.hypot(x, y) < FAR

    def _look(self, step: int) -> None:
        """The camera is in the middle of the robot and looks ahead."""
        x, y, yaw = self._arena.base.odometry
        seen = self._sees(self._arena.people()[0]) and self._rng.random() < RECALL
        at = np.array([self._person()[:2]]) + self._rng.normal(0.0, NOISE, (1, 2))
        places = at if seen else np.empty((0, 2))
        view = View((x, y), yaw, VIEW, NEAR, FAR)
        look = Look(self._arena.time, places, np.full(len(places), 0.9), view)
        self._answers.append((step + LATE, look))

    def _track(self, step: int, measurements: list[Measurement]) -> None:
        """A cycle of the tracker, and what the detector has answered until then."""
        arena = self._arena
        looks = [look for at, look in self._answers if at <= step]
        self._answers = [one for one in self._answers if one[0] > step]
        tracked = self._tracker.update(arena.time, arena.base.odometry, measurements, looks)
        for look in looks:
            self._first = min(self._first, arena.time if len(look.position) else math.inf)
            self._merger.remember([_detected(look.stamp, at) for at in look.position.tolist()])
        self._merger.remember(tracked)

    def _merge(self, lidar: LidarModel, ranges: np.ndarray) -> tuple[float, bool, int, float]:
        """Error of the nearest area, whether the camera sees the person, other areas, time."""
        arena = self._arena
        angles = lidar.angles()
        limits = (lidar.range_min, lidar.range_max)
        scan = safety.Scan(ranges, angles[0], angles[-1], angles[1] - angles[0], *limits)
        T_odom_laser = matrix(arena.base.odometry) @ _level(lidar)
        laser = safety.LaserPose(np.linalg.inv(T_odom_laser))
        areas = self._merger.merge(scan, arena.time, laser).areas
        middles = areas[:, :2] @ T_odom_laser[:2, :2].T + T_odom_laser[:2, 3]
        away = np.hypot(*(middles - np.array(self._person()[:2])).T)
        nearest = float(away.min(initial=math.inf))
        return nearest, self._sees(arena.people()[0]), int((away > AWAY).sum()), arena.time


def _level(lidar: LidarModel) -> np.ndarray:
    T = matrix((lidar.x, lidar.y, lidar.yaw))
    T[2, 3] = lidar.z
    return T


def _detected(stamp: float, at: list[float]) -> safety.Person:
    """As the merger hears of it from the detector itself."""
    return safety.Person(stamp, [*at, 0.0], source="camera")
