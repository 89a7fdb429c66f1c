"""What is really in a picture: each person's place, box and visible share."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

import cv2
import numpy as np

from safe_passage.simulation.people_assets import BodyMesh
from safe_passage.simulation.robots import CameraModel
from safe_passage.simulation.walkers import PersonState

NEAREST = 0.2  # [m] vertices nearer to the image plane have no pixel
TOLERANCE = 0.05  # [m] by which a surface may lie before a person without hiding it


@dataclass(frozen=True)
class PersonTruth:
    """A person in a camera's picture."""

    id: int  # index of the person
    body: str
    position: tuple[float, float]  # [m] on the floor, frame map
    velocity: tuple[float, float]  # [m/s]
    distance: float  # [m] over ground from the camera
    box: tuple[float, float, float, float]  # [px] x, y, width, height, may reach beyond the border
    visible: float  # share of its picture that nothing hides and that lies within the border


def persons_in_view(
    exact: np.ndarray,
    T_map_camera: np.ndarray,
    camera: CameraModel,
    bodies: tuple[BodyMesh, ...],
    states: Sequence[PersonState | None],
) -> list[PersonTruth]:
    """Everyone of whom anything lies within the picture's border.

    Args:
        exact: depth (H, W) [m] without noise.
        T_map_camera: (4, 4) of the optical frame.
        camera: that took it.
        bodies, states: of the people, in the same order; None: it is not there.
    """
    found = []
    for i, (body, state) in enumerate(zip(bodies, states)):
        if state is None:
            continue
        vertices = _in_camera(body, state, T_map_camera)
        if vertices[:, 2].min() < NEAREST:
            continue  # beside or behind the camera
        pixels = vertices[:, :2] / vertices[:, 2:] * camera.focal
        pixels += np.array(camera.intrinsics[2:])
        low, high = pixels.min(axis=0), pixels.max(axis=0)
        if (high < 0).any() or (low > (camera.width - 1, camera.height - 1)).any():
            continue
        share = _visible_share(pixels, body.faces, exact, vertices[:, 2].min())
        offset = np.array([state.x, state.y]) - T_map_camera[:2, 3]
        found.append(
            PersonTruth(
                i,
                body.name,
                (state.x, state.y),
                state.velocity,
                math.hypot(*offset),
                (*map(float, low), *map(float, high - low)),  # type: ignore[arg-type]
                share,
            )
        )
    return found


def _in_camera(body: BodyMesh, state: PersonState, T_map_camera: np.ndarray) -> np.ndarray:
    """Vertices (V, 3) [m] in the optical frame."""
    local = body.vertices[body.pose_of(state.stands, state.walked)]
    c, s = math.cos(state.yaw), math.sin(state.yaw)
    in_map = local @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + (state.x, state.y, 0.0)
    return (in_map - T_map_camera[:3, 3]) @ T_map_camera[:3, :3]


def _visible_share(
    pixels: np.ndarray, faces: np.ndarray, exact: np.ndarray, nearest: float
) -> float:
    """Of the silhouette's pixels, those within the border with nothing before them."""
    low = np.floor(pixels.min(axis=0)).astype(int) - 1
    size = np.ceil(pixels.max(axis=0)).astype(int) + 2 - low
    silhouette = np.zeros((int(size[1]), int(size[0])), np.uint8)
    corners = np.rint(pixels - low).astype(np.int32)
    for face in corners[faces]:
        cv2.fillConvexPoly(silhouette, face, 1)
    height, width = exact.shape
    top, left = max(low[1], 0), max(low[0], 0)
    bottom, right = min(low[1] + size[1], height), min(low[0] + size[0], width)
    if bottom <= top or right <= left:
        return 0.0
    part = silhouette[top - low[1] : bottom - low[1], left - low[0] : right - low[0]].astype(bool)
    in_front = exact[top:bottom, left:right] < nearest - TOLERANCE
    return float((part & ~in_front).sum() / max(int(silhouette.sum()), 1))
