"""Local costmap that stands in for costmap_2d where the navigation stack is not packaged.

observations -> rolling window -> clearing -> marking -> footprint -> inflation -> costs
"""

from safe_passage.core.errors import ParameterError
from safe_passage.costmap.loading import LoadedParameters, load_costmap_parameters
from safe_passage.costmap.observation import Observation
from safe_passage.costmap.parameters import (
    CostmapParameters,
    FootprintParameters,
    InflationLayerParameters,
    ObstacleLayerParameters,
    SourceParameters,
)
from safe_passage.costmap.pipeline import CostmapUpdate, LocalCostmap
from safe_passage.costmap.projection import (
    project_scan,
    quaternion_yaw,
    transform_points,
    yaw_quaternion,
)
from safe_passage.costmap.publication import PublicationArea, occupancy

__all__ = [
    "CostmapParameters",
    "CostmapUpdate",
    "FootprintParameters",
    "InflationLayerParameters",
    "LoadedParameters",
    "LocalCostmap",
    "Observation",
    "ObstacleLayerParameters",
    "ParameterError",
    "PublicationArea",
    "SourceParameters",
    "load_costmap_parameters",
    "occupancy",
    "project_scan",
    "quaternion_yaw",
    "transform_points",
    "yaw_quaternion",
]
