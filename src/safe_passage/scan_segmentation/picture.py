"""One picture of a result: the map from above, and the place as seen from behind the scanner."""

from __future__ import annotations

import math

import cv2
import numpy as np

from safe_passage.scan_segmentation.basic_map import Colour
from safe_passage.scan_segmentation.pipeline import Segmentation
from safe_passage.scan_segmentation.visualisation import Pictured
from safe_passage.scan_segmentation.writing import BGR, BOX, boxes, grey_values

HEIGHT = 720  # [px]
VIEW = 960  # [px] width of the view
LIGHT = np.array([0.3, -0.4, 0.86])
WHITE, BLACK = (255, 255, 255), (20, 20, 20)
LEGEND = (
    (Colour.GREEN, "drivable (robot's centre)"),
    (Colour.ORANGE, "with care: narrow, or a low obstacle"),
    (Colour.RED, "not passable"),
    (Colour.UNKNOWN, "not seen"),
)
ABOVE = 0.6  # [m] over the robot from which on nothing is drawn: ceilings hide all


def draw(found: Segmentation, shapes: Pictured, title: str) -> np.ndarray:
    """(720, W, 3) uint8 BGR."""
    top, view = from_above(found), _view(found, shapes)
    both = np.hstack([top, np.full((HEIGHT, 8, 3), 255, np.uint8), view])
    bar = np.full((70, both.shape[1], 3), 255, np.uint8)
    _text(bar, title, (10, 26), 0.65)
    x = 10
    for colour, text in LEGEND:
        cv2.rectangle(bar, (x, 44), (x + 18, 60), tuple(int(v) for v in BGR[colour]), -1)
        _text(bar, text, (x + 24, 57), 0.45)
        x += 24 + 9 * len(text)
    return np.vstack([bar, both])


def from_above(found: Segmentation) -> np.ndarray:
    """(720, W, 3) uint8 BGR: the map for the robot's centre, doors and stairs."""
    colours = found.drivable
    image = BGR[colours.cells].copy()
    beside = (colours.cells == Colour.RED) & (found.basic.cells != Colour.RED)
    image[beside] = (170, 170, 235)  # ground, but the robot's centre cannot be there
    origin, image = _with_scanner(image, colours.origin, colours.resolution)
    scale = HEIGHT / image.shape[0]
    width = min(900, max(200, round(image.shape[1] * scale)))
    scale = min(scale, width / image.shape[1])
    size = round(image.shape[1] * scale), round(image.shape[0] * scale)
    shrunk = cv2.resize(image, size, interpolation=cv2.INTER_AREA)[::-1].copy()
    to_pixel = scale / colours.resolution

    def pixel(x: float, y: float) -> tuple[int, int]:
        at = (np.array([x, y]) - origin) * to_pixel
        return round(at[0]), round(size[1] - at[1])

    cv2.drawMarker(shrunk, pixel(0, 0), WHITE, cv2.MARKER_TRIANGLE_UP, 16, 2)
    _text(shrunk, "scanner", (pixel(0, 0)[0] + 8, pixel(0, 0)[1] - 8), 0.45, WHITE)
    for door in found.doors:
        across = 0.5 * door.width * np.array([-math.sin(door.yaw), math.cos(door.yaw)])
        middle = np.array(door.middle[:2])
        cv2.line(shrunk, pixel(*(middle - across)), pixel(*(middle + across)), WHITE, 2)
        label = f"door {door.said_width}" + ("" if door.passable_by else " (too small)")
        _text(shrunk, label, (pixel(*middle)[0] + 8, pixel(*middle)[1]), 0.45, WHITE)
    for flight in found.stairs:
        up = flight.steps * flight.run * np.array([math.cos(flight.yaw), math.sin(flight.yaw)])
        foot = np.array(flight.foot[:2])
        cv2.arrowedLine(shrunk, pixel(*foot), pixel(*(foot + up)), WHITE, 2)
        _text(shrunk, f"stairs, {flight.steps} steps up", pixel(*foot), 0.45, WHITE)
    metre = round(to_pixel)
    cv2.line(shrunk, (10, size[1] - 12), (10 + metre, size[1] - 12), WHITE, 3)
    _text(shrunk, "1 m", (14, size[1] - 18), 0.45, WHITE)
    pad = HEIGHT - size[1]
    return np.pad(shrunk, ((0, pad), (0, 0), (0, 0)), constant_values=90)


def _with_scanner(
    image: np.ndarray, origin: np.ndarray, resolution: float
) -> tuple[np.ndarray, np.ndarray]:
    """The map's image, unseen around as far as the scanner is beyond its border."""
    rows, columns = image.shape[:2]
    at = np.round(-origin / resolution).astype(int)
    border = round(0.3 / resolution)
    left, low = (max(0, border - int(v)) for v in at)
    right, high = max(0, int(at[0]) + border - columns), max(0, int(at[1]) + border - rows)
    padded = np.stack(
        [
            np.pad(image[..., k], ((low, high), (left, right)), constant_values=BGR[0][k])
            for k in range(3)
        ],
        axis=-1,
    )
    return origin - resolution * np.array([left, low]), padded


def _view(found: Segmentation, shapes: Pictured) -> np.ndarray:
    """Perspective from behind and above the scanner, nearer things over farther ones."""
    level, scan = found.level, found.planes.scan
    floor = float(found.survey.ground.z(np.zeros((1, 2)))[0])
    cloud = found.survey.points[scan.valid]
    over = found.survey.height[scan.valid]
    low = np.isfinite(over) & (over < found.robot.clearance + ABOVE)
    camera = _framing(cloud[low] if low.any() else np.zeros((1, 3)), floor)
    image = np.full((HEIGHT, VIEW, 3), 250, np.uint8)
    faces, colours = [], []
    mesh = shapes.ground
    if len(mesh.triangles):
        faces.append(level.points(mesh.points)[mesh.triangles])
        colours.append(BGR[mesh.colours].astype(float))
    for corners, colour in boxes(found, shapes):
        if len(corners):
            sides = level.points(corners)[:, BOX].reshape(-1, 3, 3)
            faces.append(sides)
            colours.append(_shaded(sides, BGR[colour]))
    depth = np.full((HEIGHT, VIEW), np.inf)
    _splat(image, depth, camera, cloud[low], grey_values(found)[low])
    if faces:
        _paint(image, depth, camera, np.concatenate(faces), np.concatenate(colours))
    return image


def _framing(points: np.ndarray, floor: float) -> _Camera:
    """From the scanner's side and above, as large as the picture allows."""
    middle = np.append(np.median(points[:, :2], axis=0), floor)
    away = np.linalg.norm(middle[:2])
    ahead = middle[:2] / away if away > 0.3 else np.array([1.0, 0.0])
    reach = float(np.percentile(np.abs(points - middle).max(axis=1), 95.0)) + 0.5
    camera = _Camera(middle + 2.2 * reach * np.array([-ahead[0], -ahead[1], 1.2]), middle)
    camera.fill(points)
    return camera


class _Camera:
    def __init__(self, eye: np.ndarray, target: np.ndarray) -> None:
        forward = (target - eye) / np.linalg.norm(target - eye)
        right = np.cross(forward, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        self.R = np.stack([right, np.cross(forward, right), forward])
        self.eye = eye
        self.focal, self.centre = float(VIEW), np.array([VIEW / 2, HEIGHT / 2])

    def project(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pixels (..., 2) and depths (...) [m]."""
        seen = (points - self.eye) @ self.R.T
        depth = np.maximum(seen[..., 2], 0.05)
        return seen[..., :2] / depth[..., None] * self.focal + self.centre, seen[..., 2]

    def fill(self, points: np.ndarray) -> None:
        """Turns and zooms so that nearly all points are in the picture."""
        low, high = np.percentile(self.project(points)[0], [1.5, 98.5], axis=0)
        size = np.array([VIEW, HEIGHT])
        zoom = float((0.92 * size / np.maximum(high - low, 1.0)).min())
        self.centre = 0.5 * size - zoom * (0.5 * (low + high) - self.centre)
        self.focal *= zoom


def _splat(
    image: np.ndarray, depth: np.ndarray, camera: _Camera, points: np.ndarray, rgb: np.ndarray
) -> None:
    """Points of the cloud, two pixels wide."""
    at, far = camera.project(points)
    order = np.argsort(-far)
    for dx in (0, 1):
        for dy in (0, 1):
            column, row = np.floor(at[order] + (dx, dy)).astype(int).T
            inside = (row >= 0) & (row < HEIGHT) & (column >= 0) & (column < VIEW)
            inside &= far[order] > 0.1
            image[row[inside], column[inside]] = rgb[order][inside]
            depth[row[inside], column[inside]] = far[order][inside]


def _paint(
    image: np.ndarray, depth: np.ndarray, camera: _Camera, faces: np.ndarray, bgr: np.ndarray
) -> None:
    """Triangles from the farthest to the nearest, over the cloud."""
    at, far = camera.project(faces)
    seen = (far > 0.1).all(axis=1)
    order = np.flatnonzero(seen)[np.argsort(-far[seen].mean(axis=1))]
    corners = np.round(at).astype(np.int32)
    for i in order:
        cv2.fillConvexPoly(image, corners[i], bgr[i].tolist())


def _shaded(sides: np.ndarray, bgr: np.ndarray) -> np.ndarray:
    normal = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    return bgr * (0.55 + 0.45 * np.abs(normal @ LIGHT))[:, None]


def _text(
    image: np.ndarray, text: str, at: tuple[int, int], size: float, colour: tuple = BLACK
) -> None:
    (width, _), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, size, 1)
    at = (max(2, min(at[0], image.shape[1] - width - 4)), at[1])
    if colour == WHITE:
        cv2.putText(image, text, at, cv2.FONT_HERSHEY_SIMPLEX, size, BLACK, 3, cv2.LINE_AA)
    cv2.putText(image, text, at, cv2.FONT_HERSHEY_SIMPLEX, size, colour, 1, cv2.LINE_AA)
