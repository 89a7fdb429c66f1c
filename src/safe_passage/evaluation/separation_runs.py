"""Crossings in a closed loop: scans -> tracker -> separation monitor -> the robot's speed.

A run ends when robot and person touch: nobody walks on through a robot.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from safe_passage.core.geometry import compose, inverse, rotation
from safe_passage.core.reading import build, read_yaml
from safe_passage.evaluation.separation_crossings import SETTLE, STEP, Crossing, hall
from safe_passage.evaluation.tracking_recording import SCAN_STEPS, SEEN_BEAMS
from safe_passage.evaluation.tracking_runs import scan_measurement, tracker_parameters
from safe_passage.monitoring.aggregation import Measurement
from safe_passage.monitoring.parameters import TrackerParameters
from safe_passage.monitoring.pipeline import ObstacleTracker, Snapshot
from safe_passage.separation import (
    Obstacles,
    RobotState,
    SeparationMonitor,
    SeparationParameters,
)
from safe_passage.separation.robot_motion import Velocity, make_shape
from safe_passage.simulation.drive import Base, Twist
from safe_passage.simulation.robots import DriveModel, Robot, load_robot
from safe_passage.simulation.simulator import Simulator
from safe_passage.simulation.walkers import PersonState, Walker
from safe_passage.simulation.worlds import PersonPlan

CYCLE_STEPS = 2  # of STEP: 25 cycles a second, one with each scan
LATENCY = 2  # steps from the end of a cycle until the robot has its command
BODY = 0.25  # [m] radius of a person
OVER, APART = 1.0, 2.5  # [s] after the meeting, [m] between them: nothing more will happen
FREE = 0.95  # scale of a robot that is not held up
POINTS = 12  # around a person, for the monitor that knows the truth
DRIVE = DriveModel(
    omni=True, max_speed=1.3, max_turn_rate=1.0, acceleration=0.8, turn_acceleration=1.6
)
STAND = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Run:
    """What happened. S steps of the simulator, C cycles; frame map. Cut off at a touch."""

    crossing: Crossing
    poses: np.ndarray  # (S, 3) of the robot
    twists: np.ndarray  # (S, 3) [m/s, rad/s]
    people: np.ndarray  # (S, 2) [m]
    seen: int  # step in which the person first came into a lidar's sight; S: never
    stamps: np.ndarray  # (C,) [s]
    scale: np.ndarray  # (C,) of the command, as the monitor allowed it
    danger: np.ndarray  # (C,) bool: a monitor that knows the truth would slow down
    deciding: np.ndarray  # (C,) number of the track that decides, 0: none
    track: np.ndarray  # (C, 5) the person's track, see _track_of; NaN: there is none
    milliseconds: np.ndarray  # (C,) of the monitor's cycle


class _Arena(Simulator):
    """The hall, its person's way changed from run to run."""

    STEP = STEP

    def begin(self, crossing: Crossing) -> None:
        """Put everything where the crossing begins."""
        self.seed = hash((crossing.seed, crossing.number)) % 2**32
        self._walkers = [Walker(crossing.person)]
        self._start = crossing.start
        self.restart()


@lru_cache(maxsize=1)
def crossing_robot(config: Path) -> Robot:
    """The omniRob of paper 000 with its two lidars, somewhat faster."""
    robot = load_robot(config / "robots" / "omnirob.yaml").without_arm()
    return replace(robot, drive=DRIVE, cameras=())


@lru_cache(maxsize=8)
def _arena(config: Path, body: str) -> _Arena:
    return _Arena(hall(), crossing_robot(config), 0, [PersonPlan(body=body)], (0.0, 0.0, 0.0))


@lru_cache(maxsize=1)
def lidar_tracker(config: Path) -> TrackerParameters:
    """Of the node's yaml, with the lidars alone."""
    parameters = tracker_parameters(config)
    flat = tuple(source for source in parameters.sources if not source.three_dimensional)
    return replace(parameters, sources=flat)


@lru_cache(maxsize=1)
def separation_parameters(config: Path) -> SeparationParameters:
    """Those of the node's own yaml, but for what that asks to be measured on the robot."""
    values = read_yaml(config / "separation_monitor.yaml")
    known = {field.name for field in fields(SeparationParameters)}
    kept = {key: value for key, value in values.items() if key in known}
    kept["acceleration"] = DRIVE.acceleration
    return build(SeparationParameters, kept, "separation_monitor")


def run_crossing(crossing: Crossing, config: Path, static: bool = False) -> Run:
    """Drive it.

    static: obstacles are taken to stand where they are, as a baseline.
    """
    arena = _arena(config, crossing.person.body)
    arena.begin(crossing)
    return _Loop(arena, crossing, config, static).run()


class _Loop:
    def __init__(self, arena: _Arena, crossing: Crossing, config: Path, static: bool) -> None:
        self._arena, self._crossing, self._static = arena, crossing, static
        self._sources = {source.name: source for source in lidar_tracker(config).sources}
        self._tracker = ObstacleTracker(lidar_tracker(config))
        self._p = separation_parameters(config)
        self._monitor = SeparationMonitor(self._p)
        eager = replace(self._p, sigmas=0.0, max_growth=0.0, agility=0.0, release_time=0.0)
        self._truth = SeparationMonitor(replace(eager, release_margin=0.0, rise_rate=1000.0))
        self._pending: list[Measurement] = []
        self._commands: list[tuple[int, Velocity]] = []  # step from which on, command
        self._seen = -1

    def run(self) -> Run:
        arena, crossing = self._arena, self._crossing
        steps = round(crossing.seconds / STEP)
        states: list[tuple[float, ...]] = []
        cycles: list[tuple[float, ...]] = []
        for step in range(1, steps + 1):
            arena.command(Twist(*self._obeyed(step)))
            arena.step()
            self._measure(step)
            person, twist = arena.people()[0], arena.base.twist
            states.append(
                (*arena.base.pose, twist.forward, twist.left, twist.turn, person.x, person.y)
            )
            if step % CYCLE_STEPS == 0:
                cycles.append(self._cycle(step, person))
            if self._is_over(states[-1], cycles):
                break
        state, cycle = np.array(states), np.array(cycles, float)
        seen = self._seen if self._seen >= 0 else len(state)
        return Run(
            crossing, state[:, :3], state[:, 3:6], state[:, 6:], seen,
            cycle[:, 0], cycle[:, 1], cycle[:, 2] > 0.5, cycle[:, 4], cycle[:, 5:], cycle[:, 3],
        )  # fmt: skip

    def _is_over(self, state: tuple[float, ...], cycles: list[tuple[float, ...]]) -> bool:
        gap = float(gaps(np.array([state[:3]]), np.array([state[6:]]), self._p)[0])
        late = self._arena.time > self._crossing.meeting + OVER
        return gap < 0.0 or (late and gap > APART and cycles[-1][1] >= FREE)

    def _obeyed(self, step: int) -> Velocity:
        """The newest command that has reached the robot."""
        while len(self._commands) > 1 and self._commands[1][0] <= step:
            self._commands.pop(0)
        has_one = self._commands and self._commands[0][0] <= step
        return self._commands[0][1] if has_one else STAND

    def _measure(self, step: int) -> None:
        arena = self._arena
        for i, lidar in enumerate(arena.robot.lidars):
            if step % SCAN_STEPS != (SCAN_STEPS // 2 * i) % SCAN_STEPS:
                continue
            scan = arena.scan(lidar)
            if self._seen < 0 and (scan.persons >= 0).sum() >= SEEN_BEAMS:
                self._seen = step - 1
            source = self._sources[lidar.name]
            pose = arena.base.odometry
            seen = scan_measurement(lidar, scan.ranges, source, arena.time, pose)
            self._pending.append(seen)

    def _cycle(self, step: int, person: PersonState) -> tuple[float, ...]:
        """Stamp, allowed scale, danger, time taken, deciding track, the person's track."""
        arena, base = self._arena, self._arena.base
        snapshot = self._tracker.update(arena.time, base.odometry, self._pending)
        self._pending = []
        wanted = self._crossing.command if arena.time >= SETTLE else Twist()
        command = (wanted.forward, wanted.left, wanted.turn)
        robot = RobotState((base.twist.forward, base.twist.left, base.twist.turn))
        began = time.perf_counter()
        obstacles = obstacles_of(snapshot)
        if self._static:
            obstacles = standing(obstacles)
        self._monitor.assess(arena.time, obstacles, robot, command)
        limited, assessment = self._monitor.limit(command)
        taken = 1e3 * (time.perf_counter() - began)
        self._commands.append((step + LATENCY, limited))
        drives = wanted != Twist()
        danger = drives and not self._static and self._is_danger(person, robot, command)
        return (
            arena.time,
            assessment.scale if drives else 1.0,
            float(danger),
            taken,
            assessment.obstacle_id,
            *_track_of(snapshot, person, base),
        )

    def _is_danger(self, person: PersonState, robot: RobotState, command: Velocity) -> bool:
        """Whether a monitor that knows the person exactly would slow the robot down."""
        arena = self._arena
        truth = _truth(person, arena.base)
        return self._truth.assess(arena.time, truth, robot, command).scale < 1.0


def obstacles_of(snapshot: Snapshot) -> Obstacles:
    """The confirmed tracks."""
    tracks, which = snapshot.tracks, snapshot.confirmed
    return Obstacles(
        tracks.id[which],
        tracks.position[which],
        tracks.velocity[which],
        tracks.body_covariance[which],
        tracks.moving[which],
        np.zeros(int(which.sum()), bool),
        [snapshot.shapes[i] for i in np.flatnonzero(which)],
        snapshot.grid.resolution,
    )


def standing(obstacles: Obstacles) -> Obstacles:
    """The same, if nothing ever moved: places for certain, no velocities."""
    return replace(
        obstacles,
        velocity=np.zeros_like(obstacles.velocity),
        covariance=np.zeros_like(obstacles.covariance),
    )


def _truth(person: PersonState, base: Base) -> Obstacles:
    """The person as it is, frame base."""
    to_base = inverse(base.pose)
    at = np.array(compose(to_base, (person.x, person.y, 0.0))[:2])
    turns = np.linspace(0.0, 2.0 * np.pi, POINTS, endpoint=False)
    side = 0.02
    rim = (BODY - side) * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    velocity = rotation(to_base[2]) @ np.array(person.velocity)
    true = np.ones(1, bool)
    covariance = np.zeros((1, 4, 4))
    return Obstacles(
        np.ones(1, int), at[None], velocity[None], covariance, true, true, [at + rim], side
    )


def _track_of(snapshot: Snapshot, person: PersonState, base: Base) -> tuple[float, ...]:
    """Nearest confirmed track: its error [m], that of its velocity [m/s], whether it moves, the
    deviation that it claims of the velocity [m/s], its number.
    """
    tracks = snapshot.tracks
    which = np.flatnonzero(snapshot.confirmed)
    to_base = inverse(base.pose)
    at = np.array(compose(to_base, (person.x, person.y, 0.0))[:2])
    away = np.hypot(*(tracks.position[which] - at).T)
    if not len(which) or away.min() > 0.8:
        return (np.nan,) * 5
    i = int(which[away.argmin()])
    velocity = rotation(to_base[2]) @ np.array(person.velocity)
    return (
        float(away.min()),
        float(np.hypot(*(tracks.velocity[i] - velocity))),
        float(tracks.moving[i]),
        float(np.sqrt(np.linalg.eigvalsh(tracks.body_covariance[i, 2:, 2:])[-1])),
        float(tracks.id[i]),
    )


def gaps(poses: np.ndarray, people: np.ndarray, p: SeparationParameters) -> np.ndarray:
    """(S,) [m] between the robot's outline and the person's body; negative: they overlap."""
    shape = make_shape(replace(p, footprint_padding=0.0))
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    offset = people - poses[:, :2]
    x, y = c * offset[:, 0] + s * offset[:, 1], c * offset[:, 1] - s * offset[:, 0]
    return shape.distance(np.stack([x, y], axis=1)) - BODY


def undisturbed(crossing: Crossing, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Poses (S, 3) of a robot that nobody slows down, and people (S, 2)."""
    exact = replace(DRIVE, odometry_noise=0.0)
    base, walker = Base(exact, crossing.start, np.random.default_rng(0)), Walker(crossing.person)
    poses, people = [], []
    for step in range(1, round(seconds / STEP) + 1):
        now = (step - 1) * STEP
        base.command(crossing.command if now >= SETTLE else Twist(), now)
        base.accept(*base.next(now, STEP), STEP)
        poses.append(base.pose)
        state = walker.at(step * STEP)
        people.append((state.x, state.y))
    return np.array(poses), np.array(people)
