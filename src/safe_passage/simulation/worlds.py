"""Worlds from yaml: halls of blocks (racks, pallets, goods, benches, walls) and the people in them.

Frame: map, x and y on the floor, z up, metres and radians (REP 103).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Mapping

import numpy as np

from safe_passage.core.errors import ParameterError
from safe_passage.core.geometry import Pose
from safe_passage.core.parameters import check_range
from safe_passage.core.reading import build, build_list, read_yaml
from safe_passage.simulation.blocks import MATERIALS, Block, Hall
from safe_passage.simulation.elements import BoxElement, PalletElement, RackElement, WallElement
from safe_passage.simulation.furniture import (
    BenchElement,
    CabinetElement,
    MachineElement,
    ShelfElement,
    StoolElement,
    TrolleyElement,
)

__all__ = ["MATERIALS", "Block", "PersonPlan", "World", "load_world", "make_world"]

ELEMENTS: Mapping[str, Any] = {  # in the order in which they draw from the seed
    "racks": RackElement,
    "pallets": PalletElement,
    "boxes": BoxElement,
    "benches": BenchElement,
    "walls": WallElement,
    "cabinets": CabinetElement,
    "shelves": ShelfElement,
    "machines": MachineElement,
    "trolleys": TrolleyElement,
    "stools": StoolElement,
}


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
        check_range("start", self.start, 0.0, 1e6, "m")
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


@dataclass(frozen=True)
class _Head:
    """What a world's yaml says besides its elements and people."""

    name: str
    size: tuple[float, float]  # [m]
    start: tuple[float, float, float]
    wall_height: float = 4.0  # [m] of the hall's own walls
    lights: tuple[tuple[float, float, float], ...] = ((0.0, 0.0, 4.0),)  # [m]
    seed: int = 0  # of the goods

    def __post_init__(self) -> None:
        for side in self.size:
            check_range("size", side, 1.0, 1000.0, "m")
        check_range("wall_height", self.wall_height, 0.1, 100.0, "m")
        check_range("seed", self.seed, 0, 2**32, "")


def load_world(path: Path) -> World:
    """Read a world.

    Raises:
        InputError: the file cannot be read. ParameterError: names the element and key at fault.
    """
    return make_world(read_yaml(path), str(path))


def make_world(values: Mapping[str, Any], where: str = "world") -> World:
    """Build a world of the yaml's contents; ParameterError names what is wrong in it."""
    head_keys = set(_Head.__dataclass_fields__)
    unknown = set(values) - head_keys - set(ELEMENTS) - {"people"}
    if unknown:
        known = ", ".join(sorted(head_keys | set(ELEMENTS) | {"people"}))
        raise ParameterError(f"{where}: {min(map(str, unknown))} is not known; known are: {known}")
    head = build(_Head, {key: values[key] for key in head_keys & set(values)}, where)
    hall = Hall(np.random.default_rng(head.seed))
    for kind, element in ELEMENTS.items():
        for one in build_list(element, values.get(kind), f"{where}/{kind}"):
            one.build(hall)
    _add_outer_walls(hall, head.size, head.wall_height)
    people = build_list(PersonPlan, values.get("people"), f"{where}/people")
    blocks, pallets = tuple(hall.blocks), tuple(hall.pallets)
    return World(head.name, head.size, blocks, pallets, people, head.start, head.lights)


def _add_outer_walls(hall: Hall, size: tuple[float, float], height: float) -> None:
    a, b = 0.5 * size[0], 0.5 * size[1]
    for yaw, half, gap in (
        (0.0, a, b),
        (math.pi, a, b),
        (0.5 * math.pi, b, a),
        (-0.5 * math.pi, b, a),
    ):
        hall.add_wall((0.0, 0.0, yaw), (-half, gap, 0.0), (2 * half, 0.2, height))
