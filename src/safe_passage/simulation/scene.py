"""A world, a robot and people as a MuJoCo model: what can be drawn and what rays can hit.

Nothing here has dynamics: robot and people are put where they are, MuJoCo draws and casts rays.
Frame: map.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import mujoco
import numpy as np

from safe_passage.core.geometry import Pose
from safe_passage.simulation.arms import PREFIX
from safe_passage.simulation.painter import Painter
from safe_passage.simulation.people_assets import BodyMesh
from safe_passage.simulation.robots import CameraModel, LidarModel, Robot
from safe_passage.simulation.scene_model import (
    HIDDEN,
    HIGH,
    LOW,
    LOW_TOP,
    PEOPLE,
    build_model,
    quaternion,
)
from safe_passage.simulation.walkers import PersonState
from safe_passage.simulation.worlds import World


@dataclass(frozen=True)
class Hits:
    """What rays met first."""

    distances: np.ndarray  # (N,) [m], inf: nothing
    persons: np.ndarray  # (N,) int, index of the person met, -1: none


class Scene:
    """The MuJoCo model and its drawing context.

    Args:
        world: what stands still.
        robot: its body and cameras.
        bodies: of the people, in the order of `place_people`.

    Raises:
        ImportError, RuntimeError: MuJoCo or EGL is missing. InputError: the arm's URDF is.
    """

    def __init__(self, world: World, robot: Robot, bodies: Sequence[BodyMesh]) -> None:
        self.world, self.robot, self.bodies = world, robot, tuple(bodies)
        self.model, self.joint_names = build_model(world, robot, self.bodies)
        self.data = mujoco.MjData(self.model)
        self._joints = [self.model.joint(PREFIX + name).qposadr[0] for name in self.joint_names]
        self._robot = self.model.body("robot").id
        self._poses = [
            [self.model.geom(f"person{i}_pose{k}").id for k in range(len(body.vertices))]
            for i, body in enumerate(self.bodies)
        ]
        self._person_of_geom = np.full(self.model.ngeom + 1, -1)  # the last: no geom
        for i, geoms in enumerate(self._poses):
            self._person_of_geom[geoms] = i
        self._painters: dict[str, Painter] = {}

    def place_robot(self, pose: Pose) -> None:
        """Put the robot's base_footprint at `pose`."""
        mocap = self.model.body_mocapid[self._robot]
        self.data.mocap_pos[mocap] = (pose[0], pose[1], 0.0)
        self.data.mocap_quat[mocap] = quaternion(pose[2])

    def place_arm(self, positions: np.ndarray) -> None:
        """Put the arm's joints at `positions` [rad], in the order of `joint_names`."""
        self.data.qpos[self._joints] = positions

    def place_people(self, states: Sequence[PersonState | None]) -> None:
        """Put everyone where it is, in its pose; None: it is not there."""
        for i, (state, body) in enumerate(zip(states, self.bodies)):
            self.model.geom_group[self._poses[i]] = HIDDEN
            if state is None:
                continue
            mocap = self.model.body_mocapid[self.model.body(f"person{i}").id]
            self.data.mocap_pos[mocap] = (state.x, state.y, 0.0)
            self.data.mocap_quat[mocap] = quaternion(state.yaw)
            shown = body.pose_of(state.stands, state.walked)
            self.model.geom_group[self._poses[i][shown]] = PEOPLE

    def settle(self) -> None:
        """Make what was placed known to rays and drawings."""
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)

    def cast(self, origin: np.ndarray, directions: np.ndarray, reach: float, low: bool) -> Hits:
        """First hits of rays from `origin` (3,) along unit `directions` (N, 3), up to `reach` [m].

        `low`: the rays stay below LOW_TOP: only what reaches down there is tried.
        """
        groups = np.zeros(6, np.uint8)
        groups[[LOW, PEOPLE] if low else [LOW, HIGH, PEOPLE]] = 1
        count = len(directions)
        geoms, distances = np.zeros(count, np.int32), np.zeros(count)
        mujoco.mj_multiRay(
            self.model,
            self.data,
            np.asarray(origin, float),
            np.ascontiguousarray(directions, float).ravel(),
            groups,
            1,
            self._robot,
            geoms,
            distances,
            None,
            count,
            reach,
        )
        met = (geoms >= 0) & (distances <= reach)  # MuJoCo leaves out whole geoms only
        return Hits(
            np.where(met, distances, np.inf), self._person_of_geom[np.where(met, geoms, -1)]
        )

    def scan(self, lidar: LidarModel, T_map_base: np.ndarray) -> Hits:
        """What the lidar's beams meet, without noise."""
        T = T_map_base @ lidar.pose_in_base()
        angles = lidar.angles()
        rays = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
        return self.cast(T[:3, 3], rays @ T[:3, :3].T, lidar.range_max, lidar.z < LOW_TOP)

    def render(self, camera: CameraModel) -> tuple[np.ndarray, np.ndarray]:
        """What a camera of the robot sees, without noise.

        Returns:
            bgr (H, W, 3) uint8; depth (H, W) float32 [m] along the optical axis.
        """
        if camera.name not in self._painters:
            self._painters[camera.name] = Painter(self.model, camera.width, camera.height)
        return self._painters[camera.name].paint(self.data, self.model.camera(camera.name).id)

    def close(self) -> None:
        """Free the drawing contexts."""
        for painter in self._painters.values():
            painter.close()
        self._painters.clear()
