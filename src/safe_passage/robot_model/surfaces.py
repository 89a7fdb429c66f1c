"""Triangles of a link: meshes from files, primitives, and what padding makes of them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from safe_passage.core.errors import InputError

ROUND = 48  # corners of a circle
SHARPEST = 0.35  # a corner's offset is 1 / 0.35 of the padding at most: a needle does not explode
FORMATS = (".stl", ".dae", ".obj")


@dataclass(frozen=True)
class Surface:
    """A closed surface; V corners, F triangles."""

    vertices: np.ndarray  # (V, 3) float64 [m]
    faces: np.ndarray  # (F, 3) int32, counter-clockwise seen from outside

    def moved(self, T: np.ndarray) -> Surface:
        """In the parent's frame: T (4, 4)."""
        return Surface(self.vertices @ T[:3, :3].T + T[:3, 3], self.faces)

    def inflated(self, padding: float) -> Surface:
        """Every face moved outwards by `padding` [m]; a corner as far as its faces need."""
        if padding == 0.0 or not len(self.faces):
            return self
        a, b, c = (self.vertices[self.faces[:, i]] for i in range(3))
        normals = np.cross(b - a, c - a)
        size = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = np.divide(normals, size, out=np.zeros_like(normals), where=size > 0.0)
        outwards = np.zeros_like(self.vertices)
        for i in range(3):  # weighted by the angle at the corner, so that tessellation matters not
            one, two = (self.vertices[self.faces[:, (i + k) % 3]] for k in (1, 2))
            at = self.vertices[self.faces[:, i]]
            angle = _angles(one - at, two - at)
            np.add.at(outwards, self.faces[:, i], angle[:, None] * normals)
        size = np.linalg.norm(outwards, axis=1, keepdims=True)
        outwards = np.divide(outwards, size, out=np.zeros_like(outwards), where=size > 1e-12)
        least = np.ones(len(self.vertices))
        for i in range(3):
            seen = np.einsum("ij,ij->i", outwards[self.faces[:, i]], normals)
            np.minimum.at(least, self.faces[:, i], np.where(size_of(normals) > 0.5, seen, 1.0))
        reach = padding / np.maximum(least, SHARPEST)
        return Surface(self.vertices + reach[:, None] * outwards, self.faces)

    def simplified(self, cell: float) -> tuple[Surface, float]:
        """With one corner a cell of `cell` [m] edge, and by how much [m] the surface moved.

        No point of a triangle moves farther than the corners do, so that inflating by this
        distance covers the surface it was made of.
        """
        if cell <= 0.0 or not len(self.faces):
            return self, 0.0
        _, which, count = np.unique(
            np.floor(self.vertices / cell), axis=0, return_inverse=True, return_counts=True
        )
        which = which.reshape(-1)
        merged = np.zeros((len(count), 3))
        np.add.at(merged, which, self.vertices)
        merged /= count[:, None]
        faces = which[self.faces].astype(np.int32)
        whole = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
        return Surface(merged, faces[whole]), float(size_of(merged[which] - self.vertices).max())


def joined(surfaces: list[Surface]) -> Surface:
    """All of them as one."""
    starts = np.cumsum([0] + [len(one.vertices) for one in surfaces])
    faces = [one.faces + start for one, start in zip(surfaces, starts)]
    empty = Surface(np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    if not surfaces:
        return empty
    return Surface(np.concatenate([s.vertices for s in surfaces]), np.concatenate(faces))


def size_of(vectors: np.ndarray) -> np.ndarray:
    """Lengths (N,) of `vectors` (N, 3)."""
    return np.linalg.norm(vectors, axis=1)


def load_mesh(path: Path, scale: np.ndarray | None = None) -> Surface:
    """Of an STL, DAE or OBJ file.

    A DAE's unit counts, its up axis does not: as rviz does.

    Raises:
        InputError: names the file and what is wrong with it.
    """
    if path.suffix.lower() not in FORMATS:
        raise InputError(f"{path}: {path.suffix!r} is not one of {', '.join(FORMATS)}")
    try:
        scene = trimesh.load_scene(str(path), process=False)
        unit = 1.0
        if path.suffix.lower() == ".dae" and scene.units:
            unit = trimesh.units.unit_conversion(scene.units, "meters")
        mesh = scene.to_mesh()
    except Exception as error:  # trimesh passes on whatever its parsers raise
        raise InputError(f"{path}: cannot be read ({error})") from None
    if not len(mesh.faces):
        raise InputError(f"{path}: there are no triangles in it")
    vertices, faces = np.asarray(mesh.vertices, float), np.asarray(mesh.faces)
    if vertices.shape[1:] != (3,) or not np.isfinite(vertices).all():
        raise InputError(f"{path}: its corners are not x, y, z")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise InputError(f"{path}: a triangle's corner is not in it")
    size = unit * (np.ones(3) if scale is None else np.asarray(scale, float))
    return _merged(vertices * size, faces, bool(np.prod(size) < 0))


def box(size: np.ndarray) -> Surface:
    """Edges [m] of a box around the origin."""
    return _of(trimesh.creation.box(extents=size))


def cylinder(radius: float, length: float) -> Surface:
    """[m], along z, around the origin. Its faces lie outside of the true one."""
    outside = radius / np.cos(np.pi / ROUND)
    return _of(trimesh.creation.cylinder(radius=outside, height=length, sections=ROUND))


def sphere(radius: float) -> Surface:
    """[m] around the origin."""
    return _of(trimesh.creation.icosphere(subdivisions=3, radius=1.005 * radius))


def _of(mesh: trimesh.Trimesh) -> Surface:
    return Surface(np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int32))


def _merged(vertices: np.ndarray, faces: np.ndarray, mirrored: bool) -> Surface:
    """Corners at the same place are one: files split them where colour or normal differ."""
    _, first, which = np.unique(
        np.round(vertices, 6), axis=0, return_index=True, return_inverse=True
    )
    faces = which.reshape(-1)[faces].astype(np.int32)
    whole = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    faces = faces[whole]
    return Surface(vertices[first], faces[:, ::-1].copy() if mirrored else faces)


def _angles(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    cross, dot = size_of(np.cross(a, b)), np.einsum("ij,ij->i", a, b)
    return np.arctan2(cross, dot)
