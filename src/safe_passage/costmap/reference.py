"""Recordings of what the real costmap_2d made of given scans, and our costmap fed with the same.

A recording is NAME.npz beside NAME.yaml: steps of one laser scan at one robot pose, and the grid
that the real node published after it; the map carries over from step to step.
"""

from __future__ import annotations

import math
import os
from dataclasses import replace
from pathlib import Path
from typing import Iterator, Sequence

import numpy as np
import yaml

from safe_passage.costmap.loading import load_costmap_parameters
from safe_passage.costmap.observation import Observation
from safe_passage.costmap.parameters import ObstacleLayerParameters
from safe_passage.costmap.pipeline import LocalCostmap
from safe_passage.costmap.projection import project_scan, transform_points, yaw_quaternion
from safe_passage.costmap.publication import occupancy

UPDATES_A_STEP = 20  # two seconds at 10 Hz


def reference_folder() -> Path:
    """Where the recordings are: $SAFE_PASSAGE_DATA, or ../shared/data beside the repository."""
    beside = Path(__file__).resolve().parents[4] / "shared" / "data"
    return Path(os.environ.get("SAFE_PASSAGE_DATA", beside)) / "costmap_reference"


def replay(
    recording: Path,
    updates: int = UPDATES_A_STEP,
    switch: Sequence[float] = (),
    clear_crossed_cells: bool = True,
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yields (ours, recorded) for each step: OccupancyGrid values, (rows, columns) int8.

    recording: path of NAME.npz; updates: costmap updates a step; switch: before a step, the new
    scan is also seen once at this part of the way from the last pose to the new one, for each
    part given (what tf's interpolation makes of a scan that comes while the pose jumps).
    """
    parameters = load_costmap_parameters(
        yaml.safe_load(recording.with_suffix(".yaml").read_text())
    ).parameters
    layer, *others = parameters.layers
    assert isinstance(layer, ObstacleLayerParameters)
    layer = replace(layer, clear_crossed_cells=clear_crossed_cells)
    costmap = LocalCostmap(replace(parameters, layers=(layer, *others)))
    with np.load(recording) as data:
        last = data["step0_pose"]
        for step in range(int(data["steps"])):
            pose = data[f"step{step}_pose"]
            between = [last + part * (pose - last) for part in switch] if step else []
            for seen_from in [*between, *[pose] * updates]:
                seen = _observe(data, step, seen_from, layer)
                x, y, yaw = map(float, seen_from)
                update = costmap.update((x, y, yaw), seen, now=float(step))
            last = pose
            yield occupancy(update.costs), data[f"step{step}_grid"]


def _observe(
    data: np.lib.npyio.NpzFile, step: int, pose: np.ndarray, layer: ObstacleLayerParameters
) -> dict:
    source = layer.sources[0]
    points = project_scan(
        data[f"step{step}_ranges"],
        float(data["angle_min"]),
        float(data["angle_increment"]),
        float(data["range_min"]),
        float(data["range_max"]),
        source.inf_is_valid,
    )
    x, y, z, yaw = map(float, data["laser_in_base"])
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    origin = (float(pose[0] + cos * x - sin * y), float(pose[1] + sin * x + cos * y), z)
    points = transform_points(points, origin, yaw_quaternion(float(pose[2]) + yaw))
    return {(layer.name, source.name): [Observation(float(step), origin, points)]}
