"""What of a posed robot's surface a camera sees: the reference cloud (paper 000, 2.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping

import numpy as np

from safe_passage.calibration.edges import away_from_edges
from safe_passage.robot_model import DepthRenderer, PinholeCamera, RobotModel

GRAZING = 0.17  # cosine under which a surface is seen that gives no reliable point


@dataclass(frozen=True)
class VisibleSurface:
    """N points of the surface, row by row of the picture; frame: the robot's root."""

    points: np.ndarray  # (N, 3) [m]
    normals: np.ndarray  # (N, 3) unit, towards the camera


class ArmSurface:
    """Samples the visible surface of a robot in any pose.

    Args:
        camera: the real one; every `step`th pixel of it is sampled each way.
        edge: [samples] beside a depth edge, a `jump` [m], that are not given as surface.
    """

    def __init__(
        self,
        model: RobotModel,
        camera: PinholeCamera,
        step: int = 1,
        edge: int = 0,
        jump: float = 0.04,
    ) -> None:
        self._edge, self._jump = edge, jump
        self._model = model
        self._links = [name for name, surface in model.links.items() if len(surface.faces)]
        self._camera = PinholeCamera(
            -(-camera.width // step),
            -(-camera.height // step),
            camera.fx / step,
            camera.fy / step,
            camera.cx / step,
            camera.cy / step,
        )
        self._renderer = DepthRenderer([model.links[n] for n in self._links], self._camera)

    @property
    def camera(self) -> PinholeCamera:
        """That samples it."""
        return self._camera

    def depth(self, positions: Mapping[str, float], T_root_camera: np.ndarray) -> np.ndarray:
        """(H, W) float32 [m] of the robot seen from there, +inf = nothing."""
        poses = self._model.poses(positions)
        T_camera_root = np.linalg.inv(T_root_camera)
        T = np.array([T_camera_root @ poses[name] for name in self._links])
        return self._renderer.depths(T[None])[0]

    def visible(self, positions: Mapping[str, float], T_root_camera: np.ndarray) -> VisibleSurface:
        """The surface at joint `positions` seen from `T_root_camera` (4, 4)."""
        depth = self.depth(positions, T_root_camera)
        points, normals = self._oriented(np.where(np.isfinite(depth), depth, np.nan))
        R, t = T_root_camera[:3, :3], T_root_camera[:3, 3]
        return VisibleSurface(points @ R.T + t, normals @ R.T)

    def close(self) -> None:
        """Give the graphics memory back."""
        self._renderer.close()

    def _oriented(self, depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points and normals (N, 3) in the camera's frame of what is not seen too obliquely."""
        camera = self._camera
        v, u = np.mgrid[0 : camera.height, 0 : camera.width]
        z = depth.astype(float)
        grid = np.stack(
            [(u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z], axis=-1
        )
        inner = grid[1:-1, 1:-1]
        across = grid[1:-1, 2:] - grid[1:-1, :-2]
        down = grid[2:, 1:-1] - grid[:-2, 1:-1]
        normals = np.cross(down, across)  # towards the camera: x right, y down, z forward
        with np.errstate(invalid="ignore", divide="ignore"):
            normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
            rays = inner / np.linalg.norm(inner, axis=-1, keepdims=True)
            facing = -np.einsum("ijk,ijk->ij", normals, rays)
        good = facing > GRAZING  # NaN, and depth jumps between links, are not
        good &= away_from_edges(depth, self._edge, self._jump)[1:-1, 1:-1]
        return inner[good], normals[good]
