"""The people of the simulated warehouse: clothed bodies that stand and walk.

`list_people()` names them, `load_person(name)` gives one. They are made by
`assets/people/make_people.py` and stored beside this module.

Frame of every pose: metres, +x forward, +y left, +z up; the origin is on the floor under the
pelvis, the soles of the shoes stand on z = 0. All poses share faces, texture coordinates and
texture, so that a pose is but another array of vertices. Pose 0 stands, the others are phases of
the walk: at phase 0 the left heel strikes, at 0.5 the right one. A body that moves forward by
`stride_m` while its poses go once through the cycle does not slip on its feet.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from safe_passage.core.errors import InputError

FOLDER = Path(__file__).with_name("people")


@dataclass(frozen=True)
class BodyMesh:
    """One person in all poses; P poses, V vertices, F faces, T texture points, R regions."""

    name: str
    vertices: np.ndarray  # (P, V, 3) float32 [m]
    faces: np.ndarray  # (F, 3) int32, counter-clockwise seen from outside
    texcoords: np.ndarray  # (T, 2) float32 in [0, 1]: (u, v) = share of texture columns, rows
    face_texcoords: np.ndarray  # (F, 3) int32 into texcoords, one for each corner
    texture: np.ndarray  # (H, W, 3) uint8 RGB; v = 0 is its first row, as in MuJoCo's Texture.data
    face_regions: np.ndarray  # (F,) uint8 into region_names and palette
    region_names: tuple[str, ...]  # head, hair, helmet, skin (hands, arms), jacket, trousers, shoes
    palette: np.ndarray  # (R, 3) uint8 RGB, mean colour of every region: for use without texture
    phases: np.ndarray  # (P,) float64, share of the gait cycle in [0, 1); NaN = the standing pose
    stride_m: float  # [m] walked in one cycle, which is two steps
    height_m: float  # [m] standing, shoes and hair or helmet included

    @property
    def standing(self) -> np.ndarray:
        """Vertices (V, 3) [m] of the standing pose."""
        return self.vertices[0]

    def vertices_of(self, region: str) -> np.ndarray:
        """Indices (N,) of the vertices of a region's faces."""
        return np.unique(self.faces[self.face_regions == self.region_names.index(region)])

    def pose_of(self, stands: bool, walked: float) -> int:
        """Index of the pose of a body that stands, or has come `walked` [m] along its path."""
        return 0 if stands else self.pose_at(walked)

    def pose_at(self, walked: float) -> int:
        """Index of the walking pose for a body that has come `walked` [m] along its path."""
        phase = (walked / self.stride_m) % 1.0
        gap = np.abs(self.phases - phase)
        return int(np.nanargmin(np.minimum(gap, 1.0 - gap)))


def list_people() -> tuple[str, ...]:
    """Names of everyone there is, sorted."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.npz")))


def load_person(name: str) -> BodyMesh:
    """One of `list_people()`.

    Raises:
        InputError: there is no person of that name.
    """
    path = FOLDER / f"{name}.npz"
    if name not in list_people():
        raise InputError(f"no person {name!r} in {FOLDER}; there are {', '.join(list_people())}")
    with np.load(path) as data:
        return BodyMesh(
            name=name,
            vertices=(data["vertices"] * float(data["step_m"])).astype(np.float32),
            faces=data["faces"].astype(np.int32),
            texcoords=data["texcoords"].astype(np.float32),
            face_texcoords=data["face_texcoords"].astype(np.int32),
            texture=data["texture"],
            face_regions=data["face_regions"],
            region_names=tuple(str(region) for region in data["region_names"]),
            palette=data["palette"],
            phases=data["phases"],
            stride_m=float(data["stride_m"]),
            height_m=float(data["height_m"]),
        )
