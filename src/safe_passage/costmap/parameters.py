"""Parameters of the local costmap: names, defaults and ranges are those of costmap_2d (noetic)."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Tuple, Union

from safe_passage.core.errors import ParameterError
from safe_passage.core.parameters import check_choice, check_flag, check_range, check_text

Point = Tuple[float, float]

OVERWRITE, MAXIMUM, NOTHING = 0, 1, 99  # combination_method


@dataclass(frozen=True)
class SourceParameters:
    """One sensor topic of an obstacle layer."""

    name: str  # namespace of the source inside its layer
    topic: str = ""  # relative topic name; the source's name when empty
    data_type: str = "PointCloud"  # LaserScan | PointCloud2 | PointCloud
    sensor_frame: str = ""  # frame of the sensor's origin; the message's frame when empty
    observation_persistence: float = 0.0  # s, 0 keeps the newest observation only
    expected_update_rate: float = 0.0  # s between messages, 0 never complains
    min_obstacle_height: float = 0.0  # m in the global frame
    max_obstacle_height: float = 2.0  # m in the global frame
    obstacle_range: float = 2.5  # m from the sensor: nearer points mark
    raytrace_range: float = 3.0  # m from the sensor: cells are cleared up to here
    inf_is_valid: bool = False  # +inf ranges clear (LaserScan only)
    clearing: bool = False  # rays clear the cells they pass
    marking: bool = True  # points mark their cells lethal

    def __post_init__(self) -> None:
        prefix = f"{self.name}/"
        check_text("name of an observation source", self.name)
        check_text(prefix + "topic", self.topic, may_be_empty=True)
        check_text(prefix + "sensor_frame", self.sensor_frame, may_be_empty=True)
        check_choice(
            prefix + "data_type", self.data_type, ("LaserScan", "PointCloud2", "PointCloud")
        )
        for seconds in ("observation_persistence", "expected_update_rate"):
            check_range(prefix + seconds, getattr(self, seconds), 0.0, 3600.0, "s")
        for metres in ("obstacle_range", "raytrace_range"):
            check_range(prefix + metres, getattr(self, metres), 0.0, 1000.0, "m")
        for height in ("min_obstacle_height", "max_obstacle_height"):
            check_range(prefix + height, getattr(self, height), -1e3, 1e3, "m")
        if self.min_obstacle_height > self.max_obstacle_height:
            raise ParameterError(
                f"{prefix}min_obstacle_height = {self.min_obstacle_height} m: must not exceed "
                f"max_obstacle_height = {self.max_obstacle_height} m"
            )
        for flag in ("inf_is_valid", "clearing", "marking"):
            check_flag(prefix + flag, getattr(self, flag))
        if not self.topic:
            object.__setattr__(self, "topic", self.name)


@dataclass(frozen=True)
class ObstacleLayerParameters:
    """costmap_2d::ObstacleLayer."""

    name: str = "obstacle_layer"  # namespace of the layer
    enabled: bool = True  # a disabled layer neither marks nor clears
    sources: tuple[SourceParameters, ...] = ()  # sensors, in the order of observation_sources
    max_obstacle_height: float = 2.0  # m in the global frame, for every source
    footprint_clearing_enabled: bool = True  # the robot's own footprint is free
    combination_method: int = MAXIMUM  # 0 overwrite, 1 maximum, 99 nothing
    track_unknown_space: bool = False  # cells never seen are unknown, not free
    clear_crossed_cells: bool = True  # not in costmap_2d: no stray cell of what left stays

    def __post_init__(self) -> None:
        prefix = f"{self.name}/"
        check_range(prefix + "max_obstacle_height", self.max_obstacle_height, 0.0, 50.0, "m")
        check_choice(
            prefix + "combination_method", self.combination_method, (OVERWRITE, MAXIMUM, NOTHING)
        )
        for flag in (
            "enabled",
            "footprint_clearing_enabled",
            "track_unknown_space",
            "clear_crossed_cells",
        ):
            check_flag(prefix + flag, getattr(self, flag))
        names = [source.name for source in self.sources]
        if len(set(names)) != len(names):
            raise ParameterError(
                f"{prefix}observation_sources = {' '.join(names)!r}: names a source twice"
            )


@dataclass(frozen=True)
class InflationLayerParameters:
    """costmap_2d::InflationLayer."""

    name: str = "inflation_layer"  # namespace of the layer
    enabled: bool = True  # a disabled layer leaves the costs as they are
    inflation_radius: float = 0.55  # m
    cost_scaling_factor: float = 10.0  # 1/m, decay of the cost beyond the inscribed radius
    inflate_unknown: bool = False  # unknown cells take inflated costs below 253 too

    def __post_init__(self) -> None:
        prefix = f"{self.name}/"
        check_range(prefix + "inflation_radius", self.inflation_radius, 0.0, 50.0, "m")
        check_range(prefix + "cost_scaling_factor", self.cost_scaling_factor, 0.0, 100.0, "1/m")
        check_flag(prefix + "enabled", self.enabled)
        check_flag(prefix + "inflate_unknown", self.inflate_unknown)


@dataclass(frozen=True)
class FootprintParameters:
    """The robot's outline in its base frame: a polygon, or a circle when there is none."""

    footprint: tuple[Point, ...] = ()  # m, vertices in order; empty means robot_radius
    robot_radius: float = 0.46  # m
    footprint_padding: float = 0.01  # m, added to each vertex away from the axes

    def __post_init__(self) -> None:
        check_range("robot_radius", self.robot_radius, 0.0, 10.0, "m")
        check_range("footprint_padding", self.footprint_padding, -10.0, 10.0, "m")
        if self.footprint and len(self.footprint) < 3:
            raise ParameterError(
                f"footprint = {self.footprint}: must have at least 3 points [x, y] in m"
            )
        for point in self.footprint:
            if len(point) != 2:
                raise ParameterError(f"footprint point {point}: must be a pair [x, y] in m")
            for coordinate in point:
                check_range("footprint coordinate", coordinate, -1e3, 1e3, "m")


LayerParameters = Union[ObstacleLayerParameters, InflationLayerParameters]


@dataclass(frozen=True)
class CostmapParameters:
    """The whole costmap: window, rates, footprint and the layers in their order."""

    layers: tuple[LayerParameters, ...] = (ObstacleLayerParameters(), InflationLayerParameters())
    footprint: FootprintParameters = FootprintParameters()
    global_frame: str = "map"  # frame of the window and of all observations
    robot_base_frame: str = "base_link"  # frame of the footprint
    rolling_window: bool = False  # the window keeps the robot in its middle
    track_unknown_space: bool = False  # cells never seen are unknown, not free
    always_send_full_costmap: bool = False  # never send updates of a part
    transform_tolerance: float = 0.3  # s, oldest robot pose that is used
    update_frequency: float = 5.0  # Hz
    publish_frequency: float = 0.0  # Hz, 0 publishes nothing
    width: float = 10.0  # m
    height: float = 10.0  # m
    resolution: float = 0.05  # m a cell
    max_observation_age: float = 2.0  # s, not in costmap_2d: older messages are dropped
    origin_x: float = 0.0  # m, first lower-left corner in the global frame
    origin_y: float = 0.0  # m

    def __post_init__(self) -> None:
        check_text("global_frame", self.global_frame)
        check_text("robot_base_frame", self.robot_base_frame)
        for flag in ("rolling_window", "track_unknown_space", "always_send_full_costmap"):
            check_flag(flag, getattr(self, flag))
        check_range("transform_tolerance", self.transform_tolerance, 0.0, 10.0, "s")
        check_range("max_observation_age", self.max_observation_age, 0.0, 3600.0, "s")
        check_range("update_frequency", self.update_frequency, 0.01, 100.0, "Hz")
        check_range("publish_frequency", self.publish_frequency, 0.0, 100.0, "Hz")
        check_range("resolution", self.resolution, 0.001, 50.0, "m")
        for metres in ("width", "height"):
            check_range(metres, getattr(self, metres), self.resolution, 4000 * self.resolution, "m")
        check_range("origin_x", self.origin_x, -1e6, 1e6, "m")
        check_range("origin_y", self.origin_y, -1e6, 1e6, "m")

    @property
    def shape(self) -> tuple[int, int]:
        """Rows (y) and columns (x) of the window, in cells."""
        return int(self.height / self.resolution), int(self.width / self.resolution)

    @property
    def sources(self) -> tuple[tuple[str, SourceParameters], ...]:
        """(name of the layer, source) of each source that an enabled layer listens to."""
        return tuple(
            (layer.name, source)
            for layer in self.layers
            if isinstance(layer, ObstacleLayerParameters) and layer.enabled
            for source in layer.sources
        )


def field_names(parameters: type) -> frozenset:
    """Names of a parameter class's fields."""
    return frozenset(field.name for field in fields(parameters))
