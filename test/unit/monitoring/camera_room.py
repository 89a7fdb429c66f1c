"""Clouds of a depth camera in a room, by ray casting."""

import numpy as np
from safe_passage.core.geometry import matrix
from safe_passage.simulation.raycast import box, plane_z

ROOM = 5.0  # [m] to each wall
OPTICAL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


def camera(height: float = 1.5, pitch: float = 0.35) -> np.ndarray:
    """T_base_camera (4, 4), looking ahead and `pitch` [rad] down."""
    T = np.eye(4)
    c, s = np.cos(pitch), np.sin(pitch)
    T[:3, :3] = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]) @ OPTICAL
    T[2, 3] = height
    return T


def cloud(T_base_camera: np.ndarray, *boxes, pose=(0.0, 0.0, 0.0)) -> np.ndarray:
    """Points (N, 3) [m], optical frame, of floor, walls and boxes (low, high) [m] in odom.

    pose: of base in odom.
    """
    u, v = np.meshgrid(np.linspace(-0.55, 0.55, 90), np.linspace(-0.42, 0.42, 70))
    rays = np.stack([u, v, np.ones_like(u)], axis=-1).reshape(-1, 3)
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    T = matrix(pose) @ T_base_camera
    directions, origin = rays @ T[:3, :3].T, T[:3, 3]
    reach = plane_z(origin, directions, 0.0)
    far = ROOM + 0.1
    walls = [((x, -far, 0.0), (x + 0.1, far, 3.0)) for x in (-far, ROOM)]
    walls += [((-far, y, 0.0), (far, y + 0.1, 3.0)) for y in (-far, ROOM)]
    for low, high in (*walls, *boxes):
        reach = np.fmin(reach, box(origin, directions, np.array(low), np.array(high)))
    return (rays * reach[:, None])[np.isfinite(reach)].astype(np.float32)


def body(x: float, y: float, size: float = 0.4, height: float = 1.7, low: float = 0.0) -> tuple:
    """A box around x, y."""
    half = 0.5 * size
    return (x - half, y - half, low), (x + half, y + half, height)
