"""The other way to take a robot out of depth images: is a point inside a link's box or sphere?

What robot_self_filter and robot_body_filter do with primitives; here to be compared with.
"""

from __future__ import annotations

import numpy as np

from safe_passage.robot_model import JointHistory, PinholeCamera, RobotModel


class BodyFilter:
    """Points inside of the links' padded boxes, or spheres, are the robot's.

    Args:
        shape: "box" (in the link's axes) or "sphere".
        padding: [m] around each.
    """

    def __init__(
        self, model: RobotModel, camera: PinholeCamera, shape: str, padding: float
    ) -> None:
        self._model, self._camera, self._box = model, camera, shape == "box"
        self._links = [name for name, surface in model.links.items() if len(surface.faces)]
        corners = [model.links[name].vertices for name in self._links]
        self._middles = [0.5 * (v.min(axis=0) + v.max(axis=0)) for v in corners]
        self._halves = [0.5 * np.ptp(v, axis=0) + padding for v in corners]
        self._radii = [
            np.linalg.norm(v - middle, axis=1).max() + padding
            for v, middle in zip(corners, self._middles)
        ]

    def removed(
        self, depth: np.ndarray, stamp: float, joints: JointHistory, T_camera_root: np.ndarray
    ) -> np.ndarray:
        """(H, W) bool, of a depth image [m] with NaN = none."""
        poses = self._model.poses(joints.at(stamp, self._model.movable))
        points = self._camera.points(depth).astype(np.float32)
        inside = np.zeros(len(points), bool)
        for i, name in enumerate(self._links):
            T = np.linalg.inv(T_camera_root @ poses[name]).astype(np.float32)
            local = points @ T[:3, :3].T + (T[:3, 3] - self._middles[i].astype(np.float32))
            if self._box:
                inside |= (np.abs(local) <= self._halves[i].astype(np.float32)).all(axis=1)
            else:
                inside |= np.einsum("ij,ij->i", local, local) <= self._radii[i] ** 2
        found = np.zeros(depth.shape, bool)
        found[np.isfinite(depth)] = inside
        return found
