"""What a world's yaml may put into its hall; each element reads its own keys. Frame: map."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from safe_passage.core.errors import ParameterError
from safe_passage.core.geometry import Pose, rotation
from safe_passage.core.parameters import check_choice, check_range
from safe_passage.simulation.blocks import MATERIALS, Hall, Placed

LONGEST_WALL = 1000.0  # [m] between two of its points, as the largest hall


@dataclass(frozen=True)
class RackElement(Placed):
    """A selective rack: bays side by side along its x, front at y = 0, back at +depth."""

    bays: int = 4
    bay: float = 2.7  # [m] clear width of a bay
    depth: float = 1.1  # [m]
    levels: tuple[float, ...] = (1.6, 3.1)  # [m] heights of the shelves
    floor_goods: float = 0.6  # share of the places on the floor that hold a pallet
    shelf_goods: float = 0.8  # the same on the shelves

    def __post_init__(self) -> None:
        check_range("bays", self.bays, 1, 100, "bays")
        check_range("bay", self.bay, 0.5, 10.0, "m")
        check_range("depth", self.depth, 0.3, 10.0, "m")
        check_range("floor_goods", self.floor_goods, 0.0, 1.0, "")
        check_range("shelf_goods", self.shelf_goods, 0.0, 1.0, "")
        if not self.levels or list(self.levels) != sorted(self.levels) or self.levels[0] < 0.2:
            raise ParameterError("levels: one or more heights in m, ascending, from 0.2 m up")

    def build(self, hall: Hall) -> None:
        post, place = 0.10, self.place
        pitch = self.bay + post
        top = self.levels[-1] + 1.2
        for frame in range(self.bays + 1):
            for y in (0.0, self.depth - post):
                hall.add(place, (frame * pitch, y, 0.0), (post, post, top), "steel")
                hall.add(place, (frame * pitch - 0.03, y - 0.03, 0.0), (0.16, 0.16, 0.02), "metal")
            for z in np.arange(0.4, top, 0.9):  # bracing between the two posts
                hall.add(
                    place,
                    (frame * pitch + 0.03, post, float(z)),
                    (0.04, self.depth - 2 * post, 0.05),
                    "steel",
                )
        for bay in range(self.bays):
            x = bay * pitch + post
            for level in self.levels:
                for y in (0.0, self.depth - 0.05):
                    hall.add(place, (x, y, level - 0.12), (self.bay, 0.05, 0.12), "beam")
            for level in (0.0, *self.levels):
                self._fill(hall, place, x, level)

    def _fill(self, hall: Hall, place: Pose, x: float, level: float) -> None:
        """Three pallets fit side by side, their short sides to the aisle."""
        share = self.floor_goods if level == 0.0 else self.shelf_goods
        for slot in range(3):
            filled = hall.rng.random() < share
            middle = np.array([x + self.bay * (slot + 0.5) / 3, 0.02 + 0.6])
            at = np.array(place[:2]) + rotation(self.yaw) @ middle
            pose = (float(at[0]), float(at[1]), self.yaw + math.pi / 2)
            if filled:
                _pallet(hall, pose, level, full=level == 0.0)
                _goods(hall, pose, level + 0.144, most=1.3)
                if level == 0.0:
                    hall.pallets.append(pose)


@dataclass(frozen=True)
class PalletElement(Placed):
    """A loaded euro pallet on the floor, its middle at x, y; +x is along its long side."""

    goods: float = 1.0  # [m] most that is stacked on it, 0: empty

    def __post_init__(self) -> None:
        check_range("goods", self.goods, 0.0, 10.0, "m")

    def build(self, hall: Hall) -> None:
        pose = self.place
        _pallet(hall, pose, 0.0, full=True)
        if self.goods > 0.0:
            _goods(hall, pose, 0.144, most=self.goods)
        hall.pallets.append(pose)


@dataclass(frozen=True)
class BoxElement(Placed):
    """Any block, its middle at x, y."""

    z: float = 0.0  # [m] lower face
    size: tuple[float, float, float] = (0.5, 0.5, 0.5)  # [m]
    material: str = "cardboard"
    shade: float = 1.0

    def __post_init__(self) -> None:
        check_choice("material", self.material, MATERIALS)
        check_range("z", self.z, 0.0, 100.0, "m")
        for side in self.size:
            check_range("size", side, 0.001, 100.0, "m")

    def build(self, hall: Hall) -> None:
        low = (-0.5 * self.size[0], -0.5 * self.size[1], self.z)
        hall.add(self.place, low, self.size, self.material, self.shade)


@dataclass(frozen=True)
class WallElement:
    """A wall along a line of points; an opening is where none goes on, its lintel a wall above."""

    points: tuple[tuple[float, float], ...]  # [m] two or more
    thickness: float = 0.12  # [m]
    z: float = 0.0  # [m] lower face: a lintel's is over 2 m
    height: float = 3.0  # [m] from its lower face
    material: str = "wall"

    def __post_init__(self) -> None:
        check_choice("material", self.material, MATERIALS)
        check_range("thickness", self.thickness, 0.01, 2.0, "m")
        check_range("z", self.z, 0.0, 100.0, "m")
        check_range("height", self.height, 0.01, 100.0, "m")
        apart = [math.dist(a, b) for a, b in zip(self.points, self.points[1:])]
        if not apart or min(apart) < self.thickness or not max(apart) <= LONGEST_WALL:
            raise ParameterError(
                "points: two or more [x, y] in m, farther apart than the thickness, "
                f"no farther than {LONGEST_WALL:g} m"
            )

    def build(self, hall: Hall) -> None:
        half, last = 0.5 * self.thickness, len(self.points) - 2
        for i, (start, end) in enumerate(zip(self.points, self.points[1:])):
            dx, dy = end[0] - start[0], end[1] - start[1]
            first = half if i > 0 else 0.0  # at a bend a piece butts against the one before it,
            more = half if i < last else 0.0  # which closes the corner
            length = math.hypot(dx, dy) - first + more
            place = (*start, math.atan2(dy, dx))
            size = (length, self.thickness, self.height)
            hall.add_wall(place, (first, -half, self.z), size, self.material)


def _pallet(hall: Hall, pose: Pose, z: float, full: bool) -> None:
    """A euro pallet (EN 13698-1), 1.2 x 0.8 x 0.144 m; `full`: with its blocks and lower boards."""
    shade = float(hall.rng.uniform(0.8, 1.05))
    hall.add(pose, (-0.6, -0.4, z + 0.122), (1.2, 0.8, 0.022), "wood", shade)
    for x in (-0.6, -0.0725, 0.455):
        hall.add(pose, (x, -0.4, z + 0.100), (0.145, 0.8, 0.022), "wood", 0.9 * shade)
    for y, width in ((-0.4, 0.1), (-0.0725, 0.145), (0.3, 0.1)):
        hall.add(pose, (-0.6, y, z), (1.2, width, 0.022), "wood", 0.9 * shade)
        for x in (-0.6, -0.0725, 0.455) if full else ():
            hall.add(pose, (x, y, z + 0.022), (0.145, width, 0.078), "wood", 0.8 * shade)


def _goods(hall: Hall, pose: Pose, z: float, most: float) -> None:
    """Layers of cartons, or one crate, on a pallet."""
    rng = hall.rng
    if rng.random() < 0.25:
        size = (1.1, 0.74, most * float(rng.uniform(0.3, 1.0)))
        hall.add(pose, (-0.55, -0.37, z), size, "plastic", float(rng.uniform(0.5, 1.0)))
        return
    nx, ny = int(rng.integers(1, 4)), int(rng.integers(1, 3))
    layers = int(rng.integers(1, 4))
    height = most / 3 * float(rng.uniform(0.6, 1.0))
    for layer in range(layers):
        for i in range(nx):
            for j in range(ny):
                if layer == layers - 1 and rng.random() < 0.25:
                    continue
                slot = np.array([1.16 / nx, 0.76 / ny])
                low = np.array([-0.58, -0.38]) + slot * (i, j) + rng.uniform(0.0, 0.02, 2)
                size = (slot[0] - 0.02, slot[1] - 0.02, height - 0.005)
                shade = float(rng.uniform(0.75, 1.1))
                hall.add(pose, (*low, z + layer * height), size, "cardboard", shade)
