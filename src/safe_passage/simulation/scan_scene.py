"""Places made of rectangles, and what a rotating scanner sees of them. Frame: world, z up."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from safe_passage.scan_segmentation.scan import OrganisedScan, to_cartesian
from safe_passage.simulation.raycast import rectangle

FLOOR, WALL, OBSTACLE, HOLE = "floor", "wall", "obstacle", "hole"


@dataclass(frozen=True)
class Patch:
    """A parallelogram."""

    corner: tuple[float, float, float]  # [m]
    along: tuple[float, float, float]  # [m]
    across: tuple[float, float, float]  # [m]
    kind: str = WALL


@dataclass(frozen=True)
class Block:
    """A box that stands in the way: an axis-aligned one."""

    low: tuple[float, float, float]  # [m]
    high: tuple[float, float, float]  # [m]
    kind: str = OBSTACLE


@dataclass(frozen=True)
class Doorway:
    """Its middle on the floor, the way through is along `yaw`."""

    x: float  # [m]
    y: float  # [m]
    yaw: float  # [rad]
    width: float  # [m]
    height: float  # [m]
    thickness: float  # [m]


@dataclass(frozen=True)
class Flight:
    """Stairs that begin at x, y and go up along `yaw`."""

    x: float  # [m]
    y: float  # [m]
    yaw: float  # [rad]
    steps: int
    rise: float  # [m]
    run: float  # [m]
    width: float  # [m]


@dataclass(frozen=True)
class Place:
    """What is there."""

    patches: tuple[Patch, ...] = ()
    blocks: tuple[Block, ...] = ()
    doors: tuple[Doorway, ...] = ()
    flights: tuple[Flight, ...] = ()

    def surfaces(self) -> list[Patch]:
        """All patches, those of the blocks, too."""
        return [*self.patches, *(side for block in self.blocks for side in sides(block))]


@dataclass(frozen=True)
class Scanner:
    """The rotating SICK: half a scan line of 90 degrees about an axis (paper, section II)."""

    position: tuple[float, float, float] = (0.0, 0.0, 1.2)  # [m]
    yaw: float = 0.0  # [rad] of the axis over the floor
    pitch: float = 0.0  # [rad] of the axis downward
    roll: float = 0.0  # [rad] about the axis
    lines: int = 430  # a revolution
    points: int = 180  # a line
    alpha: tuple[float, float] = (0.0, math.pi / 2)  # [rad] of the first and last beam
    noise: float = 0.010  # [m]
    dropout: float = 0.01  # share of beams without return
    max_range: float = 30.0  # [m]

    def rotation(self) -> np.ndarray:
        """R_world_scan: z of the scan's frame is the axis."""
        cy, sy = math.cos(self.yaw), math.sin(self.yaw)
        cp, sp = math.cos(self.pitch), math.sin(self.pitch)
        axis = np.array([cy * cp, sy * cp, -sp])
        left = np.array([-sy, cy, 0.0])
        down = np.cross(axis, left)
        cr, sr = math.cos(self.roll), math.sin(self.roll)
        x = cr * left + sr * down
        return np.stack([x, np.cross(axis, x), axis], axis=1)


def upright(scanner: Scanner) -> Scanner:
    """The same about the vertical, from far down to a little up; the first line is ahead."""
    return replace(scanner, pitch=-math.pi / 2, roll=-math.pi / 2, alpha=(-1.3, 0.27))


def sides(block: Block) -> list[Patch]:
    """Its six."""
    (x0, y0, z0), (x1, y1, z1) = block.low, block.high
    dx, dy, dz = (x1 - x0, 0.0, 0.0), (0.0, y1 - y0, 0.0), (0.0, 0.0, z1 - z0)
    low, high = block.low, block.high
    back = [tuple(-side) for side in np.array([dx, dy, dz])]
    ends: list[tuple] = [(low, dx, dy), (low, dx, dz), (low, dy, dz)]
    ends += [(high, back[0], back[1]), (high, back[0], back[2]), (high, back[1], back[2])]
    return [Patch(c, a, b, block.kind) for c, a, b in ends]


def cast(place: Place, origin: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Exact distances (N,) along unit directions (N, 3), inf: none, and the patch hit, -1: none."""
    nearest = np.full(len(directions), np.inf)
    which = np.full(len(directions), -1)
    for i, patch in enumerate(place.surfaces()):
        found = rectangle(
            origin, directions, *map(np.array, (patch.corner, patch.along, patch.across))
        )
        closer = found < nearest - 1e-9
        nearest[closer], which[closer] = found[closer], i
    return nearest, which


def scan_place(place: Place, scanner: Scanner, seed: int) -> tuple[OrganisedScan, np.ndarray]:
    """One revolution, and for each point (H, W) the index of its surface, -1: no return."""
    rng = np.random.default_rng(seed)
    beta = 2.0 * math.pi * np.arange(scanner.lines) / scanner.lines
    alpha = np.linspace(*scanner.alpha, scanner.points, endpoint=False)
    R = scanner.rotation()
    unit = to_cartesian(np.ones((scanner.lines, scanner.points)), alpha, beta)
    exact, which = cast(place, np.array(scanner.position), unit.reshape(-1, 3) @ R.T)
    exact, which = exact.reshape(unit.shape[:2]), which.reshape(unit.shape[:2])
    lost = (rng.random(exact.shape) < scanner.dropout) | ~(exact <= scanner.max_range)
    measured = exact + rng.normal(0.0, scanner.noise, exact.shape)
    points = to_cartesian(np.where(lost, np.inf, measured), alpha, beta)
    remission = np.where(lost, 0.0, 40.0 + 20.0 * (which % 7) + rng.normal(0, 4, exact.shape))
    up = (float(R[2, 0]), float(R[2, 1]), float(R[2, 2]))
    scan = OrganisedScan(points.astype(np.float32), beta, remission.astype(np.float32), up=up)
    return scan, np.where(lost, -1, which)
