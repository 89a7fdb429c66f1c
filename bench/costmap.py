"""Benchmark of the local costmap: time, agreement with costmap_2d, life of a circle."""

from __future__ import annotations

import math
import time

import numpy as np

from safe_passage.costmap import (
    CostmapParameters,
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

BEAMS, ANGLE_MIN, ANGLE_INCREMENT, RANGE_MAX = 1081, -2.356194, 0.00436332, 20.0
CIRCLE_X, CIRCLE_RADIUS = 2.5, 1.2  # m, a person ahead and the safety area's radius


def run(quick: bool = False) -> list[dict]:
    """Metrics rows {name, value, unit, bar, holds}; a metric that has no data has value None."""
    appears, gone = circle_updates()
    return [
        _row("costmap_update_ms", update_ms(60 if quick else 400), "ms", 15),
        _row("costmap_reference_mismatch_share", mismatch_share(quick), "share of cells", 0.001),
        _row("circle_appears_updates", appears, "updates", 1),
        _row("circle_gone_updates", gone, "updates", 1),
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
    """Updates until a circle is in the map, and until it is gone, among beams without return."""
    costmap = LocalCostmap(_parameters("front"))
    angles = ANGLE_MIN + np.arange(BEAMS) * ANGLE_INCREMENT
    open_space = np.full(BEAMS, np.inf)
    with np.errstate(invalid="ignore"):
        near = CIRCLE_X * np.cos(angles) - np.sqrt(
            CIRCLE_RADIUS**2 - (CIRCLE_X * np.sin(angles)) ** 2
        )
    circle = np.where(near > 0, near, open_space)
    appears = _updates_until(costmap, circle, lambda lethal: lethal)
    return appears, _updates_until(costmap, open_space, lambda lethal: not lethal)


def _updates_until(costmap: LocalCostmap, ranges: np.ndarray, reached) -> float:
    for count in range(1, 51):
        seen = {("obstacle_layer", "front"): [_observe(ranges, (0.0, 0.0, 0.0), 0.0, 0.0)]}
        costs = costmap.update((0.0, 0.0, 0.0), seen, now=0.0).costs
        if reached(bool((costs == LETHAL_OBSTACLE).any())):
            return count
    return math.inf


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


def _row(name: str, value: float | None, unit: str, most: float) -> dict:
    holds = value is not None and value <= most
    return {"name": name, "value": value, "unit": unit, "bar": f"<= {most}", "holds": holds}


if __name__ == "__main__":
    for row in run():
        print(row)
