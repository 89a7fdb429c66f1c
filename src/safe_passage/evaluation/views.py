"""Random views into a world: a robot somewhere, people before its camera, or nobody."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

import numpy as np

from safe_passage.core.geometry import Pose, compose, matrix
from safe_passage.simulation.people_assets import list_people, load_person
from safe_passage.simulation.robots import CameraModel, LidarModel, Robot
from safe_passage.simulation.scene import Hits, Scene
from safe_passage.simulation.sensors import measured_colour, measured_depth, measured_ranges
from safe_passage.simulation.static_map import make_map
from safe_passage.simulation.truth import PersonTruth, persons_in_view
from safe_passage.simulation.walkers import PersonState
from safe_passage.simulation.worlds import World

NEAREST, FARTHEST = 1.5, 8.0  # [m] people stand from the camera
EMPTY_SHARE = 0.25  # of the views, without people
VIEW = 3.0  # [m] before the robot, at least, are free, as where a robot drives
ROOM = 0.3  # [m] that a person has around it


@dataclass(frozen=True)
class View:
    """One moment of a robot: its camera's and its first lidar's measurements, and the truth."""

    bgr: np.ndarray  # (H, W, 3) uint8
    depth: np.ndarray  # (H, W) float32 [m], NaN: no return
    ranges: np.ndarray  # (N,) float32 [m], inf: no return
    beam_persons: np.ndarray  # (N,) int, index of the person that a beam met, -1: none
    persons: tuple[PersonTruth, ...]
    pose: Pose  # of the robot, frame map
    T_map_camera: np.ndarray  # (4, 4), optical frame


class ViewSampler:
    """Draws views; the same world, robot and seed give the same views.

    Args:
        world, robot: where and who looks; its first camera and lidar.
        most_people: in a view.
    """

    def __init__(self, world: World, robot: Robot, most_people: int = 3) -> None:
        self._world, self._robot, self._most = world, robot, most_people
        self._bodies = tuple(load_person(name) for name in list_people())
        self._scene = Scene(world, robot, self._bodies)
        self._map = make_map(world, robot.height)
        self._clearance = self._map.distances()

    @property
    def camera(self) -> CameraModel:
        return self._robot.cameras[0]

    @property
    def lidar(self) -> LidarModel:
        return self._robot.lidars[0]

    def draw(self, seed: int) -> View:
        """The view with this number."""
        rng = np.random.default_rng((seed, 3))
        camera, lidar = self.camera, self.lidar
        pose, states = self.draw_places(rng)
        hits = self.exact_scan(pose, states)
        bgr, exact = self._scene.render(camera)
        T_map_camera = matrix(pose) @ camera.pose_in_base()
        return View(
            measured_colour(bgr, camera, rng),
            measured_depth(exact, camera, rng),
            measured_ranges(hits.distances, lidar, rng),
            hits.persons,
            tuple(persons_in_view(exact, T_map_camera, camera, self._bodies, states)),
            pose,
            T_map_camera,
        )

    def draw_places(self, rng: np.random.Generator) -> tuple[Pose, list[PersonState | None]]:
        """The next place of the robot, frame map, and of everybody; None: it is not there."""
        pose = self._pose(rng)
        states: list[PersonState | None] = [None] * len(self._bodies)
        if rng.random() >= EMPTY_SHARE:
            chosen = rng.permutation(len(self._bodies))[: rng.integers(1, self._most + 1)]
            for i in chosen:
                states[i] = self._person(pose, states, rng)
        return pose, states

    def exact_scan(self, pose: Pose, states: Sequence[PersonState | None]) -> Hits:
        """What the lidar's beams meet with everything at these places."""
        self._place(pose, states)
        return self._scene.scan(self.lidar, matrix(pose))

    def _place(self, pose: Pose, states: Sequence[PersonState | None]) -> None:
        self._scene.place_robot(pose)
        self._scene.place_people(states)
        self._scene.settle()

    def room(self, x: float, y: float) -> float:
        """[m] from a place to the nearest thing of the map; 0 outside of it."""
        row, column, inside = self._map.cells(np.array([x, y]))
        return float(self._clearance[row, column]) if inside else 0.0

    def close(self) -> None:
        """Free what draws."""
        self._scene.close()

    def _pose(self, rng: np.random.Generator) -> Pose:
        half = 0.5 * np.array(self._world.size)
        while True:
            x, y = rng.uniform(-half, half)
            yaw = float(rng.uniform(-math.pi, math.pi))
            ahead = VIEW * np.linspace(0.1, 1.0, 10)
            open_view = all(
                self.room(x + d * math.cos(yaw), y + d * math.sin(yaw)) > 0.0 for d in ahead
            )
            if self.room(x, y) > 0.6 and open_view:
                return float(x), float(y), yaw

    def _person(
        self, pose: Pose, others: list[PersonState | None], rng: np.random.Generator
    ) -> PersonState | None:
        """Within the camera's angle of view, not in a shelf, not in another person."""
        camera = self.camera
        half = math.atan2(0.5 * camera.width, camera.focal)
        for _ in range(200):
            distance = math.sqrt(rng.uniform(NEAREST**2, FARTHEST**2))
            bearing = rng.uniform(-half, half)
            place = compose(
                compose(pose, (camera.x, camera.y, camera.yaw)),
                (distance * math.cos(bearing), distance * math.sin(bearing), 0.0),
            )
            apart = min(
                (math.hypot(place[0] - o.x, place[1] - o.y) for o in others if o), default=math.inf
            )
            if self.room(place[0], place[1]) < ROOM or apart < 0.6:
                continue
            yaw = float(rng.uniform(-math.pi, math.pi))
            speed = 0.0 if rng.random() < 0.5 else 1.1
            velocity = (speed * math.cos(yaw), speed * math.sin(yaw))
            return PersonState(place[0], place[1], yaw, velocity, float(rng.uniform(0.0, 10.0)))
        return None
