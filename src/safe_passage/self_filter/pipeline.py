"""The self-filter: joint states at the stamp -> poses -> drawn robot -> pixels -> depth without."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from safe_passage.core.depth_image import metres, without
from safe_passage.core.errors import InputError, ParameterError
from safe_passage.robot_model import DepthRenderer, JointHistory, PinholeCamera, RobotModel
from safe_passage.self_filter.parameters import SelfFilterParameters
from safe_passage.self_filter.removal import inside_robot, slivers
from safe_passage.self_filter.sweep import Sweep, positions_around

DRAWN_BY = ("padding", "link_padding", "excluded_links", "mesh_resolution")  # the surfaces
LEAST_SPACING = 0.01  # [m] of poses on the way of a robot that is hardly padded


@dataclass(frozen=True)
class Filtered:
    """A depth image without the robot."""

    image: np.ndarray  # (H, W), as it came: uint16 [mm] or float32 [m]
    depth: np.ndarray  # (H, W) float32 [m], NaN = none or robot
    removed: np.ndarray  # (H, W) bool
    front: np.ndarray  # (H, W) float32 [m] nearest surface of the padded robot; inf: none
    camera: PinholeCamera

    def cloud(self) -> np.ndarray:
        """Points (N, 3) [m] of what remains, optical frame."""
        return self.camera.points(self.depth)


class SelfFilter:
    """Takes one robot out of one camera's images. One thread at a time.

    Raises:
        ParameterError: names a link in the parameters that the robot has not.
        InputError: there is nothing to draw, or no off-screen OpenGL.
    """

    def __init__(
        self, model: RobotModel, camera: PinholeCamera, parameters: SelfFilterParameters
    ) -> None:
        self._model, self._camera, self._joints = model, camera, model.movable
        self._p = parameters
        self._sweep, self._renderer = self._prepared()

    def tune(self, parameters: SelfFilterParameters) -> None:
        """Other parameters from the next image on; raises as when it is made."""
        old, self._p = self._p, parameters
        if any(getattr(old, name) != getattr(parameters, name) for name in DRAWN_BY):
            self._renderer.close()
            self._sweep, self._renderer = self._prepared()

    def _prepared(self) -> tuple[Sweep, DepthRenderer]:
        """The robot, ready to be moved and drawn."""
        p, model = self._p, self._model
        for name in (*p.excluded_links, *p.link_padding):
            if name not in model.links:
                raise ParameterError(f"link {name}: the robot {model.name} has none of this name")
        links = tuple(
            name
            for name, surface in model.links.items()
            if len(surface.faces) and name not in p.excluded_links
        )
        if not links:
            raise InputError(f"robot {model.name}: no link is left that has a surface")
        surfaces = []
        for name in links:
            coarse, moved = model.links[name].simplified(p.mesh_resolution)
            surfaces.append(coarse.inflated(p.link_padding.get(name, p.padding) + moved))
        least = min([p.padding, *p.link_padding.values()])
        sweep = Sweep(model, links, max(least, LEAST_SPACING))
        return sweep, DepthRenderer(surfaces, self._camera)

    def joint_history(self) -> JointHistory:
        """To be filled with the robot's joint states."""
        p = self._p
        return JointHistory(tolerance=p.joint_tolerance, max_gap=p.joint_gap)

    def filter(
        self, image: np.ndarray, stamp: float, joints: JointHistory, T_camera_root: np.ndarray
    ) -> Filtered:
        """One image without the robot.

        Args:
            image: (height, width) uint16 [mm] or float32 [m].
            stamp: [s] of the image.
            joints: positions until about the stamp.
            T_camera_root: (4, 4) robot's root in the camera's optical frame at the stamp.

        Raises:
            InputError: the image has not the camera's size, or a joint's position is not known.
                There is no image then: one with the robot in it would pass for one without.
        """
        depth = metres(image)
        if depth.shape != (self._camera.height, self._camera.width):
            raise InputError(
                f"depth image {depth.shape[1]} x {depth.shape[0]}: the camera has "
                f"{self._camera.width} x {self._camera.height}"
            )
        if not np.isfinite(T_camera_root).all():
            raise InputError("the robot's pose in the camera's frame is not finite")
        stations = positions_around(joints, self._joints, stamp, self._p.time_uncertainty)
        poses = T_camera_root @ self._sweep.poses(stations)
        front, back = self._renderer.depths(poses)
        removed = inside_robot(depth, front, back, self._p)
        removed |= slivers(depth, removed, front, self._p)
        clear = np.where(removed, np.float32(np.nan), depth)
        return Filtered(without(image, removed), clear, removed, front, self._camera)

    def close(self) -> None:
        """Give the graphics memory back."""
        self._renderer.close()
