"""Calibrations whose truth is known: an arm on a platform before a simulated depth camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from safe_passage.calibration import ArmView, temporal_median
from safe_passage.robot_model import RobotModel
from safe_passage.robot_model.surfaces import Surface, box
from safe_passage.simulation.arm_scene import FLOOR, ArmScene, Owner, at, looking_at, room
from safe_passage.simulation.robots import CameraModel

CAMERA = CameraModel(range_min=0.4)
IMAGES = 11  # of which the median is taken
HELD_OUT = 5  # poses that only judge the result
LEAST_SEEN = 0.03  # share of the picture that the arm covers in a pose one would choose


@dataclass(frozen=True)
class Setup:
    """One camera before one arm."""

    views: list[ArmView]
    held_out: list[ArmView]
    T_root_camera: np.ndarray  # (4, 4) the truth


class Trials:
    """Makes setups by number; frames: the arm's root, the camera's optical one."""

    def __init__(self, model: RobotModel, seed: int) -> None:
        self.model, self._seed = model, seed
        self.scene = ArmScene(model, CAMERA, _room())
        self._limits = {j.name: j.limits for j in model.joints if j.name in model.movable}

    def setup(self, number: int, poses: int) -> Setup:
        """`poses` to calibrate by, and others to judge by."""
        rng = np.random.default_rng((self._seed, number))
        azimuth = rng.uniform(-0.3, 1.8)  # into the corner of the two walls
        distance, height = rng.uniform(1.2, 1.8), rng.uniform(0.5, 1.3)
        eye = np.array([distance * np.cos(azimuth), distance * np.sin(azimuth), height])
        T = looking_at(eye, np.array([0.0, 0.0, 0.5]) + rng.uniform(-0.1, 0.1, 3))
        chosen = [self._pose(rng, T) for _ in range(poses)]
        others = [self._pose(rng, T) for _ in range(HELD_OUT)]
        seen = [self._seen(q, T, (number, i)) for i, q in enumerate([*chosen, *others])]
        return Setup(seen[:poses], seen[poses:], T)

    def guess(self, number: int, T: np.ndarray, translation: float, rotation: float) -> np.ndarray:
        """T (4, 4) off by `translation` [m] and `rotation` [rad], in any directions."""
        rng = np.random.default_rng((self._seed, number, 99))
        axes = rng.normal(size=(2, 3))
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        off = T.copy()
        off[:3, :3] = T[:3, :3] @ Rotation.from_rotvec(rotation * axes[0]).as_matrix()
        off[:3, 3] += translation * axes[1]
        return off

    def _pose(self, rng: np.random.Generator, T: np.ndarray) -> dict[str, float]:
        """Joint positions with the arm above the platform, and well in the picture."""
        for _ in range(1000):
            q = {name: 0.85 * rng.uniform(*limits) for name, limits in self._limits.items()}
            poses = self.model.poses(q)
            low = min(
                surface.moved(poses[name]).vertices[:, 2].min()
                for name, surface in list(self.model.links.items())[2:]
                if len(surface.faces)
            )
            if low < 0.1:
                continue
            _, owner = self.scene.exact(np.linalg.inv(T), q)
            if (owner == Owner.ROBOT).mean() > LEAST_SEEN:
                return q
        raise RuntimeError("no pose of the arm is well in the picture")

    def _seen(self, q: dict[str, float], T: np.ndarray, key: tuple[int, int]) -> ArmView:
        depth, owner = self.scene.exact(np.linalg.inv(T), q)
        images = [
            self.scene.measured(depth, owner, (self._seed, *key, i)).depth for i in range(IMAGES)
        ]
        return ArmView(temporal_median(images, 0.5), q)


def errors(T: np.ndarray, truth: np.ndarray) -> tuple[float, float]:
    """[m] and [rad] between two poses."""
    turn = Rotation.from_matrix(truth[:3, :3].T @ T[:3, :3]).magnitude()
    return float(np.linalg.norm(T[:3, 3] - truth[:3, 3])), float(turn)


def _room() -> list[Surface]:
    """Floor, two walls, the platform under the arm."""
    return [
        *room(),
        box(np.array([0.9, 0.6, -FLOOR])).moved(at(0.2, 0.0, 0.5 * FLOOR)),
    ]
