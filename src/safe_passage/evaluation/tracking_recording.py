"""Recordings of tracking scenarios: what the sensors measured, and the exact truth.

Kept on disk, because drawing them takes longer than tracking them.
"""

from __future__ import annotations

import hashlib
import math
import os
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Sequence

import numpy as np

from safe_passage.core.errors import InputError
from safe_passage.core.geometry import Pose, compose, inverse, matrix, rotation
from safe_passage.evaluation.parallel import Workers, run_jobs
from safe_passage.evaluation.tracking_scenarios import STEP, Lidar3D, TrackingScenario
from safe_passage.simulation import simulator as simulator_module
from safe_passage.simulation.robots import CameraModel
from safe_passage.simulation.simulator import CameraFrame, Simulator
from safe_passage.simulation.truth import persons_in_view

SCAN_STEPS = 4  # between two scans of a scanner: 12.5 Hz
SEEN_WITHIN = 0.3  # [s] beams that met a person count
SEEN_BEAMS = 3  # so many must have
SEEN_SHARE = 0.2  # of a person in a picture
PIXELS = 20000  # of a cloud
KEPT = 7 * 86400.0  # [s] that a recording stays in the cache unread
CACHE = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "safe_passage" / "tracking"


def _sources() -> bytes:
    """What a recording depends on besides its scenario."""
    folder = Path(simulator_module.__file__).parent
    files = [*sorted(folder.glob("*.py")), Path(__file__)]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).digest()


SOURCES = _sources()  # read now: a file that is edited later is not what this process runs


@dataclass(frozen=True)
class Raw:
    """One measurement as the sensor gives it."""

    sensor: str
    stamp: float  # [s]
    pose: Pose  # of base in the odometry's frame, by odometry
    data: np.ndarray  # ranges (N,) [m] of a lidar, or a camera's points (N, 3) [m] in its frame


@dataclass(frozen=True)
class Recording:
    """C cycles, P people; frame of the truth: the odometry's, as seen from the robot now."""

    scenario: TrackingScenario
    stamps: np.ndarray  # (C,) [s]
    poses: np.ndarray  # (C, 3) of base
    people: np.ndarray  # (C, P, 4) position [m] and velocity [m/s] over ground
    visible: np.ndarray  # (C, P) bool: enough of it was seen just now, within the tracker's reach
    moved: np.ndarray  # (C, P) bool: has begun to move
    raw: tuple[tuple[Raw, ...], ...]  # of each cycle, oldest first


def merged(recording: Recording, every: int) -> Recording:
    """The same with every `every` cycles put into one, for a tracker that runs more slowly."""
    last = slice(every - 1, None, every)
    ends = range(every, len(recording.raw) + 1, every)
    return replace(
        recording,
        stamps=recording.stamps[last],
        poses=recording.poses[last],
        people=recording.people[last],
        visible=recording.visible[last],
        moved=recording.moved[last],
        raw=tuple(sum(recording.raw[end - every : end], ()) for end in ends),
    )


class _TrackingSimulator(Simulator):
    STEP = STEP

    def place(self) -> None:
        """Put everything where it is now, for what casts its own rays."""
        self._settle()


def recordings(scenarios: Sequence[TrackingScenario], workers: Workers) -> list[Recording]:
    """Each scenario's recording, from the cache where it is there."""
    missing = [scenario for scenario in scenarios if not cache_file(scenario).exists()]
    if missing:
        run_jobs(_record_to_cache, missing, workers, "recording")
    return [load(scenario, cache_file(scenario)) for scenario in scenarios]


def record(scenario: TrackingScenario) -> Recording:
    """Simulate it."""
    recorder = _Recorder(scenario)
    try:
        return recorder.run()
    finally:
        recorder.simulator.close()


class _Recorder:
    def __init__(self, scenario: TrackingScenario) -> None:
        self.scenario = scenario
        self.simulator = _TrackingSimulator(
            scenario.world, scenario.robot, scenario.seed, scenario.people, scenario.start
        )
        self._walked_before = np.array([one.walked for one in self.simulator.people()])
        self._beams: list[tuple[float, np.ndarray]] = []  # [s], beams that met each person

    def run(self) -> Recording:
        scenario, simulator = self.scenario, self.simulator
        rows: list[tuple[Any, ...]] = []
        raw: list[tuple[Raw, ...]] = []
        pending: list[Raw] = []
        for step in range(1, round(scenario.seconds / STEP) + 1):
            if scenario.drives:
                simulator.command(scenario.twist_at(simulator.time))
            simulator.step()
            if simulator.base.bumped:
                raise InputError(f"{scenario.name}: the robot drives into something")
            pending += self._measurements(step)
            if step % self.scenario.cycle_steps == 0:
                rows.append((simulator.time, simulator.base.odometry, *self._truth()))
                raw.append(tuple(pending))
                pending = []
        stamps, poses, people, visible, moved = (np.array(column) for column in zip(*rows))
        return Recording(scenario, stamps, poses, people, visible, moved, tuple(raw))

    def _measurements(self, step: int) -> list[Raw]:
        """Scanners take turns; cameras look together, a step after a cycle."""
        simulator, robot, found = self.simulator, self.scenario.robot, []
        for i, lidar in enumerate(robot.lidars):
            if step % SCAN_STEPS == (SCAN_STEPS // 2 * i) % SCAN_STEPS:
                scan = simulator.scan(lidar)
                self._count(scan.persons)
                found.append(self._raw(lidar.name, scan.ranges))
        lidar3d = self.scenario.lidar3d
        if lidar3d and step % lidar3d.steps == 0:
            found.append(self._raw(lidar3d.name, self._turn(lidar3d)))
        if self.scenario.camera_rate and robot.cameras:
            every = round(1.0 / (self.scenario.camera_rate * STEP * len(robot.cameras)))
            if step % every == 1:  # one camera after the other
                camera = robot.cameras[step // every % len(robot.cameras)]
                frame = simulator.frame(camera)
                self._look(camera, frame)
                found.append(self._raw(camera.name, cloud(frame.depth, camera)))
        return found

    def _turn(self, lidar: Lidar3D) -> np.ndarray:
        """Ranges of all rings, inf: no return."""
        simulator = self.simulator
        simulator.place()
        T = matrix(simulator.base.pose) @ lidar.pose_in_base()
        rays = lidar.directions() @ T[:3, :3].T
        hits = simulator.scene.cast(T[:3, 3], rays, lidar.range_max, low=False)
        self._count(hits.persons)
        rng = np.random.default_rng((self.scenario.seed, round(simulator.time / STEP)))
        ranges = hits.distances + rng.normal(0.0, lidar.noise, len(rays))
        ranges[rng.random(len(rays)) < lidar.dropout] = np.inf
        return ranges.astype(np.float32)

    def _raw(self, sensor: str, data: np.ndarray) -> Raw:
        return Raw(sensor, self.simulator.time, self.simulator.base.odometry, data)

    def _count(self, persons: np.ndarray) -> None:
        met = np.bincount(persons[persons >= 0], minlength=len(self.scenario.people))
        self._beams.append((self.simulator.time, met))

    def _look(self, camera: CameraModel, frame: CameraFrame) -> None:
        simulator = self.simulator
        met = np.zeros(len(self.scenario.people), int)
        for person in persons_in_view(
            frame.exact, frame.T_map_camera, camera, tuple(simulator.bodies), simulator.people()
        ):
            near = person.distance <= camera.range_max
            met[person.id] = SEEN_BEAMS if near and person.visible >= SEEN_SHARE else 0
        self._beams.append((simulator.time, met))

    def _truth(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """People now: position and velocity, whether seen, whether they have moved."""
        simulator = self.simulator
        now = simulator.time
        self._beams = [one for one in self._beams if now - one[0] <= SEEN_WITHIN]
        states = simulator.people()
        to_base = inverse(simulator.base.pose)
        turn = rotation(simulator.base.odometry[2] + to_base[2])
        people = np.zeros((len(states), 4))
        near = np.zeros(len(states), bool)
        for i, state in enumerate(states):
            in_base = compose(to_base, (state.x, state.y, state.yaw))
            near[i] = max(abs(in_base[0]), abs(in_base[1])) < self.scenario.reach
            people[i, :2] = compose(simulator.base.odometry, in_base)[:2]
            people[i, 2:] = turn @ state.velocity
        met = np.sum([beams for _, beams in self._beams], axis=0, initial=0)
        seen = np.broadcast_to(met >= SEEN_BEAMS, near.shape) & near
        moved = np.array([state.walked for state in states]) != self._walked_before
        return people, seen, moved


def cloud(depth: np.ndarray, camera: CameraModel) -> np.ndarray:
    """Points (N, 3) float32 [m] of up to PIXELS evenly chosen pixels with depth, optical frame."""
    stride = max(1, math.ceil(math.sqrt(depth.size / PIXELS)))
    rows, columns = (np.arange(stride // 2, side, stride) for side in depth.shape)
    z = depth[np.ix_(rows, columns)]
    fx, fy, cx, cy = camera.intrinsics
    u, v = np.meshgrid(columns, rows)
    points = np.stack([(u - cx) / fx * z, (v - cy) / fy * z, z], axis=-1).reshape(-1, 3)
    return points[np.isfinite(points[:, 2])].astype(np.float32)


def cache_file(scenario: TrackingScenario) -> Path:
    """Where its recording is kept: another definition or simulator, another file."""
    digest = hashlib.sha256(SOURCES + repr(scenario).encode()).hexdigest()
    return CACHE / f"{scenario.name}_{scenario.seed}_{digest[:16]}.npz"


def _record_to_cache(scenario: TrackingScenario) -> None:
    save(record(scenario), cache_file(scenario))


def save(recording: Recording, file: Path) -> None:
    """Write it; all or nothing."""
    flat = [raw for cycle in recording.raw for raw in cycle]
    arrays = {f"data{i}": raw.data for i, raw in enumerate(flat)}
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_name(f".{os.getpid()}_{file.name}")
    np.savez(
        part,
        stamps=recording.stamps,
        poses=recording.poses,
        people=recording.people,
        visible=recording.visible,
        moved=recording.moved,
        per_cycle=np.array([len(cycle) for cycle in recording.raw]),
        raw_sensors=np.array([raw.sensor for raw in flat]),
        raw_stamps=np.array([raw.stamp for raw in flat]),
        raw_poses=np.array([raw.pose for raw in flat]),
        **arrays,
    )
    part.rename(file)
    for old in file.parent.glob("*.npz"):
        if time.time() - old.stat().st_atime > KEPT:
            old.unlink(missing_ok=True)


def load(scenario: TrackingScenario, file: Path) -> Recording:
    """Read what `save` wrote of this scenario."""
    with np.load(file) as data:
        truth = {key: data[key] for key in ("stamps", "poses", "people", "visible", "moved")}
        sensors, stamps = data["raw_sensors"], data["raw_stamps"]
        poses = data["raw_poses"]
        flat = [
            Raw(str(sensors[i]), float(stamps[i]), _pose(poses[i]), data[f"data{i}"])
            for i in range(len(sensors))
        ]
        ends = np.cumsum(data["per_cycle"])
    starts = ends - np.diff(ends, prepend=0)
    raw = tuple(tuple(flat[a:b]) for a, b in zip(starts, ends))
    return Recording(scenario, **truth, raw=raw)


def _pose(values: np.ndarray) -> Pose:
    return float(values[0]), float(values[1]), float(values[2])
