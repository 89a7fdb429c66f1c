"""A small warehouse aisle whose every depth and range is known exactly.

Frames: world x forward, y left, z up (REP 103), origin on the ground under the camera.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from safe_passage.simulation import raycast
from safe_passage.simulation.bodies import Capsule, Clothes, Person

LIGHT = np.array([-0.5, 0.35, 0.8]) / np.linalg.norm([-0.5, 0.35, 0.8])
BACKGROUND = np.array([205.0, 205.0, 200.0])  # BGR where a ray meets nothing
FLOOR_TILE = 0.5  # [m]


@dataclass(frozen=True)
class Box:
    """An axis-aligned box."""

    low: tuple[float, float, float]  # [m]
    high: tuple[float, float, float]  # [m]
    colour: tuple[int, int, int]  # BGR


@dataclass(frozen=True)
class Camera:
    """A pinhole RGB-D camera in the world's origin, looking forward."""

    width: int = 640  # [px]
    height: int = 480  # [px]
    focal: float = 525.0  # [px]
    z: float = 1.63  # [m] over the ground
    pitch: float = 0.17  # [rad] downwards
    max_range: float = 8.0  # [m] of depth along the optical axis

    def rotation(self) -> np.ndarray:
        """R_world_camera (3, 3), from the optical frame (x right, y down, z forward)."""
        c, s = math.cos(self.pitch), math.sin(self.pitch)
        return np.array([[0.0, -s, c], [-1.0, 0.0, 0.0], [0.0, -c, -s]])

    def rays(self) -> np.ndarray:
        """Unit directions (height * width, 3) of all pixels, world frame."""
        u, v = np.meshgrid(np.arange(self.width), np.arange(self.height))
        optical = np.stack(
            [
                (u - (self.width - 1) / 2) / self.focal,
                (v - (self.height - 1) / 2) / self.focal,
                np.ones_like(u, float),
            ],
            axis=-1,
        ).reshape(-1, 3)
        optical /= np.linalg.norm(optical, axis=1, keepdims=True)
        return optical @ self.rotation().T


def _rack(x: float, y: float) -> list[Box]:
    """One bay of a selective rack, 2.6 m long: uprights, shelves, goods."""
    steel, goods = (150, 90, 40), [(70, 130, 180), (90, 150, 190), (60, 110, 150)]
    boxes = [
        Box((x + dx, y + dy, 0.0), (x + dx + 0.08, y + dy + 0.08, 3.0), steel)
        for dx in (0.0, 2.52)
        for dy in (0.0, 0.92)
    ]
    for level in (0.15, 1.35, 2.55):
        boxes.append(Box((x, y, level - 0.1), (x + 2.6, y + 1.0, level), (40, 90, 210)))
        for i in range(3):
            low = (x + 0.12 + 0.82 * i, y + 0.12, level)
            top = level + 0.55 + 0.15 * ((i + round(level)) % 3)
            boxes.append(Box(low, (low[0] + 0.72, y + 0.88, top), goods[i]))
    return boxes


def _aisle() -> list[Box]:
    wall = (190, 195, 195)
    boxes = [
        Box((9.0, -4.0, 0.0), (9.2, 4.0, 3.5), wall),
        Box((-3.2, -4.0, 0.0), (-3.0, 4.0, 3.5), wall),
        Box((1.6, 1.05, 0.0), (2.8, 1.45, 0.14), (80, 140, 190)),  # euro pallet
    ]
    for x in (-2.6, 0.2, 3.0, 5.8):
        boxes += _rack(x, 1.6) + _rack(x, -2.6)
    return boxes


@dataclass
class AnalyticScene:
    """The aisle with three people; one of them walks to and fro across it.

    Args:
        camera: what sees it.
        noise: [m / m^2] depth noise grows with the square of the depth, as structured light's does.
        seed: of that noise.
    """

    camera: Camera = field(default_factory=Camera)
    boxes: list[Box] = field(default_factory=_aisle)
    noise: float = 0.0015
    seed: int = 1

    def __post_init__(self) -> None:
        self._rays = self.camera.rays()
        self._origin = np.array([0.0, 0.0, self.camera.z])
        self._background = self._static()

    def persons(self, time: float) -> list[Person]:
        """Everyone at `time` [s]. The walker is out of sight (behind the rack) part of the time."""
        period, reach, speed = 8.0, 1.05, 0.75
        phase = (time % period) / period
        across = abs(2.0 * phase - 1.0) * 2.0 - 1.0
        heading = -math.pi / 2 if phase < 0.5 else math.pi / 2
        stride = 0.45 * math.sin(2.0 * math.pi * speed * time)
        vest = Clothes(jacket=(40, 220, 230), trousers=(110, 60, 20))
        green = Clothes(jacket=(60, 110, 40), trousers=(60, 60, 60))
        return [
            Person(4.6, reach * across, heading, 1.82, stride, vest),
            Person(3.2, 0.95, math.pi * 0.9, 1.70),
            Person(5.9, -0.75, -math.pi * 0.8, 1.76, 0.12, green),
        ]

    def render(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """What the camera sees at `time` [s].

        Returns:
            depth (height, width) float32 [m], NaN = no return; image (height, width, 3) uint8 BGR.
        """
        distance, image = (layer.copy() for layer in self._background)
        for person in self.persons(time):
            for part in person.capsules():
                self._draw(part, distance, image)
        rng = np.random.default_rng((self.seed, int(time * 1000)))
        forward = self.camera.rotation()[:, 2]
        depth = distance * (self._rays @ forward)
        depth[depth > self.camera.max_range] = np.nan
        depth += self.noise * depth**2 * rng.standard_normal(depth.shape)
        image += rng.normal(0.0, 2.0, image.shape)
        shape = (self.camera.height, self.camera.width)
        pixels = np.clip(image, 0, 255).astype(np.uint8).reshape(*shape, 3)
        return depth.astype(np.float32).reshape(shape), pixels

    def scan(
        self, time: float, angles: np.ndarray, z: float, x: float, max_range: float
    ) -> np.ndarray:
        """Ranges (N,) [m] of a lidar at (x, 0, z) with beams at `angles` [rad]; inf = no return."""
        origin = np.array([x, 0.0, z])
        rays = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
        ranges = np.full(angles.shape, np.inf)
        for solid in self.boxes:
            hit = raycast.box(origin, rays, np.array(solid.low), np.array(solid.high))
            ranges = np.minimum(ranges, hit)
        for person in self.persons(time):
            for part in person.capsules():
                ranges = np.minimum(
                    ranges, raycast.capsule(origin, rays, part.a, part.b, part.radius)
                )
        return np.where(ranges <= max_range, ranges, np.inf)

    def _static(self) -> tuple[np.ndarray, np.ndarray]:
        """Distances and colours of all that does not move."""
        distance = raycast.plane_z(self._origin, self._rays, 0.0)
        meets = np.isfinite(distance)
        image = np.tile(BACKGROUND, (len(self._rays), 1))
        points = self._origin + np.where(meets, distance, 0.0)[:, None] * self._rays
        tile = np.floor(points[:, :2] / FLOOR_TILE).sum(axis=1) % 2
        image[meets] = (150.0 + 14.0 * tile)[meets, None]
        for solid in self.boxes:
            low, high = np.array(solid.low), np.array(solid.high)
            hit = raycast.box(self._origin, self._rays, low, high)
            nearer = hit < distance
            points = self._origin + hit[nearer, None] * self._rays[nearer]
            scaled = (points - 0.5 * (low + high)) / (0.5 * (high - low))
            face = np.argmax(np.abs(scaled), axis=1)
            normals = np.zeros_like(points)
            normals[np.arange(len(face)), face] = np.sign(scaled[np.arange(len(face)), face])
            image[nearer] = _shade(normals, solid.colour)
            distance[nearer] = hit[nearer]
        return distance, image

    def _draw(self, part: Capsule, distance: np.ndarray, image: np.ndarray) -> None:
        window = self._window(part)
        if window.size == 0:
            return
        hit = raycast.capsule(self._origin, self._rays[window], part.a, part.b, part.radius)
        nearer = hit < distance[window]
        at = window[nearer]
        points = self._origin + hit[nearer, None] * self._rays[at]
        axis = part.b - part.a
        along = np.clip((points - part.a) @ axis / (axis @ axis), 0.0, 1.0)
        normals = (points - part.a - along[:, None] * axis) / part.radius
        image[at] = _shade(normals, part.colour)
        distance[at] = hit[nearer]

    def _window(self, part: Capsule) -> np.ndarray:
        """Indices of the pixels of a rectangle that surely holds the capsule's picture."""
        camera = self.camera
        ends = (np.stack([part.a, part.b]) - self._origin) @ camera.rotation()
        depth = ends[:, 2].min() - part.radius
        if depth < 0.1:
            return np.arange(len(self._rays))  # beside or behind the camera: look everywhere
        margin = camera.focal * part.radius / depth * 1.1 + 2.0
        pixels = ends[:, :2] / ends[:, 2:] * camera.focal
        pixels += np.array([(camera.width - 1) / 2, (camera.height - 1) / 2])
        low = np.floor(pixels.min(axis=0) - margin).astype(int)
        high = np.ceil(pixels.max(axis=0) + margin).astype(int) + 1
        columns = np.arange(max(0, low[0]), min(camera.width, high[0]))
        rows = np.arange(max(0, low[1]), min(camera.height, high[1]))
        return (rows[:, None] * camera.width + columns[None, :]).ravel()


def _shade(normals: np.ndarray, colour: tuple[int, int, int]) -> np.ndarray:
    brightness = 0.55 + 0.45 * np.clip(normals @ LIGHT, 0.0, 1.0)
    return brightness[:, None] * np.array(colour, float)
