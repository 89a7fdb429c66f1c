"""Blocks, of which all that stands still is made, and the hall they are put into. Frame: map."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Sequence

import numpy as np

from safe_passage.core.geometry import Pose, rotation

MATERIALS = (
    "concrete",
    "wall",
    "steel",  # rack uprights
    "beam",  # rack beams
    "wood",
    "cardboard",
    "plastic",
    "metal",
)
PANEL = 3.0  # [m] most that a panel of a wall is wide


@dataclass(frozen=True)
class Block:
    """An upright box."""

    x: float  # [m] centre
    y: float  # [m] centre
    z: float  # [m] lower face
    yaw: float  # [rad]
    size: tuple[float, float, float]  # [m] along its own x, y, z
    material: str
    shade: float = 1.0  # of the material's colour

    def corners(self, inset: float = 0.0) -> np.ndarray:
        """Outline (4, 2) [m] on the floor, by up to `inset` [m] within it."""
        half = 0.5 * np.array(self.size[:2])
        half -= np.minimum(inset, half)
        signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
        return np.array([self.x, self.y]) + signs * half @ rotation(self.yaw).T


@dataclass(frozen=True)
class Placed:
    """An element with a place on the floor."""

    x: float  # [m]
    y: float  # [m]
    yaw: float = 0.0  # [rad]

    @property
    def place(self) -> Pose:
        return self.x, self.y, self.yaw


@dataclass
class Hall:
    """What elements of the yaml are built into."""

    rng: np.random.Generator
    blocks: list[Block] = field(default_factory=list)
    pallets: list[Pose] = field(default_factory=list)

    def add(
        self,
        place: Pose,
        low: Sequence[float],
        size: Sequence[float] | np.ndarray,
        material: str,
        shade: float = 1.0,
    ) -> None:
        """A block by its lowest corner `low` [m] in the frame of `place`."""
        centre = np.array(low[:2]) + 0.5 * np.array(size[:2])
        x, y = np.array(place[:2]) + rotation(place[2]) @ centre
        dimensions = (float(size[0]), float(size[1]), float(size[2]))
        self.blocks.append(
            Block(float(x), float(y), float(low[2]), place[2], dimensions, material, shade)
        )

    def add_wall(
        self, place: Pose, low: Sequence[float], size: Sequence[float], material: str = "wall"
    ) -> None:
        """A block that is long in x, of panels that are at most PANEL wide."""
        panels = math.ceil(size[0] / PANEL)
        width = size[0] / panels
        for i in range(panels):
            start = (low[0] + i * width, low[1], low[2])
            self.add(place, start, (width, size[1], size[2]), material)
