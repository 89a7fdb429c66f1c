"""Worlds from yaml: halls of blocks (racks, pallets, goods, benches, walls) and the people in them.

Frame: map, x and y on the floor, z up, metres and radians (REP 103).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Mapping, Sequence

import numpy as np
import yaml

from safe_passage.core.errors import InputError, ParameterError
from safe_passage.core.geometry import Pose, rotation
from safe_passage.core.parameters import check_choice, check_range, from_mapping

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

    def corners(self) -> np.ndarray:
        """Outline (4, 2) [m] on the floor."""
        half = 0.5 * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * self.size[:2]
        return np.array([self.x, self.y]) + half @ rotation(self.yaw).T


@dataclass(frozen=True)
class PersonPlan:
    """Who is there and where it walks; with one way-point it stands."""

    body: str = ""  # name of a body of people_assets; empty: one after the other
    waypoints: tuple[tuple[float, float], ...] = ((0.0, 0.0),)  # [m]
    speed: float = 1.1  # [m/s] between way-points
    yaw: float = 0.0  # [rad] it faces while it stands
    start: float = 0.0  # [m] along its way at time 0
    pause: float = 0.0  # [s] at each end of the way

    def __post_init__(self) -> None:
        check_range("speed", self.speed, 0.05, 3.0, "m/s")
        check_range("pause", self.pause, 0.0, 3600.0, "s")
        if not self.waypoints or any(len(point) != 2 for point in self.waypoints):
            raise ParameterError("waypoints: one or more pairs [x, y] in m")
        object.__setattr__(
            self, "waypoints", tuple((float(x), float(y)) for x, y in self.waypoints)
        )


@dataclass(frozen=True)
class World:
    """A hall, lit, and what is in it."""

    name: str
    size: tuple[float, float]  # [m] of the hall, x by y, its middle in the origin
    blocks: tuple[Block, ...]
    pallets: tuple[Pose, ...]  # those on the floor: middle of the pallet, +x away from the aisle
    people: tuple[PersonPlan, ...]
    start: Pose  # of the robot
    lights: tuple[tuple[float, float, float], ...]  # [m] lamps


@dataclass
class _Hall:
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


# ---- elements: each reads its own keys ----------------------------------------------------------


@dataclass(frozen=True)
class RackElement:
    """A selective rack: bays side by side along its x, front at y = 0, back at +depth."""

    x: float
    y: float
    yaw: float = 0.0
    bays: int = 4
    bay: float = 2.7  # [m] clear width of a bay
    depth: float = 1.1  # [m]
    levels: tuple[float, ...] = (1.6, 3.1)  # [m] heights of the shelves
    floor_goods: float = 0.6  # share of the places on the floor that hold a pallet
    shelf_goods: float = 0.8  # the same on the shelves

    def build(self, hall: _Hall) -> None:
        post, place = 0.10, (self.x, self.y, self.yaw)
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

    def _fill(self, hall: _Hall, place: Pose, x: float, level: float) -> None:
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
class PalletElement:
    """A loaded euro pallet on the floor, its middle at x, y; +x is along its long side."""

    x: float
    y: float
    yaw: float = 0.0
    goods: float = 1.0  # [m] most that is stacked on it, 0: empty

    def build(self, hall: _Hall) -> None:
        pose = (self.x, self.y, self.yaw)
        _pallet(hall, pose, 0.0, full=True)
        if self.goods > 0.0:
            _goods(hall, pose, 0.144, most=self.goods)
        hall.pallets.append(pose)


@dataclass(frozen=True)
class BoxElement:
    """Any block, its middle at x, y."""

    x: float
    y: float
    yaw: float = 0.0
    z: float = 0.0  # [m] lower face
    size: tuple[float, float, float] = (0.5, 0.5, 0.5)  # [m]
    material: str = "cardboard"
    shade: float = 1.0

    def build(self, hall: _Hall) -> None:
        check_choice("material", self.material, MATERIALS)
        low = (-0.5 * self.size[0], -0.5 * self.size[1], self.z)
        hall.add((self.x, self.y, self.yaw), low, self.size, self.material, self.shade)


@dataclass(frozen=True)
class BenchElement:
    """A work bench: a plate on four legs, tools on it."""

    x: float
    y: float
    yaw: float = 0.0
    length: float = 1.8  # [m]
    depth: float = 0.8  # [m]
    height: float = 0.9  # [m]

    def build(self, hall: _Hall) -> None:
        place = (self.x, self.y, self.yaw)
        a, b = 0.5 * self.length, 0.5 * self.depth
        hall.add(place, (-a, -b, self.height - 0.05), (2 * a, 2 * b, 0.05), "wood")
        for x in (-a + 0.02, a - 0.08):
            for y in (-b + 0.02, b - 0.08):
                hall.add(place, (x, y, 0.0), (0.06, 0.06, self.height - 0.05), "metal")
        for _ in range(3):
            size = hall.rng.uniform(0.12, 0.35, 3)
            low = hall.rng.uniform((-a, -b), (a - size[0], b - size[1]))
            hall.add(place, (*low, self.height), size, "plastic", float(hall.rng.uniform(0.5, 1.0)))


def _pallet(hall: _Hall, pose: Pose, z: float, full: bool) -> None:
    """A euro pallet (EN 13698-1), 1.2 x 0.8 x 0.144 m; `full`: with its blocks and lower boards."""
    shade = float(hall.rng.uniform(0.8, 1.05))
    hall.add(pose, (-0.6, -0.4, z + 0.122), (1.2, 0.8, 0.022), "wood", shade)
    for x in (-0.6, -0.0725, 0.455):
        hall.add(pose, (x, -0.4, z + 0.100), (0.145, 0.8, 0.022), "wood", 0.9 * shade)
    for y, width in ((-0.4, 0.1), (-0.0725, 0.145), (0.3, 0.1)):
        hall.add(pose, (-0.6, y, z), (1.2, width, 0.022), "wood", 0.9 * shade)
        for x in (-0.6, -0.0725, 0.455) if full else ():
            hall.add(pose, (x, y, z + 0.022), (0.145, width, 0.078), "wood", 0.8 * shade)


def _goods(hall: _Hall, pose: Pose, z: float, most: float) -> None:
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


ELEMENTS: Mapping[str, Any] = {
    "racks": RackElement,
    "pallets": PalletElement,
    "boxes": BoxElement,
    "benches": BenchElement,
}
OTHER_KEYS = {"name", "size", "wall_height", "start", "lights", "people", "seed"}


def load_world(path: Path) -> World:
    """Read a world.

    Raises:
        InputError: the file cannot be read. ParameterError: names the element and key at fault.
    """
    try:
        values = yaml.safe_load(path.read_text())
    except (OSError, yaml.YAMLError) as error:
        raise InputError(f"{path}: {error}") from None
    if not isinstance(values, dict):
        raise InputError(f"{path}: not a mapping")
    return make_world(values, str(path))


def make_world(values: Mapping[str, Any], where: str = "world") -> World:
    """Build a world of the yaml's contents; ParameterError names what is wrong in it."""
    unknown = set(values) - OTHER_KEYS - set(ELEMENTS)
    if unknown:
        known = ", ".join(sorted(OTHER_KEYS | set(ELEMENTS)))
        raise ParameterError(f"{where}: {sorted(unknown)[0]} is not known; known are: {known}")
    missing = {"name", "size", "start"} - set(values)
    if missing:
        raise ParameterError(f"{where}: {sorted(missing)[0]} is missing")
    hall = _Hall(np.random.default_rng(values.get("seed", 0)))
    for kind, element in ELEMENTS.items():
        for i, entry in enumerate(values.get(kind) or ()):
            from_mapping(element, entry, f"{where}/{kind}[{i}]").build(hall)
    size = _numbers(values, "size", 2, where)
    _walls(hall, size, float(values.get("wall_height", 4.0)))
    people = tuple(
        from_mapping(PersonPlan, entry, f"{where}/people[{i}]")
        for i, entry in enumerate(values.get("people") or ())
    )
    lights = tuple(tuple(map(float, light)) for light in values.get("lights") or ((0, 0, 4),))
    start = _numbers(values, "start", 3, where)
    name = str(values["name"])
    blocks, pallets = tuple(hall.blocks), tuple(hall.pallets)
    return World(name, size, blocks, pallets, people, start, lights)  # type: ignore[arg-type]


def _numbers(values: Mapping[str, Any], key: str, count: int, where: str) -> Any:
    listed = values[key]
    if not isinstance(listed, Sequence) or len(listed) != count:
        raise ParameterError(f"{where}: {key} is {listed!r}, must be {count} numbers")
    for value in listed:
        check_range(f"{where}: {key}", value, -1000.0, 1000.0, "")
    return tuple(map(float, listed))


def _walls(hall: _Hall, size: tuple[float, float], height: float) -> None:
    a, b = 0.5 * size[0], 0.5 * size[1]
    for yaw, half, gap in (
        (0.0, a, b),
        (math.pi, a, b),
        (0.5 * math.pi, b, a),
        (-0.5 * math.pi, b, a),
    ):
        panels = math.ceil(2 * half / PANEL)
        width = 2 * half / panels
        for i in range(panels):
            hall.add((0.0, 0.0, yaw), (i * width - half, gap, 0.0), (width, 0.2, height), "wall")
