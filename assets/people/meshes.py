"""Small mesh tools: cut, cap, smooth, thin out."""

from __future__ import annotations

from dataclasses import dataclass, replace

import fast_simplification
import numpy as np
import trimesh
from scipy.sparse import coo_matrix, diags
from scipy.spatial import cKDTree


@dataclass(frozen=True)
class Part:
    """A piece of the clothed figure in rest pose: a garment, the head, a hand, a shoe."""

    region: str
    vertices: np.ndarray  # (V, 3) [m]
    faces: np.ndarray  # (F, 3)
    weights: np.ndarray  # (V, B)

    def normals(self) -> np.ndarray:
        """(V, 3) unit normals."""
        mesh = trimesh.Trimesh(self.vertices, self.faces, process=False)
        return np.array(mesh.vertex_normals)


def compact(part: Part) -> Part:
    """Without the vertices that no face uses."""
    used, faces = np.unique(part.faces, return_inverse=True)
    return replace(
        part,
        vertices=part.vertices[used],
        faces=faces.reshape(-1, 3),
        weights=part.weights[used],
    )


def cut(part: Part, origin: np.ndarray, keep: np.ndarray) -> Part:
    """What lies on the side of the plane through `origin` to which `keep` points; left open."""
    vertices, faces, _ = trimesh.intersections.slice_faces_plane(
        part.vertices, part.faces, plane_normal=keep, plane_origin=origin
    )
    weights = borrowed_weights(vertices, part.vertices, part.weights)
    return joined(part.region, [Part(part.region, vertices, faces, weights)])


def joined(region: str, parts: list[Part]) -> Part:
    """One part of several; vertices at the same place become one."""
    vertices = np.concatenate([p.vertices for p in parts])
    weights = np.concatenate([p.weights for p in parts])
    offsets = np.cumsum([0] + [len(p.vertices) for p in parts[:-1]])
    faces = np.concatenate([p.faces + o for p, o in zip(parts, offsets)])
    _, first, same = np.unique(
        np.round(vertices, 5), axis=0, return_index=True, return_inverse=True
    )
    faces = same.reshape(-1)[faces]
    flat = (
        (faces[:, 0] == faces[:, 1]) | (faces[:, 1] == faces[:, 2]) | (faces[:, 2] == faces[:, 0])
    )
    return compact(Part(region, vertices[first], faces[~flat], weights[first]))


def borrowed_weights(points: np.ndarray, near: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Skinning weights (N, B) of `points` from the three nearest vertices of a skinned mesh."""
    distance, index = cKDTree(near).query(points, k=3)
    share = 1.0 / (distance + 1e-6)
    share /= share.sum(axis=1, keepdims=True)
    return np.einsum("nk,nkb->nb", share, weights[index])


def smooth(vertices: np.ndarray, faces: np.ndarray, rounds: int, strength: float) -> np.ndarray:
    """Laplacian smoothing; open borders stay where they are."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    both = np.concatenate([edges, edges[:, ::-1]])
    n = len(vertices)
    adjacency = coo_matrix((np.ones(len(both)), (both[:, 0], both[:, 1])), shape=(n, n)).tocsr()
    border = np.array((adjacency == 1).sum(axis=1)).ravel() > 0
    adjacency.data[:] = 1.0
    mean = diags(1.0 / np.maximum(np.array(adjacency.sum(axis=1)).ravel(), 1.0)) @ adjacency
    out = vertices.copy()
    for _ in range(rounds):
        moved = out + strength * (mean @ out - out)
        out = np.where(border[:, None], out, moved)
    return out


def border_loops(faces: np.ndarray) -> list[np.ndarray]:
    """Open borders as rings of vertex indices, in the faces' direction."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    present = {tuple(e) for e in edges.tolist()}
    after = {a: b for a, b in present if (b, a) not in present}
    loops = []
    while after:
        start, at = after.popitem()
        ring = [start]
        while at != start and at in after:
            ring.append(at)
            at = after.pop(at)
        loops.append(np.array(ring))
    return loops


def capped(part: Part) -> Part:
    """Closed: every open border is filled by a fan to its middle."""
    vertices, weights, faces = [part.vertices], [part.weights], [part.faces]
    n = len(part.vertices)
    for ring in border_loops(part.faces):
        vertices.append(part.vertices[ring].mean(axis=0, keepdims=True))
        weights.append(part.weights[ring].mean(axis=0, keepdims=True))
        faces.append(np.stack([np.roll(ring, -1), ring, np.full(len(ring), n)], axis=1))
        n += 1
    return Part(
        part.region, np.concatenate(vertices), np.concatenate(faces), np.concatenate(weights)
    )


def extruded(part: Part, ring: np.ndarray, places: np.ndarray) -> Part:
    """With a collar of faces from an open border `ring` to new `places` (one a ring vertex)."""
    n = len(part.vertices)
    new = np.arange(n, n + len(ring))
    after, new_after = np.roll(ring, -1), np.roll(new, -1)
    collar = np.concatenate(
        [np.stack([after, ring, new], axis=1), np.stack([after, new, new_after], axis=1)]
    )
    return Part(
        part.region,
        np.concatenate([part.vertices, places]),
        np.concatenate([part.faces, collar]),
        np.concatenate([part.weights, part.weights[ring]]),
    )


def thinned(part: Part, faces: int) -> Part:
    """About `faces` faces, as like the part as quadric edge collapse makes it."""
    if len(part.faces) <= faces:
        return part
    vertices, kept = fast_simplification.simplify(
        part.vertices.astype(np.float64), part.faces.astype(np.int64), target_count=faces, agg=3.0
    )
    vertices, kept = np.asarray(vertices, float), np.asarray(kept, int)
    weights = borrowed_weights(vertices, part.vertices, part.weights)
    return compact(Part(part.region, vertices, kept, weights))
