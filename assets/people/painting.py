"""Paints the clothed rest figure: one small picture a person, front and back of every part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from bodies import Body
from clothes import hairiness, hem_z
from meshes import Part
from people import REFLECTIVE, Person
from scipy.ndimage import distance_transform_edt, gaussian_filter

PITCH = {"jacket": 0.0045, "trousers": 0.0045, "head": 0.0022, "hair": 0.006, "helmet": 0.006,
         "skin": 0.006, "shoes": 0.006}  # [m] a texel  # fmt: skip
WIDTH = 384  # [px] of the picture


@dataclass(frozen=True)
class Texels:
    """Where the texels of one side of one part lie on the figure."""

    places: np.ndarray  # (N, 3) [m] rest pose
    normals: np.ndarray  # (N, 3)
    hair: np.ndarray  # (N,) 1 where hair grows (head only)


def painted(
    parts: list[Part], body: Body, person: Person
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Texture and its coordinates.

    Returns:
        image (H, WIDTH, 3) uint8 RGB; texcoords (T, 2) in [0, 1] from the first row and column;
        corners (F, 3) int: the texcoord of every corner of the parts' faces, in their order.
    """
    jobs = []  # (part, faces of this side, is the front)
    for part in parts:
        front = _in_front(part)
        jobs += [(part, part.faces[front], True), (part, part.faces[~front], False)]
    sizes = [_size(part) for part, _, _ in jobs]
    corners_at, height = _packed(sizes)
    image = np.full((height, WIDTH, 3), 128.0)
    texcoords, faces_by_job, offset = [], [], 0
    for (part, faces, front), (width, tall), (u0, v0) in zip(jobs, sizes, corners_at):
        block = _paint_block(part, faces, front, body, person)
        image[v0 : v0 + tall, u0 : u0 + width] = block
        texcoords.append((_project(part, front) + np.array([u0, v0])) / [WIDTH, height])
        faces_by_job.append(faces + offset)
        offset += len(part.vertices)
    corners = []
    for i in range(0, len(jobs), 2):  # back into the order of the part's faces
        part = jobs[i][0]
        front = _in_front(part)
        both = np.empty_like(part.faces)
        both[front], both[~front] = faces_by_job[i], faces_by_job[i + 1]
        corners.append(both)
    picture = np.clip(image, 0, 255).astype(np.uint8)
    return picture, np.concatenate(texcoords), np.concatenate(corners)


def _in_front(part: Part) -> np.ndarray:
    """(F,) which faces take their colours from the front picture: those that look forward.

    On the head also where they lie counts: the jaw under an ear is hidden from behind.
    """
    corners = part.vertices[part.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    ahead = normals[:, 0] / np.maximum(np.linalg.norm(normals, axis=1), 1e-12)
    if part.region == "head":
        low, high = np.percentile(part.vertices[:, 0], [2, 98])
        ahead = ahead + 3.0 * (corners[:, :, 0].mean(axis=1) - low) / (high - low) - 1.2
    return ahead >= 0.0


def _extent(part: Part) -> tuple[np.ndarray, np.ndarray]:
    plane = part.vertices[:, 1:3]
    return plane.min(axis=0), plane.max(axis=0)


def _size(part: Part) -> tuple[int, int]:
    low, high = _extent(part)
    width, tall = np.ceil((high - low) / PITCH[part.region]).astype(int) + 4
    return int(width), int(tall)


def _project(part: Part, front: bool) -> np.ndarray:
    """Pixel (u right, v down) of every vertex in its side's block."""
    low, high = _extent(part)
    pitch = PITCH[part.region]
    across = high[0] - part.vertices[:, 1] if front else part.vertices[:, 1] - low[0]
    return np.stack([across / pitch + 2.0, (high[1] - part.vertices[:, 2]) / pitch + 2.0], axis=1)


def _packed(sizes: list[tuple[int, int]]) -> tuple[list[tuple[int, int]], int]:
    """Shelves: highest first."""
    places: list[tuple[int, int]] = [(0, 0)] * len(sizes)
    u = v = shelf = 0
    for i in sorted(range(len(sizes)), key=lambda i: -sizes[i][1]):
        width, tall = sizes[i]
        if u + width > WIDTH:
            u, v = 0, v + shelf
            shelf = 0
        places[i] = (u, v)
        u, shelf = u + width, max(shelf, tall)
    return places, -(-(v + shelf) // 8) * 8


def _paint_block(
    part: Part, faces: np.ndarray, front: bool, body: Body, person: Person
) -> np.ndarray:
    width, tall = _size(part)
    uv = _project(part, front)
    outward = part.vertices[:, 0] if front else -part.vertices[:, 0]
    index, shares = _rasterised(faces, uv, outward, width, tall)
    seen = index >= 0
    if not seen.any():
        return np.full((tall, width, 3), 128.0)
    triangle = faces[index[seen]]
    weights = shares[seen][:, :, None]
    places = (part.vertices[triangle] * weights).sum(axis=1)
    normals = (part.normals()[triangle] * weights).sum(axis=1)
    hair = hairiness(places, body, person) if part.region == "head" else np.zeros(len(places))
    block = np.zeros((tall, width, 3))
    block[seen] = _colours(part.region, Texels(places, normals, hair), body, person)
    nearest = distance_transform_edt(~seen, return_distances=False, return_indices=True)
    block = block[nearest[0], nearest[1]]
    return block * _folds(part.region, (tall, width), person)[:, :, None]


def _rasterised(
    faces: np.ndarray, uv: np.ndarray, outward: np.ndarray, width: int, tall: int
) -> tuple[np.ndarray, np.ndarray]:
    """Which face covers a texel's middle (-1: none; the outermost), and its barycentric shares."""
    index = np.full((tall, width), -1)
    shares = np.zeros((tall, width, 3))
    nearest = np.full((tall, width), -np.inf)
    for i, face in enumerate(faces):
        a, b, c = uv[face]
        low = np.maximum(np.floor(np.min([a, b, c], axis=0)).astype(int) - 1, 0)
        high = np.minimum(np.ceil(np.max([a, b, c], axis=0)).astype(int) + 2, [width, tall])
        u, v = np.meshgrid(np.arange(low[0], high[0]) + 0.5, np.arange(low[1], high[1]) + 0.5)
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if abs(area) < 1e-9 or u.size == 0:
            continue
        sb = ((u - a[0]) * (c[1] - a[1]) - (v - a[1]) * (c[0] - a[0])) / area
        sc = ((b[0] - a[0]) * (v - a[1]) - (b[1] - a[1]) * (u - a[0])) / area
        s = np.stack([1.0 - sb - sc, sb, sc], axis=-1)
        window = (slice(low[1], high[1]), slice(low[0], high[0]))
        inside = (s >= -0.01).all(axis=-1)
        s = np.clip(s, 0.0, 1.0)
        s /= s.sum(axis=-1, keepdims=True)
        depth = s @ outward[face]
        inside &= depth > nearest[window]
        nearest[window] = np.where(inside, depth, nearest[window])
        index[window] = np.where(inside, i, index[window])
        shares[window] = np.where(inside[:, :, None], s, shares[window])
    return index, shares


def _folds(region: str, shape: tuple[int, int], person: Person) -> np.ndarray:
    """Light and dark of folds and weave, around one."""
    amount = {"jacket": 0.10, "trousers": 0.10, "hair": 0.10, "head": 0.02}.get(region, 0.03)
    rng = np.random.default_rng((person.seed, len(region), *shape))
    noise = rng.standard_normal(shape)
    broad = gaussian_filter(noise, (7.0, 3.0), mode="wrap")
    slanted = gaussian_filter(rng.standard_normal(shape), (2.0, 6.0), mode="wrap")
    mixed = broad / broad.std() + 0.7 * slanted / slanted.std()
    return 1.0 + amount * np.clip(mixed, -2.0, 2.0) * 0.6


def _colours(region: str, at: Texels, body: Body, person: Person) -> np.ndarray:
    """(N, 3) RGB of texels before folds."""
    paint = {"jacket": _jacket, "trousers": _trousers, "head": _head, "skin": _skin}
    if region in paint:
        return paint[region](at, body, person)
    plain = {"hair": person.hair, "helmet": person.helmet, "shoes": person.shoes}[region]
    colours = np.tile(np.array(plain, float), (len(at.places), 1))
    if region == "shoes":
        colours[at.places[:, 2] < -0.008] *= 0.55  # the sole
    return colours


def _jacket(at: Texels, body: Body, person: Person) -> np.ndarray:
    x, y, z = at.places.T
    colours = np.tile(np.array(person.jacket, float), (len(x), 1))
    low, neck = hem_z(body, person), body.joint("neck01")[2]
    shoulder = abs(body.joint("upperarm01.L")[1])
    front, chest = at.normals[:, 0] > 0.0, low + 0.62 * (neck - low)
    trunk = np.abs(y) < shoulder + 0.02
    if person.open_front is not None:
        opening = front & (np.abs(y) < 0.025 + 0.075 * (z - low) / (neck - low)) & trunk
        colours[opening] = person.open_front
    elif not person.short_sleeves:
        colours[front & (np.abs(y) < 0.006)] *= 0.6  # zip
        colours[front & (np.abs(np.abs(y) - 0.09) < 0.035) & (np.abs(z - chest) < 0.004)] *= 0.65
    if person.vest is not None:
        vest = (
            trunk & (z < neck + 0.02) & ~(front & (np.abs(y) < 0.012 + 0.45 * (z - chest - 0.06)))
        )
        colours[vest] = person.vest
        colours[vest & front & (np.abs(y) < 0.008)] *= 0.6
        _bands(colours, vest, y, z, low, neck)
    if person.reflective_jacket:
        _bands(colours, trunk, y, z, low, neck)
        elbow = body.joint("lowerarm01.L")
        wrist = body.joint("wrist.L")
        along = _along(at.places, elbow, wrist)
        colours[~trunk & (np.abs(along - 0.30) < 0.10)] = REFLECTIVE
        colours[~trunk & (along > 0.55)] = (38, 44, 66)
    colours[z < low - 0.005] *= 0.75
    colours[(z > neck - 0.01) & trunk] *= 0.85  # collar
    return colours


def _bands(colours, where, y, z, low, neck) -> None:  # type: ignore[no-untyped-def]
    """Reflective bands: two around the body, one over each shoulder."""
    for share in (0.17, 0.42):
        colours[where & (np.abs(z - low - share * (neck - low)) < 0.027)] = REFLECTIVE
    over = np.abs(np.abs(y) - 0.105) < 0.025
    colours[where & over & (z > low + 0.42 * (neck - low))] = REFLECTIVE


def _along(points: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Share of the way from a to b, left and right alike."""
    mirrored = points * [1.0, 0.0, 1.0] + np.abs(points) * [0.0, 1.0, 0.0]
    return (mirrored - a) @ (b - a) / ((b - a) @ (b - a))


def _trousers(at: Texels, body: Body, person: Person) -> np.ndarray:
    x, y, z = at.places.T
    colours = np.tile(np.array(person.trousers, float), (len(x), 1))
    hip, knee = body.joint("upperleg01.L")[2], body.joint("lowerleg01.L")[2]
    front = at.normals[:, 0] > 0.0
    colours[(np.abs(z - hip + 0.06) < 0.004) & (np.abs(y) > 0.06)] *= 0.7  # pockets
    colours[z > hem_z(body, person) + 0.01] *= 0.6  # belt
    colours[(z > knee) & (z < hip - 0.04) & (np.abs(y) < 0.02)] *= 0.75
    colours[front & (np.abs(z - knee) < 0.03)] *= 1.08
    colours[z < 0.05] *= 0.8
    if person.reflective_jacket:
        for share in (0.30, 0.48):
            colours[np.abs(z - share * knee - 0.08) < 0.022] = REFLECTIVE
    return colours


def _skin(at: Texels, body: Body, person: Person) -> np.ndarray:
    colours = np.tile(np.array(person.skin, float), (len(at.places), 1))
    finger = body.joint("finger3-1.L")[2]
    colours[at.places[:, 2] < finger] *= 0.92
    return colours


def _head(at: Texels, body: Body, person: Person) -> np.ndarray:
    x, y, z = at.places.T
    skin = np.array(person.skin, float)
    colours = np.tile(skin, (len(x), 1))
    eye = 0.5 * (body.joint("eye.L") + body.joint("eye.R"))
    size = body.vertices[:, 2].max() - eye[2]
    up, side = (z - eye[2]) / size, np.abs(y) / size
    apart = abs(body.joint("eye.L")[1]) / size
    front = at.normals[:, 0] > 0.0
    face = front & (x > eye[0] - 0.5 * size)

    def spot(u: float, v: float, wide: float, high: float) -> np.ndarray:
        return face & (((side - u) / wide) ** 2 + ((up - v) / high) ** 2 < 1.0)

    colours[spot(apart, 0.0, 0.20, 0.14)] *= 0.82  # sockets
    colours[spot(0.34, -0.36, 0.16, 0.16)] *= [1.03, 0.95, 0.94]  # cheeks
    colours[spot(0.0, -0.44, 0.11, 0.05)] *= 0.75  # under the nose
    colours[face & (up < -0.95)] *= 0.80  # under the chin
    colours[~face & (up < -0.95)] *= 0.88
    if person.beard:
        beard = front & (up < -0.42) & (up > -1.02) & (side < 0.66) & (x > eye[0] - 0.75 * size)
        colours[beard] = 0.85 * np.array(person.hair) + 0.15 * skin
    colours[spot(apart, 0.0, 0.12, 0.050)] = (232, 228, 222)
    colours[spot(apart, 0.0, 0.050, 0.055)] = (58, 40, 30)
    colours[spot(apart, 0.055, 0.14, 0.022)] = 0.45 * skin  # lids
    colours[spot(apart + 0.02, 0.20, 0.17, 0.035)] = 0.7 * np.array(person.hair) + 0.1 * skin
    colours[spot(0.0, -0.60, 0.20, 0.055)] = skin * [0.86, 0.62, 0.60]
    colours[spot(0.0, -0.60, 0.18, 0.012)] = skin * 0.45
    colours = np.where(at.hair[:, None] > 0.5, np.array(person.hair, float), colours)
    return colours
