"""Dresses a rest body: jacket, trousers, shoes, hair; each part closed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import trimesh
from bodies import Body
from meshes import Part, border_loops, capped, compact, cut, extruded, joined, smooth
from people import Person

SOLE = 0.028  # [m] of a shoe under the foot
ARMS = ("upperarm", "lowerarm")
HANDS = ("wrist", "finger", "metacarpal")
HEAD = ("head", "eye", "neck")
FEET = ("foot", "toe")
LEGS = ("upperleg", "lowerleg")
UP = np.array([0.0, 0.0, 1.0])


def dressed(body: Body, person: Person) -> list[Part]:
    """All parts, in full resolution. The soles of the shoes are SOLE under the body's z = 0."""
    parts = [jacket(body, person), trousers(body, person), head(body, person)]
    for side, label in ((1.0, "L"), (-1.0, "R")):
        parts.append(hand(body, person, label))
        parts += shoe(body, side)
    return parts + hair_pieces(body, person)


def sleeve_end(body: Body, person: Person, label: str) -> tuple[np.ndarray, np.ndarray]:
    """A sleeve's end: a point on the arm's axis and the direction towards the shoulder."""
    elbow = body.joint(f"lowerarm01.{label}")
    if person.short_sleeves:
        shoulder = body.joint(f"upperarm01.{label}")
        return 0.25 * shoulder + 0.75 * elbow, _unit(shoulder - elbow)
    wrist = body.joint(f"wrist.{label}")
    return wrist + 0.01 * _unit(elbow - wrist), _unit(elbow - wrist)


def hem_z(body: Body, person: Person) -> float:
    """Lower end of the jacket [m]."""
    return float(body.joint("upperleg01.L")[2]) + person.hem


def jacket(body: Body, person: Person) -> Part:
    """Jacket or shirt: torso and sleeves."""
    skin = Part("jacket", body.vertices, body.faces, body.weights)
    arms = body.dominated(*ARMS, *HANDS)
    neck = body.joint("neck01")
    trunk = _select(skin, body, ~arms & ~body.dominated("head", "eye", "lowerleg", *FEET))
    trunk = cut(trunk, neck + np.array([0.0, 0.0, 0.03]), np.array([-0.40, 0.0, -0.92]))
    trunk = cut(trunk, np.array([0.0, 0.0, hem_z(body, person)]), UP)
    pieces = [trunk]
    for label, side in (("L", 1.0), ("R", -1.0)):
        origin, keep = sleeve_end(body, person, label)
        arm = _select(skin, body, arms & (body.vertices[:, 1] * side > 0.0))
        pieces.append(cut(arm, origin, keep))
    cloth = joined("jacket", pieces)
    low, high = hem_z(body, person), neck[2]
    hang = np.clip((high - cloth.vertices[:, 2]) / (high - low), 0.0, 1.0)
    sleeve = cloth.weights[:, body.bones(*ARMS)].sum(axis=1)
    loose = (1.0 - sleeve) * (0.010 + 0.014 * hang) + sleeve * 0.014
    cloth = _loosened(cloth, loose * person.looseness, rounds=10)
    return capped(_hemmed(cloth, body, person))


def _hemmed(cloth: Part, body: Body, person: Person) -> Part:
    """Hem, cuffs and collar turned out a little, so that they cast an edge."""
    for ring in border_loops(cloth.faces):
        middle = cloth.vertices[ring].mean(axis=0)
        spread = cloth.vertices[ring] - middle
        if abs(middle[1]) > 0.1:  # a cuff
            label = "L" if middle[1] > 0.0 else "R"
            _, keep = sleeve_end(body, person, label)
            places = middle + spread * 1.06 - 0.015 * keep
        elif middle[2] < body.joint("spine03")[2]:  # the hem
            places = middle + spread * 1.03 - 0.03 * UP
        else:  # the collar
            places = middle + spread * 1.05 + 0.02 * UP
        cloth = extruded(cloth, ring, places)
    return cloth


def trousers(body: Body, person: Person) -> Part:
    """From the waist, under the jacket, down onto the shoes."""
    skin = Part("trousers", body.vertices, body.faces, body.weights)
    cloth = _select(skin, body, ~body.dominated(*ARMS, *HANDS, *HEAD))
    waist = hem_z(body, person) + 0.08
    cloth = cut(cloth, np.array([0.0, 0.0, waist]), -UP)
    cloth = cut(cloth, np.array([0.0, 0.0, body.joint("foot.L")[2] + 0.035]), UP)
    hip, ankle = body.joint("upperleg01.L")[2], body.joint("foot.L")[2]
    down = np.clip((hip - cloth.vertices[:, 2]) / (hip - ankle), 0.0, 1.0)
    cloth = _loosened(cloth, (0.006 + 0.020 * down) * person.looseness, rounds=8)
    for ring in border_loops(cloth.faces):
        middle = cloth.vertices[ring].mean(axis=0)
        if middle[2] < 0.5 * hip:  # break over the shoe
            low = middle + (cloth.vertices[ring] - middle) * np.array([1.10, 1.02, 1.0])
            low[:, 2] = 0.018
            cloth = extruded(cloth, ring, low + np.array([0.012, 0.0, 0.0]))
    return capped(cloth)


def head(body: Body, person: Person) -> Part:
    """Face, hair and neck in one; the hair is as thick as its style says."""
    skin = Part("head", body.vertices, body.faces, body.weights)
    neck = body.joint("neck01")
    chosen = ~body.dominated(*ARMS, *HANDS, *LEGS) & (np.abs(body.vertices[:, 1]) < 0.11)
    part = _select(skin, body, chosen)
    part = cut(part, neck - np.array([0.0, 0.0, 0.035]), np.array([0.40, 0.0, 0.92]))
    part = replace(part, vertices=smooth(part.vertices, part.faces, 2, 0.4))
    grown = hairiness(part.vertices, body, person)[:, None] * part.normals()
    blurred = smooth(grown, part.faces, 6, 0.5)
    return capped(replace(part, vertices=part.vertices + person.hair_thickness * blurred))


def hairiness(points: np.ndarray, body: Body, person: Person) -> np.ndarray:
    """(N,) 1 where hair grows on the head, 0 on bare skin, sharp between."""
    eye = 0.5 * (body.joint("eye.L") + body.joint("eye.R"))
    size = body.vertices[:, 2].max() - eye[2]  # eyes to crown, about 0.11 m
    forward, up = (points[:, 0] - eye[0]) / size, (points[:, 2] - eye[2]) / size
    side = np.abs(points[:, 1]) / size
    hairline = 0.62 - person.bald + 0.10 * np.cos(4.0 * side)
    fringe = (up > hairline) | (forward < -0.42 - 0.3 * person.bald)
    temples = (forward < -0.40) & (up > -0.15)
    behind = (forward < -0.85) & (up > person.hair_low)
    face = forward > -0.42
    return np.where(face, up > hairline, (fringe & (up > 0.35)) | temples | behind).astype(float)


def hand(body: Body, person: Person, label: str) -> Part:
    """The hand and what the sleeve leaves bare of the arm."""
    side = 1.0 if label == "L" else -1.0
    skin = Part("skin", body.vertices, body.faces, body.weights)
    part = _select(skin, body, body.dominated(*ARMS, *HANDS) & (body.vertices[:, 1] * side > 0.0))
    origin, keep = sleeve_end(body, person, label)
    return capped(cut(part, origin + 0.02 * keep, -keep))


def shoe(body: Body, side: float) -> list[Part]:
    """A sturdy low boot: a hull around the foot and one around the ankle."""
    label = "L" if side > 0.0 else "R"
    foot = body.vertices[body.dominated(*FEET) & (body.vertices[:, 1] * side > 0.0)]
    ankle, ball = body.joint(f"foot.{label}"), body.joint(f"toe3-1.{label}")
    flat = foot[foot[:, 2] < 0.055]
    sole = flat[flat[:, 2] < 0.03]
    sole = np.concatenate([sole * [1, 1, 0] - [0, 0, SOLE], sole * [1, 1, 0] - [0, 0, 0.004]])
    upper = foot[(foot[:, 0] < ankle[0] + 0.45 * (ball[0] - ankle[0])) & (foot[:, 2] > 0.02)]
    parts = []
    for points in (np.concatenate([flat, sole]), upper):
        hull = trimesh.Trimesh(points).convex_hull
        middle = hull.centroid
        grown = hull.vertices + 0.008 * np.array(hull.vertex_normals) * [1.0, 1.0, 0.6]
        grown[:, 2] = np.maximum(grown[:, 2], -SOLE)
        vertices, faces = trimesh.remesh.subdivide_to_size(grown, hull.faces, max_edge=0.05)
        faces = _outward(np.asarray(vertices), np.asarray(faces), middle)
        bend = np.clip((vertices[:, 0] - ball[0] + 0.02) / 0.04, 0.0, 1.0)
        weights = np.zeros((len(vertices), len(body.labels)))
        weights[:, body.labels.index(f"foot.{label}")] = 1.0 - bend
        weights[:, body.labels.index(f"toe3-1.{label}")] = bend
        parts.append(joined("shoes", [Part("shoes", np.asarray(vertices), faces, weights)]))
    return parts


def hair_pieces(body: Body, person: Person) -> list[Part]:
    """What hair style or helmet adds to the head."""
    eye = 0.5 * (body.joint("eye.L") + body.joint("eye.R"))
    size = body.vertices[:, 2].max() - eye[2]
    ball = trimesh.creation.icosphere(subdivisions=3)
    shapes = {
        "bob": [("hair", (-0.88, 0.0, -0.20), (0.52, 0.74, 0.88))],
        "ponytail": [
            ("hair", (-1.76, 0.0, 0.0), (0.28, 0.20, 0.30)),
            ("hair", (-1.84, 0.0, -0.62), (0.17, 0.17, 0.72)),
        ],
        "helmet": [
            ("helmet", (-0.78, 0.0, 0.50), (1.12, 0.92, 0.84)),
            ("helmet", (-0.55, 0.0, 0.36), (1.22, 0.86, 0.13)),
        ],
        "cap": [
            ("helmet", (-0.80, 0.0, 0.44), (1.04, 0.83, 0.74)),
            ("helmet", (0.10, 0.0, 0.46), (0.75, 0.55, 0.10)),
        ],
    }
    parts = []
    for region, centre, radii in [s for name in person.extras for s in shapes[name]]:
        vertices = eye + size * (np.array(centre) + np.array(ball.vertices) * radii)
        weights = np.zeros((len(vertices), len(body.labels)))
        weights[:, body.labels.index("head")] = 1.0
        parts.append(Part(region, vertices, np.array(ball.faces), weights))
    return parts


def _loosened(cloth: Part, offset: np.ndarray, rounds: int) -> Part:
    """Cloth that spans hollows instead of following the skin, `offset` (V,) [m] off it."""
    # Borders move with the rest: smoothing holds them, so that hems stay in their plane.
    even = smooth(cloth.vertices, cloth.faces, rounds, 0.5)
    normals = smooth(replace(cloth, vertices=even).normals(), cloth.faces, 3, 0.5)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    sunk = np.maximum(((cloth.vertices - even) * normals).sum(axis=1), 0.0)
    out = even + (offset + sunk)[:, None] * normals
    return replace(cloth, vertices=smooth(out, cloth.faces, 4, 0.5))


def _select(part: Part, body: Body, chosen: np.ndarray) -> Part:
    """Faces of which any vertex is chosen: neighbours overlap by a row, cuts make the border."""
    faces = body.faces[chosen[body.faces].mean(axis=1) > 0.5]
    return compact(replace(part, faces=faces))


def _outward(vertices: np.ndarray, faces: np.ndarray, middle: np.ndarray) -> np.ndarray:
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    inward = (np.cross(b - a, c - a) * (a - middle)).sum(axis=1) < 0.0
    return np.where(inward[:, None], faces[:, ::-1], faces)


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v)
