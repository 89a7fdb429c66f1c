"""An arm before a camera, with people and a room, whose every pixel is known to be whose."""

from __future__ import annotations

import enum
from dataclasses import dataclass, replace
from typing import Mapping, Sequence

import numpy as np

from safe_passage.robot_model import DepthRenderer, PinholeCamera, RobotModel
from safe_passage.robot_model.surfaces import Surface, box
from safe_passage.simulation.robots import CameraModel
from safe_passage.simulation.sensors import measured_depth

FLOOR = -0.7  # [m] under the arm's root: it stands on a platform
NO_SHADOW = 1e-3  # [m] baseline so short that the projector lights everything


class Owner(enum.IntEnum):
    """Whose a pixel is."""

    NOBODY = 0
    ROOM = 1
    PERSON = 2
    ROBOT = 3


@dataclass(frozen=True)
class View:
    """What the camera makes of the scene."""

    depth: np.ndarray  # (H, W) float32 [m], NaN = no return
    owner: np.ndarray  # (H, W) uint8, Owner; NOBODY where there is no return


class ArmScene:
    """Frames: the robot's root, z up; the camera's optical frame.

    Args:
        camera: how it sees; where it is comes with each picture.
        room: what stands still in the robot's root frame.
        people: bodies, each in its own frame.
    """

    def __init__(
        self,
        model: RobotModel,
        camera: CameraModel,
        room: Sequence[Surface],
        people: Sequence[Surface] = (),
    ) -> None:
        self.model, self._camera = model, camera
        self.pinhole = PinholeCamera(camera.width, camera.height, *camera.intrinsics)
        self._links = [name for name, surface in model.links.items() if len(surface.faces)]
        self._robot = DepthRenderer([model.links[name] for name in self._links], self.pinhole)
        self._room = DepthRenderer(room, self.pinhole)
        self._people = DepthRenderer(people, self.pinhole)
        self._pieces = len(room)

    def exact(
        self,
        T_camera_root: np.ndarray,
        positions: Mapping[str, float],
        T_root_people: np.ndarray | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Depth (H, W) float32 [m], inf = nothing, and whose it is (H, W) uint8, Owner.

        Args:
            T_root_people: (B, 4, 4) where the bodies are; nobody is there without.
        """
        poses = self.model.poses(positions)
        robot = np.array([[poses[name] for name in self._links]])
        layers = [np.full((self._camera.height, self._camera.width), np.inf, np.float32)]
        room = np.tile(T_camera_root, (1, self._pieces, 1, 1))
        layers.append(self._room.depths(room)[0])
        if T_root_people is None:
            layers.append(layers[0])
        else:
            layers.append(self._people.depths(T_camera_root @ T_root_people[None])[0])
        layers.append(self._robot.depths(T_camera_root @ robot)[0])
        stack = np.stack(layers)
        return stack.min(axis=0), stack.argmin(axis=0).astype(np.uint8)

    def measured(self, depth: np.ndarray, owner: np.ndarray, seed: Sequence[int]) -> View:
        """What the sensor makes of `exact`'s depth; a frayed pixel is whose depth it has."""
        seen = measured_depth(depth, self._camera, np.random.default_rng(seed))
        # The same draws on a picture in which the owner is written as depth tell whose it is.
        bare = replace(
            self._camera,
            disparity_noise=0.0,
            disparity_step=0.0,
            range_min=0.01,
            range_max=100.0,
            baseline=NO_SHADOW,
        )
        written = measured_depth(1.0 + owner, bare, np.random.default_rng(seed))
        whose = np.rint(np.nan_to_num(written, nan=1.0) - 1.0).astype(np.uint8)
        return View(seen, np.where(np.isfinite(seen), whose, np.uint8(Owner.NOBODY)))


def at(x: float, y: float, z: float) -> np.ndarray:
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T


def room() -> list[Surface]:
    """A floor and two walls."""
    return [
        box(np.array([12.0, 12.0, 0.1])).moved(at(0.0, 0.0, FLOOR - 0.05)),
        box(np.array([0.1, 12.0, 6.0])).moved(at(-2.5, 0.0, FLOOR + 3.0)),
        box(np.array([12.0, 0.1, 6.0])).moved(at(0.0, -2.5, FLOOR + 3.0)),
    ]


def looking_at(eye: np.ndarray, target: np.ndarray) -> np.ndarray:
    """T_root_camera (4, 4) of an upright camera at `eye` (3,) that looks at `target` (3,)."""
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    T = np.eye(4)
    T[:3, :3] = np.stack([right, np.cross(forward, right), forward], axis=1)
    T[:3, 3] = eye
    return T
