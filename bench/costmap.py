"""Benchmark of the local costmap: time, agreement with costmap_2d, life of a circle."""

from __future__ import annotations

import math
import time
from typing import Callable

import numpy as np
from safe_passage.costmap import (
    CostmapParameters,
    CostmapUpdate,
    InflationLayerParameters,
    LocalCostmap,
    Observation,
    ObstacleLayerParameters,
    SourceParameters,
    project_scan,
    transform_points,
    yaw_quaternion,
)
from safe_passage.costmap.costs import LETHAL_OBSTACLE
from safe_passage.costmap.reference import reference_folder, replay

from bench.metric import metric

BEAMS, ANGLE_MIN, ANGLE_INCREMENT, RANGE_MAX = 1081, -2.356194, 0.00436332, 20.0
CIRCLE_RADIUS = 1.2  # m, of a person's safety area
HERE = (0.0, 0.0, 0.0)


def run(quick: bool = False) -> list[dict]:
    """All rows; a metric that has no data has value None."""
    appears, gone = circle_updates()
    return [
        metric("costmap_update_ms", update_ms(60 if quick else 400), "ms", "<= 15"),
        metric(
            "costmap_reference_mismatch_share", mismatch_share(quick), "share of cells", "<= 0.001"
        ),
        metric("circle_appears_updates", appears, "updates", "<= 1"),
        metric("circle_gone_updates", gone, "updates", "<= 1"),
    ]


def update_ms(updates: int) -> float:
    """Median time of an update: 160 x 160 cells, two scanners of 1081 beams, a moving robot."""
    costmap = LocalCostmap(_parameters("front", "rear"))
    rng = np.random.default_rng(1)
    times = []
    for i in range(updates + 20):
        pose = (0.02 * i, 0.3 * math.sin(0.02 * i), 0.01 * i)
        seen = {
            ("obstacle_layer", name): [_observe(_room(pose[2] + turn, rng), pose, turn, 0.1 * i)]
            for name, turn in (("front", 0.0), ("rear", math.pi))
        }
        start = time.perf_counter()
        costmap.update(pose, seen, now=0.1 * i)
        times.append(time.perf_counter() - start)
    return 1e3 * float(np.median(times[20:]))


def mismatch_share(quick: bool) -> float | None:
    """Share of cells that differ from the recorded costmap_2d, over all files and steps."""
    different = cells = 0
    for recording in sorted(reference_folder().glob("*.npz")):
        for ours, recorded in replay(recording, updates=2 if quick else 20):
            different += int((ours != recorded).sum())
            cells += ours.size
    return different / cells if cells else None


def circle_updates() -> tuple[float, float]:
    """Updates until a circle is in the map and until no cell of it is left: the worst of many.

    Circles at various places, in front of walls and of beams without return. A circle is there
    when every beam that hits it has its cell lethal, gone when the map is what it was before.
    """
    rng = np.random.default_rng(2)
    lives = [
        _life_of_circle(rng.uniform(1.8, 4.0), rng.uniform(-2.2, 2.2), behind)
        for behind in (np.inf, 3.5)
        for _ in range(50)
    ]
    return max(appears for appears, _ in lives), max(gone for _, gone in lives)


def _life_of_circle(distance: float, bearing: float, behind: float) -> tuple[float, float]:
    costmap, empty = LocalCostmap(_parameters("front")), np.full(BEAMS, behind)
    angles = ANGLE_MIN + np.arange(BEAMS) * ANGLE_INCREMENT - bearing
    offset = distance * np.sin(angles)
    hit = (np.abs(offset) < CIRCLE_RADIUS) & (np.cos(angles) > 0)
    depth = np.sqrt(np.where(hit, CIRCLE_RADIUS**2 - offset**2, 0.0))
    circle = np.minimum(np.where(hit, distance * np.cos(angles) - depth, behind), behind)
    before = _update(costmap, empty).costs.copy()
    there = _observe(np.where(circle < behind, circle, np.nan), HERE, 0.0, 0.0).points

    def whole(update: CostmapUpdate) -> bool:
        columns = np.floor((there[:, 0] - update.origin[0]) / update.resolution).astype(int)
        rows = np.floor((there[:, 1] - update.origin[1]) / update.resolution).astype(int)
        inside = (np.minimum(columns, rows) >= 0) & (np.maximum(columns, rows) < 160)
        return bool((update.costs[rows[inside], columns[inside]] == LETHAL_OBSTACLE).all())

    appears = _updates_until(costmap, circle, whole)
    return appears, _updates_until(costmap, empty, lambda u: np.array_equal(u.costs, before))


def _updates_until(
    costmap: LocalCostmap, ranges: np.ndarray, reached: Callable[[CostmapUpdate], bool]
) -> float:
    return next((n for n in range(1, 51) if reached(_update(costmap, ranges))), math.inf)


def _update(costmap: LocalCostmap, ranges: np.ndarray) -> CostmapUpdate:
    seen = {("obstacle_layer", "front"): [_observe(ranges, HERE, 0.0, 0.0)]}
    return costmap.update(HERE, seen, now=0.0)


def _parameters(*names: str) -> CostmapParameters:
    sources = tuple(
        SourceParameters(
            name,
            data_type="LaserScan",
            clearing=True,
            inf_is_valid=True,
            obstacle_range=5.0,
            raytrace_range=6.0,
        )
        for name in names
    )
    layers = (ObstacleLayerParameters(sources=sources), InflationLayerParameters())
    return CostmapParameters(layers=layers, rolling_window=True, width=8.0, height=8.0)


def _room(heading: float, rng: np.random.Generator) -> np.ndarray:
    """Ranges in a room of 6 x 7.4 m with noise, a pillar and beams without return."""
    angles = ANGLE_MIN + np.arange(BEAMS) * ANGLE_INCREMENT + heading
    far = 1e-9
    ranges = np.minimum(
        3.0 / np.maximum(np.abs(np.cos(angles)), far), 3.7 / np.maximum(np.abs(np.sin(angles)), far)
    )
    ranges += rng.normal(0.0, 0.02, BEAMS)
    ranges[400:480] = 1.5
    ranges[rng.integers(0, BEAMS, 200)] = np.inf
    return ranges


def _observe(ranges: np.ndarray, pose: tuple, turn: float, stamp: float) -> Observation:
    origin = (pose[0], pose[1], 0.12)
    points = project_scan(ranges, ANGLE_MIN, ANGLE_INCREMENT, 0.05, RANGE_MAX, inf_is_valid=True)
    return Observation(
        stamp, origin, transform_points(points, origin, yaw_quaternion(pose[2] + turn))
    )
