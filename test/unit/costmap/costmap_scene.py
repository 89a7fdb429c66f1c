"""A small costmap of 20 x 20 cells of 0.1 m, its lower-left corner at (-1, -1)."""

from __future__ import annotations

import numpy as np
from safe_passage.costmap import (
    CostmapParameters,
    FootprintParameters,
    InflationLayerParameters,
    LocalCostmap,
    Observation,
    ObstacleLayerParameters,
    SourceParameters,
)

SCAN = ("obstacle_layer", "scan")
HERE = (0.05, 0.05, 0.0)
TINY_ROBOT = FootprintParameters(robot_radius=0.01, footprint_padding=0.0)


def seen(*points, origin=(0.05, 0.05, 0.2), stamp=0.0):
    return Observation(stamp, origin, np.array(points, dtype=np.float32).reshape(-1, 3))


def make_costmap(source=None, layer=None, inflation=None, footprint=TINY_ROBOT, **window):
    """One LaserScan source named scan that marks and clears, no inflation; each can be changed."""
    source = SourceParameters(
        **{"name": "scan", "data_type": "LaserScan", "clearing": True, **(source or {})}
    )
    layers = (
        ObstacleLayerParameters(sources=(source,), **(layer or {})),
        InflationLayerParameters(**{"inflation_radius": 0.0, **(inflation or {})}),
    )
    window = {
        "width": 2.0, "height": 2.0, "resolution": 0.1, "origin_x": -1.0, "origin_y": -1.0,
        **window,
    }  # fmt: skip
    return LocalCostmap(CostmapParameters(layers=layers, footprint=footprint, **window))
