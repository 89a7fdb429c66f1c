"""The simulator: a robot with its sensors among people in a world; time is its own.

Deterministic: the same world, robot, seed and commands give the same measurements, whichever
sensors are asked, in whatever order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

import numpy as np

from safe_passage.core.errors import InputError
from safe_passage.core.geometry import Pose, matrix, outline, placed
from safe_passage.simulation.drive import Base, Twist
from safe_passage.simulation.people_assets import list_people, load_person
from safe_passage.simulation.robots import CameraModel, LidarModel, Robot
from safe_passage.simulation.scene import Scene
from safe_passage.simulation.sensors import measured_colour, measured_depth, measured_ranges
from safe_passage.simulation.static_map import make_map
from safe_passage.simulation.walkers import PersonState, Walker
from safe_passage.simulation.worlds import PersonPlan, World


@dataclass(frozen=True)
class LidarScan:
    """One scan, and the truth about it."""

    ranges: np.ndarray  # (N,) float32 [m], inf: no return
    persons: np.ndarray  # (N,) int, index of the person that a beam met, -1: none
    exact: np.ndarray  # (N,) [m] without noise


@dataclass(frozen=True)
class CameraFrame:
    """One picture with depth, and the truth about it."""

    bgr: np.ndarray  # (H, W, 3) uint8
    depth: np.ndarray  # (H, W) float32 [m], NaN: no return
    exact: np.ndarray  # (H, W) float32 [m] without noise
    T_map_camera: np.ndarray  # (4, 4), optical frame


class Simulator:
    """Robot, people and sensors.

    Args:
        world: hall and, unless `people` is given, the people in it.
        robot: the machine.
        seed: of all noise.
        people: instead of the world's own.
        start: of the robot, instead of the world's own; frame map.

    Raises:
        InputError: the robot has a sensor that is not simulated.
    """

    STEP = 0.025  # [s]

    def __init__(
        self,
        world: World,
        robot: Robot,
        seed: int = 0,
        people: Sequence[PersonPlan] | None = None,
        start: Pose | None = None,
    ) -> None:
        if robot.scanners:
            scanners = ", ".join(scanner.name for scanner in robot.scanners)
            raise InputError(
                f"robot {robot.name}: turning scanners ({scanners}) are not simulated; "
                "play a scan of one: rosrun safe_passage replay_scan garage"
            )
        self.world, self.robot, self.seed = world, robot, seed
        plans = world.people if people is None else tuple(people)
        names = list_people()
        self.bodies = [load_person(p.body or names[i % len(names)]) for i, p in enumerate(plans)]
        self.scene = Scene(world, robot, self.bodies)
        self.map = make_map(world, robot.height)
        self._walkers = [Walker(plan) for plan in plans]
        self._outline = outline(np.array(robot.footprint), spacing=0.04)
        self._start = start or world.start
        self.restart()

    def restart(self) -> None:
        """Back to time 0 and the robot's start, its arm too."""
        rng = np.random.default_rng((self.seed, 1))
        self.base = Base(self.robot.drive, self._start, rng)
        self._arm = np.zeros(len(self.joint_names))
        if self.robot.arm and self.robot.arm.positions:
            self._arm[:] = self.robot.arm.positions
        self._steps, self._settled = 0, -1

    @property
    def time(self) -> float:
        """[s] since the start."""
        return self._steps * self.STEP

    def people(self) -> list[PersonState]:
        """Everyone now."""
        return [walker.at(self.time) for walker in self._walkers]

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Of the robot's arm, in the order of `arm_positions`; without an arm empty."""
        return self.scene.joint_names

    @property
    def arm_positions(self) -> np.ndarray:
        """(J,) [rad] of the arm's joints; to be set as a whole."""
        return self._arm.copy()

    @arm_positions.setter
    def arm_positions(self, positions: Sequence[float] | np.ndarray) -> None:
        wanted = np.array(positions, float)
        if wanted.shape != self._arm.shape or not np.isfinite(wanted).all():
            raise ValueError(f"arm positions {positions}: must be {len(self._arm)} finite angles")
        self._arm, self._settled = wanted, -1

    def command(self, twist: Twist) -> None:
        """Drive so, until another command or the drive's timeout."""
        self.base.command(twist, self.time)

    def step(self) -> None:
        """Go on by STEP; walls stop the robot, people walk on whatever happens."""
        pose, twist = self.base.next(self.time, self.STEP)
        if self.map.at(placed(self._outline, pose), outside=True).any():
            self.base.refuse()
        else:
            self.base.accept(pose, twist, self.STEP)
        self._steps += 1

    def scan(self, lidar: LidarModel) -> LidarScan:
        """What `lidar` measures now."""
        self._settle()
        hits = self.scene.scan(lidar, matrix(self.base.pose))
        ranges = measured_ranges(hits.distances, lidar, self._rng("scan", lidar.name))
        return LidarScan(ranges, hits.persons, hits.distances)

    def frame(self, camera: CameraModel) -> CameraFrame:
        """What `camera` measures now."""
        self._settle()
        bgr, exact = self.scene.render(camera)
        rng = self._rng("frame", camera.name)
        depth = measured_depth(exact, camera, rng)
        colour = measured_colour(bgr, camera, rng)
        return CameraFrame(colour, depth, exact, matrix(self.base.pose) @ camera.pose_in_base())

    def distance_to_people(self) -> float:
        """[m] from the robot's outline to the nearest person's middle; inf without people."""
        states = self.people()
        if not states:
            return math.inf
        points = placed(self._outline, self.base.pose)
        middles = np.array([(state.x, state.y) for state in states])
        return float(np.min(np.hypot(*(points[:, None] - middles).transpose(2, 0, 1))))

    def close(self) -> None:
        """Free what draws."""
        self.scene.close()

    def _settle(self) -> None:
        if self._settled != self._steps:
            self.scene.place_robot(self.base.pose)
            self.scene.place_people(self.people())
            self.scene.place_arm(self._arm)
            self.scene.settle()
            self._settled = self._steps

    def _rng(self, kind: str, name: str) -> np.random.Generator:
        label = int.from_bytes(f"{kind}/{name}".encode(), "little")
        return np.random.default_rng((self.seed, self._steps, label))
