"""A small arm of boxes before a camera, with truth: of the calibration's tests."""

from __future__ import annotations

import numpy as np
from safe_passage.robot_model import PinholeCamera
from safe_passage.simulation.arm_scene import looking_at
from scipy.spatial.transform import Rotation

ARM = """<robot name="arm">
  <link name="foot"><visual><geometry><box size="0.3 0.2 0.1"/></geometry></visual></link>
  <link name="upper">
    <visual><origin xyz="0 0 0.25"/><geometry><box size="0.12 0.16 0.5"/></geometry></visual>
  </link>
  <link name="fore">
    <visual><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.1 0.14"/></geometry></visual>
  </link>
  <joint name="a" type="continuous">
    <parent link="foot"/><child link="upper"/><axis xyz="0 0 1"/></joint>
  <joint name="b" type="continuous"><parent link="upper"/><child link="fore"/>
    <origin xyz="0 0 0.5"/><axis xyz="0 1 0"/></joint>
</robot>"""
POSES = [(0.2, -0.4), (1.6, 0.7), (-1.2, -1.0), (0.9, 0.3), (-0.4, 0.5)]  # [rad] of a, b
CAMERA = PinholeCamera(320, 240, 260.0, 260.0, 159.5, 119.5)
T_ROOT_CAMERA = looking_at(np.array([1.2, 0.5, 0.9]), np.array([0.0, 0.0, 0.35]))


def off(T: np.ndarray, translation: float, degrees: float) -> np.ndarray:
    """T (4, 4) off by so much [m], [deg]."""
    guess = T.copy()
    turn = Rotation.from_rotvec(np.radians(degrees) * np.array([0.6, 0.8, 0.0]))
    guess[:3, :3] = T[:3, :3] @ turn.as_matrix()
    guess[:3, 3] += translation * np.array([0.0, 0.6, 0.8])
    return guess
