"""Flights of stairs (the paper's future work). Frame: level."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from safe_passage.scan_segmentation.ground import GroundPlane
from safe_passage.scan_segmentation.parameters import RobotConfiguration
from safe_passage.scan_segmentation.scan import unique_cells

SLOPES = (0.36, 1.0)  # rise over run of a flight
RISES = (0.10, 0.25)  # [m] of a step
RUNS = (0.20, 0.45)  # [m] of a step
LEAST_STEPS = 3
LEAST_WIDTH = 0.5  # [m]
HIGHEST = 3.5  # [m] over the ground that is looked at
NEAR = 0.10  # [m] of a step's points from the flight's middle plane
VOXEL = 0.05  # [m] in which points are counted once, so that near ones do not outvote far ones
TRIES = 60_000  # triples of points, most of them too far apart
PLANES = 200  # of them that are counted
COUNTED = 1000  # points that a plane is counted with, and a flight's direction found by
REACH = 1.2  # [m] of a triple
BELOW = 0.08  # [m] of a flight's points under its slope, and over its steps
PATCH = 0.15  # [m] cells in which a flight hangs together
REGULAR = 0.25  # of steps: 1 would be all points on treads and risers, 0 those of a ramp
SUPPORT = 60  # voxels of a flight
SEED = 1


@dataclass(frozen=True)
class Stairs:
    """A flight that goes up from its foot along `yaw`."""

    foot: tuple[float, float, float]  # [m] middle of the first riser, at its bottom
    yaw: float  # [rad] the way up
    steps: int
    rise: float  # [m] of a step
    run: float  # [m] of a step
    width: float  # [m]

    @property
    def slope(self) -> float:
        """[rad] of the line over the steps' edges."""
        return math.atan2(self.rise, self.run)

    def along(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """[m] of points (N, 2 or 3) from the foot: up the flight, and to the left of it."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        x, y = points[:, 0] - self.foot[0], points[:, 1] - self.foot[1]
        return c * x + s * y, c * y - s * x


def find_stairs(points: np.ndarray, ground: GroundPlane, other: np.ndarray) -> list[Stairs]:
    """Flights that go up from the ground.

    A flight's points lie near an inclined plane, and their heights and places along it repeat.

    Args:
        points: (N, 3) [m].
        other: (N,) bool, points of walls, ramps and the ground itself.
    """
    height = points[:, 2] - ground.z(points[:, :2])
    some = (height > 0.03) & (height < HIGHEST) & ~other
    at = np.column_stack([points[some, :2], height[some]])
    at = at[unique_cells(at, VOXEL)[1]]
    found: list[Stairs] = []
    rng = np.random.default_rng(SEED)
    for _ in range(3):
        if len(at) < SUPPORT:
            break
        near = _inclined(at, rng)
        if near is None:
            break
        stairs = _measured(at[near], ground)
        if stairs is not None:
            found.append(stairs)
        at = at[~near]
    return found


def over_stairs(stairs: list[Stairs], points: np.ndarray, robot: RobotConfiguration) -> np.ndarray:
    """[m] of points (N, 3) over the slope of a flight that the robot climbs; NaN: on none."""
    found = np.full(len(points), np.nan)
    for flight in stairs:
        if flight.slope > robot.max_slope or flight.rise > robot.max_obstacle:
            continue
        up, aside = flight.along(points)
        over = points[:, 2] - flight.foot[2] - up * flight.rise / flight.run
        inside = (up > -0.1) & (up < flight.steps * flight.run + 0.05)
        inside &= np.abs(aside) < 0.5 * flight.width + 0.05
        inside &= (over > -BELOW) & (over < flight.rise + BELOW)
        found[inside] = over[inside]
    return found


def _inclined(at: np.ndarray, rng: np.random.Generator) -> np.ndarray | None:
    """(N,) bool: connected points near the inclined plane that has most of them in one place."""
    a, b, c = (at[rng.integers(len(at), size=TRIES)] for _ in range(3))
    normal = np.cross(b - a, c - a)
    together = (np.abs(b - a).max(axis=1) < REACH) & (np.abs(c - a).max(axis=1) < REACH)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = -normal[:, :2] / normal[:, 2:]
        steep = np.hypot(*slope.T)
    usable = together & (steep >= SLOPES[0]) & (steep <= SLOPES[1])
    if not usable.any():
        return None
    some = at[rng.permutation(len(at))[:COUNTED]]
    corners, ways = a[usable][:PLANES], slope[usable][:PLANES]
    support = [_near(some, corner, way).sum() for corner, way in zip(corners, ways)]
    k = int(np.argmax(support))
    best = _near(at, corners[k], ways[k])
    if best.sum() <= SUPPORT:
        return None
    best[best] = _largest_patch(at[best])
    return best if best.sum() > SUPPORT else None


def _near(at: np.ndarray, corner: np.ndarray, way: np.ndarray) -> np.ndarray:
    """(N,) bool: points (N, 3) near the plane through `corner` that climbs by `way`."""
    x, y, z = at[:, 0] - corner[0], at[:, 1] - corner[1], at[:, 2] - corner[2]
    reach = 2.0 * REACH
    return (np.abs(z - x * way[0] - y * way[1]) < NEAR) & (abs(x) < reach) & (abs(y) < reach)


def _largest_patch(at: np.ndarray) -> np.ndarray:
    """(N,) bool: the points that hang together, seen from above, in the largest group."""
    cells = np.floor((at[:, :2] - at[:, :2].min(axis=0)) / PATCH).astype(int)
    image = np.zeros(cells.max(axis=0) + 1, np.uint8)
    image[cells[:, 0], cells[:, 1]] = 1
    patches, _ = ndimage.label(ndimage.binary_closing(np.pad(image, 2), np.ones((3, 3))))
    of = patches[cells[:, 0] + 2, cells[:, 1] + 2]
    return of == np.bincount(of[of > 0], minlength=1).argmax() if of.any() else of > 0


def _measured(at: np.ndarray, ground: GroundPlane) -> Stairs | None:
    """The flight of points (N, 3), z over the ground; None: they are no steps."""
    plane, *_ = np.linalg.lstsq(
        np.column_stack([at[:, :2], np.ones(len(at))]), at[:, 2], rcond=None
    )
    slope = math.hypot(plane[0], plane[1])
    if not 0.8 * SLOPES[0] <= slope <= 1.2 * SLOPES[1]:
        return None
    best = (0.0, 0.0, 0.0)
    some = at[:: max(1, len(at) // COUNTED)]
    for yaw in math.atan2(plane[1], plane[0]) + np.radians(np.arange(-12.0, 12.5, 1.0)):
        s = some[:, 0] * math.cos(yaw) + some[:, 1] * math.sin(yaw)
        score, run = _strongest(s, RUNS)
        if score > best[0]:
            best = (score, run, yaw)
    score_run, run, yaw = best
    score_rise, rise = _strongest(at[:, 2], RISES, from_zero=True)
    if min(score_run, score_rise) < REGULAR or not SLOPES[0] <= rise / run <= SLOPES[1]:
        return None
    s = at[:, 0] * math.cos(yaw) + at[:, 1] * math.sin(yaw)
    aside = at[:, 1] * math.cos(yaw) - at[:, 0] * math.sin(yaw)
    start = _first_riser(s, at[:, 2], rise, run)
    steps = _count(s - start, at[:, 2], rise, run)
    low, high = np.percentile(aside, [1.0, 99.0])
    if steps < LEAST_STEPS or high - low < LEAST_WIDTH:
        return None
    middle = 0.5 * (low + high)
    c, sn = math.cos(yaw), math.sin(yaw)
    x, y = start * c - middle * sn, start * sn + middle * c
    z = float(ground.z(np.array([x, y])))
    yaw = math.remainder(float(yaw), 2.0 * math.pi)
    return Stairs((float(x), float(y), z), yaw, steps, rise, run, float(high - low))


def _strongest(
    values: np.ndarray, periods: tuple[float, float], from_zero: bool = False
) -> tuple[float, float]:
    """How well values repeat, 0 to 1, and the period at which they do best."""
    tried = np.arange(periods[0], periods[1], 0.004 if not from_zero else 0.002)
    waves = np.exp(2j * np.pi * values[:, None] / tried).mean(axis=0)
    strength = waves.real if from_zero else np.abs(waves)
    return float(strength.max()), float(tried[strength.argmax()])


def _first_riser(s: np.ndarray, z: np.ndarray, rise: float, run: float) -> float:
    """[m] along the flight at which it begins."""
    phase = float(np.angle(np.exp(2j * np.pi * s / run).mean())) / (2.0 * np.pi) * run
    # the riser k is where points are half a step over the tread before it
    middle = (z / rise % 1.0 > 0.25) & (z / rise % 1.0 < 0.75)
    number = np.floor(z[middle] / rise)
    first = s[middle] - number * run
    return phase + run * round((float(np.median(first)) - phase) / run)


def _count(s: np.ndarray, z: np.ndarray, rise: float, run: float) -> int:
    """Steps in a row, from the ground up, that have points on their risers or treads."""
    steps = 0
    for k in range(30):
        riser = (np.abs(s - k * run) < 0.2 * run) & (z > (k + 0.2) * rise) & (z < (k + 0.9) * rise)
        tread = (np.abs(z - (k + 1) * rise) < 0.15 * rise) & (s > k * run) & (s < (k + 1) * run)
        if riser.sum() + tread.sum() >= 6:
            steps = k + 1
        elif k > steps:  # two without
            break
    return steps
