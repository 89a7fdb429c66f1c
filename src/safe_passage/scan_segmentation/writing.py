"""Results as files: JSON, PNG, the map server's pgm and yaml, PLY."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from safe_passage.scan_segmentation.basic_map import Colour, ColourMap
from safe_passage.scan_segmentation.doors import Door
from safe_passage.scan_segmentation.pipeline import Segmentation
from safe_passage.scan_segmentation.visualisation import CUBE, Pictured

BGR = np.array([[90, 90, 90], [60, 160, 40], [0, 140, 255], [40, 40, 200]], np.uint8)
GREY = np.array([205, 254, 128, 0], np.uint8)  # of the map server: unknown, free, between, occupied


def as_values(found: Segmentation) -> dict[str, Any]:
    """Planes, doors, stairs and times, for JSON: what is not known is null."""
    ground = {plane.index for plane in found.ground}
    planes = [
        {
            "normal": _rounded(valid.plane.normal, 6),
            "offset": round(valid.plane.offset, 5),
            "rms": round(valid.plane.rms, 5),
            "area": round(valid.area, 2),
            "points": valid.points,
            "ground": k in ground,
            "outline": [_rounded(polygon, 3) for polygon in valid.outline()],
        }
        for k, valid in enumerate(found.planes.valid)
    ]
    return {
        "points": int(found.planes.scan.valid.sum()),
        "segments": len(found.planes.segments),
        "frames": {"planes": "scanner", "doors, stairs, maps": "level: z up, origin in scanner"},
        "level": _rounded(found.level.R_level_scan, 6),
        "planes": planes,
        "doors": [_door(door) for door in found.doors],
        "stairs": [{**flight.__dict__, "foot": list(flight.foot)} for flight in found.stairs],
        "seconds": {stage: round(took, 4) for stage, took in found.seconds.items()},
        "notes": list(found.planes.notes),
    }


def write_json(file: Path, values: dict[str, Any]) -> None:
    """Numbers as they are; no NaN, which is no JSON."""
    file.write_text(json.dumps(values, indent=1, allow_nan=False) + "\n")


def write_map(stem: Path, colours: ColourMap) -> None:
    """stem.png in colour, and stem.pgm with stem.yaml for the map server."""
    cv2.imwrite(f"{stem}.png", BGR[colours.cells[::-1]])
    cv2.imwrite(f"{stem}.pgm", GREY[colours.cells[::-1]])
    x, y = colours.origin
    lines = [
        f"image: {stem.name}.pgm",
        f"resolution: {colours.resolution:g}",
        f"origin: [{x:.4f}, {y:.4f}, 0.0]",
        "negate: 0",
        "occupied_thresh: 0.65",
        "free_thresh: 0.196",
        "mode: scale",
    ]
    Path(f"{stem}.yaml").write_text("\n".join(lines) + "\n")


def write_ply(file: Path, found: Segmentation, shapes: Pictured, with_walls: bool = False) -> None:
    """The cloud by its remission, drivable triangles, orange cubes, red cuboids. Frame: scanner."""
    scan = found.planes.scan
    cloud = scan.points[scan.valid]
    vertices, colours, faces, base = [cloud], [grey_values(found)], [], len(cloud)
    for colour in (Colour.GREEN, Colour.ORANGE):
        triangles = shapes.ground.triangles[shapes.ground.colours == colour]
        used, corner = np.unique(triangles, return_inverse=True)
        vertices.append(shapes.ground.points[used])
        colours.append(_painted(colour, len(used)))
        faces.append(corner.reshape(-1, 3) + base)
        base += len(used)
    for corners, colour in boxes(found, shapes):
        vertices.append(corners.reshape(-1, 3))
        colours.append(_painted(colour, 8 * len(corners)))
        faces.append((BOX[None] + 8 * np.arange(len(corners))[:, None, None]).reshape(-1, 3) + base)
        base += 8 * len(corners)
    if with_walls:
        for polygon in shapes.walls:
            vertices.append(polygon)
            colours.append(_painted(Colour.RED, len(polygon)))
            around = np.arange(1, len(polygon) - 1)
            faces.append(np.stack([0 * around, around, around + 1], axis=1) + base)
            base += len(polygon)
    _write_ply(file, np.concatenate(vertices), np.concatenate(colours), np.concatenate(faces))


BOX = np.array(
    [
        [0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7], [0, 5, 1], [0, 4, 5],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ]
)  # fmt: skip


def boxes(found: Segmentation, shapes: Pictured) -> list[tuple[np.ndarray, Colour]]:
    """Corners (N, 8, 3) [m] of cubes and of cuboids. Frame: scanner."""
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 0.5
    middles = found.level.points(shapes.cubes)
    cubes = middles[:, None] + signs * CUBE
    c = shapes.cuboids
    middle = np.column_stack([c[:, :2], 0.5 * (c[:, 2] + c[:, 3])])
    size = np.column_stack([c[:, 4], c[:, 4], np.maximum(c[:, 3] - c[:, 2], 0.02)])
    cuboids = middle[:, None] + signs * size[:, None]
    return [
        (found.level.back(cubes), Colour.ORANGE),
        (found.level.back(cuboids), Colour.RED),
    ]


def grey_values(found: Segmentation) -> np.ndarray:
    """(N, 3) uint8 RGB of the cloud's points by remission; by height without any."""
    scan = found.planes.scan
    if scan.remission is not None:
        values = scan.remission[scan.valid].astype(float)
    else:
        values = found.survey.points[scan.valid][:, 2]
    low, high = np.nanpercentile(values, [2.0, 98.0])
    shade = np.clip((values - low) / max(high - low, 1e-9), 0.0, 1.0)
    return np.repeat((60 + 180 * np.nan_to_num(shade)).astype(np.uint8)[:, None], 3, axis=1)


def _painted(colour: Colour, count: int) -> np.ndarray:
    return np.tile(BGR[colour][::-1], (count, 1))


def _write_ply(file: Path, points: np.ndarray, rgb: np.ndarray, faces: np.ndarray) -> None:
    vertex = np.empty(len(points), [("p", "<f4", 3), ("c", "u1", 3)])
    vertex["p"], vertex["c"] = points, rgb
    face = np.empty(len(faces), [("n", "u1"), ("i", "<i4", 3)])
    face["n"], face["i"] = 3, faces
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertex)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        f"element face {len(face)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    file.write_bytes(header.encode() + vertex.tobytes() + face.tobytes())


def _door(door: Door) -> dict[str, Any]:
    values = {**door.__dict__, "middle": list(door.middle), "passable_by": list(door.passable_by)}
    return {
        key: None if isinstance(value, float) and not math.isfinite(value) else value
        for key, value in values.items()
    }


def _rounded(values: np.ndarray, digits: int) -> list:
    return np.round(np.asarray(values, float), digits).tolist()
