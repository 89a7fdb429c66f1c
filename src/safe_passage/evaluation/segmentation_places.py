"""Places with truth for the scan segmentation: a room, the paper's garage, its hallway, any."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from safe_passage.core.geometry import placed
from safe_passage.simulation.scan_scene import (
    FLOOR,
    HOLE,
    OBSTACLE,
    WALL,
    Block,
    Doorway,
    Flight,
    Patch,
    Place,
    Scanner,
)

HIGH = 2.8  # [m] of rooms
THICK = 0.15  # [m] of walls


def floor(x0: float, y0: float, x1: float, y1: float, z: float = 0.0) -> Patch:
    """A level patch."""
    return Patch((x0, y0, z), (x1 - x0, 0.0, 0.0), (0.0, y1 - y0, 0.0), FLOOR)


def wall_with_door(
    x: float, y0: float, y1: float, middle: float, width: float, height: float, thick: float = THICK
) -> tuple[list[Block], Doorway]:
    """A wall across x from y0 to y1 with an opening around `middle`."""
    low, high = middle - width / 2, middle + width / 2
    blocks = [
        Block((x, y0, 0.0), (x + thick, low, HIGH), WALL),
        Block((x, high, 0.0), (x + thick, y1, HIGH), WALL),
    ]
    if height < HIGH:
        blocks.append(Block((x, low, height), (x + thick, high, HIGH), WALL))
    return blocks, Doorway(x, middle, 0.0, width, height, thick)


def shell(x0: float, y0: float, x1: float, y1: float, high: float = HIGH) -> list[Block]:
    """Four walls around."""
    t = THICK
    return [
        Block((x0 - t, y0 - t, 0.0), (x0, y1 + t, high), WALL),
        Block((x1, y0 - t, 0.0), (x1 + t, y1 + t, high), WALL),
        Block((x0 - t, y0 - t, 0.0), (x1 + t, y0, high), WALL),
        Block((x0 - t, y1, 0.0), (x1 + t, y1 + t, high), WALL),
    ]


def ceiling(x0: float, y0: float, x1: float, y1: float, z: float = HIGH) -> Patch:
    """Another level patch, above."""
    return replace(floor(x0, y0, x1, y1, z), kind=WALL)


def room() -> Place:
    """6 m by 5 m with a cupboard and a crate."""
    blocks = shell(-2.0, -2.5, 4.0, 2.5)
    blocks += [Block((2.0, 1.9, 0.0), (3.2, 2.5, 1.8)), Block((2.4, -1.6, 0.0), (3.0, -1.0, 0.6))]
    around = (-2.0, -2.5, 4.0, 2.5)
    return Place((floor(*around), ceiling(*around)), tuple(blocks))


def garage(door_width: float = 0.90, door_height: float = 2.0) -> Place:
    """The paper's garage (fig. 7): a truck beside the robot, an open door in the end wall."""
    x0, y0, x1, y1 = -1.5, -3.0, 4.0, 3.0
    blocks = [*shell(x0, y0, x1, y1)[:1], *shell(x0, y0, x1 + 3.0, y1)[1:]]
    wall, door = wall_with_door(x1, y0, y1, 0.4, door_width, door_height)
    truck = Block((0.5, -2.8, 0.45), (3.6, -1.2, 2.4))
    wheels = [
        Block((x, y, 0.0), (x + 0.7, y + 0.25, 0.8)) for x in (0.8, 2.6) for y in (-2.75, -1.5)
    ]
    around = (x0, y0, x1 + 3.0, y1)
    return Place(
        (floor(*around), ceiling(*around)), (*blocks, *wall, truck, *wheels), doors=(door,)
    )


def hallway(steps: int = 6, rise: float = 0.16, run: float = 0.30, slope: float = 0.12) -> Place:
    """The paper's hallway (fig. 11): a slope on the left, stairs on the right, both up."""
    x0, x1 = 2.5, 2.5 + 2.8
    climb = slope * (x1 - x0)
    ramp = Patch((x0, 0.2, 0.0), (x1 - x0, 0.0, climb), (0.0, 2.3, 0.0), FLOOR)
    flight = Flight(x0, -1.4, 0.0, steps, rise, run, 1.6)
    stairs = [
        Block((x0 + i * run, -2.2, 0.0), (x0 + (i + 1) * run, -0.6, (i + 1) * rise), OBSTACLE)
        for i in range(steps)
    ]
    beyond = x0 + steps * run
    landing = Block((beyond, -2.2, 0.0), (beyond + 2.0, -0.6, steps * rise), OBSTACLE)
    kerb = Block((x0, -0.6, 0.0), (x1, 0.2, climb + 0.9), WALL)
    upper = Block((x1, 0.2, 0.0), (x1 + 2.5, 2.5, climb), FLOOR)
    blocks = [*shell(-2.0, -2.2, 8.0, 2.5, 4.0), *stairs, landing, kerb, upper]
    level = floor(-2.0, -2.2, x0, 2.5)
    return Place((level, ramp, ceiling(-2.0, -2.2, 8.0, 2.5, 4.0)), tuple(blocks), (), (flight,))


@dataclass(frozen=True)
class Case:
    """A random place and the scanner in it."""

    number: int
    place: Place
    scanner: Scanner
    x1: float  # [m] of the wall with the door


def random_case(number: int, seed: int) -> Case:
    """Two rooms, a door of 0.6 m to 1.4 m between them, clutter, a hole or a drop."""
    rng = np.random.default_rng((seed, number))
    x0, x1, x2 = -1.5, float(rng.uniform(2.8, 4.0)), 0.0
    x2 = x1 + 3.2
    y0, y1 = -float(rng.uniform(2.2, 3.2)), float(rng.uniform(2.2, 3.2))
    middle = float(rng.uniform(-0.8, 0.8))
    wall, door = wall_with_door(
        x1, y0, y1, middle, float(rng.uniform(0.6, 1.4)), 2.05, float(rng.uniform(0.1, 0.25))
    )
    blocks = [*shell(x0, y0, x2, y1), *wall]
    keep = [(-1.0, -0.9, 1.2, 0.9), (x1 - 1.6, middle - 1.1, x1 + 2.2, middle + 1.1)]
    for _ in range(int(rng.integers(0, 5))):
        size = rng.uniform([0.2, 0.2, 0.25], [0.8, 0.8, 1.8])
        low = rng.uniform([x0, y0], [x1 - size[0], y1 - size[1]])
        box = (*low, *(low + size[:2]))
        if not any(_overlap(box, other) for other in keep):
            x, y = float(low[0]), float(low[1])
            far = (x + float(size[0]), y + float(size[1]), float(size[2]))
            blocks.append(Block((x, y, 0.0), far))
    patches, pit = _floor_with_hole(rng, (x0, y0, x2, y1), x1, keep)
    patches.append(ceiling(x0, y0, x2, y1))
    scanner = Scanner(
        position=(0.0, 0.0, float(rng.uniform(0.9, 1.4))),
        yaw=float(rng.uniform(-0.5, 0.5)),
        pitch=float(rng.uniform(-0.1, 0.5)),
        roll=float(rng.uniform(-math.pi, math.pi)),
    )
    return Case(number, Place(tuple(patches), (*blocks, *pit), (door,)), scanner, x1)


def _floor_with_hole(
    rng: np.random.Generator, around: tuple, x1: float, keep: list
) -> tuple[list[Patch], list[Block]]:
    """The floor; half the time with a pit in it beside what is kept free."""
    x0, y0, x2, y1 = around
    if rng.random() < 0.5:
        return [floor(*around)], []
    size, depth = rng.uniform(0.4, 1.0, 2), float(rng.uniform(0.3, 2.0))
    for _ in range(20):
        low = rng.uniform([0.8, y0], [x1 - size[0], y1 - size[1]])
        a, b, c, d = (float(v) for v in (*low, *(low + size)))
        if not any(_overlap((a, b, c, d), other) for other in keep):
            break
    else:
        return [floor(*around)], []
    patches = [floor(x0, y0, a, y1), floor(c, y0, x2, y1), floor(a, y0, c, b), floor(a, d, c, y1)]
    return patches, [Block((a, b, -depth), (c, d, -depth), HOLE), *_pit_walls(a, b, c, d, depth)]


def _pit_walls(a: float, b: float, c: float, d: float, depth: float) -> list[Block]:
    flat = [((a, b), (a, d)), ((c, b), (c, d)), ((a, b), (c, b)), ((a, d), (c, d))]
    return [Block((*p, -depth), (*q, 0.0), HOLE) for p, q in flat]


def _overlap(a: tuple, b: tuple) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def blocked_at(place: Place, points: np.ndarray, low: float, high: float) -> np.ndarray:
    """(N,) whether blocks stand between two heights over points (N, 2), or a hole is there."""
    found = np.zeros(len(points), bool)
    for block in place.blocks:
        (x0, y0, z0), (x1, y1, z1) = block.low, block.high
        inside = (points[:, 0] > x0) & (points[:, 0] < x1)
        inside &= (points[:, 1] > y0) & (points[:, 1] < y1)
        hole = block.kind == HOLE
        if block.kind != FLOOR and (hole or (z0 < high and z1 > low)):
            found |= inside
    return found


def in_world(scanner: Scanner, points: np.ndarray) -> np.ndarray:
    """Points (N, 2) of the level frame under the scanner, x as its axis, in the world."""
    return placed(points, (scanner.position[0], scanner.position[1], scanner.yaw))
