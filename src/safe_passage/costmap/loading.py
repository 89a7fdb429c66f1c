"""Reads the parameters that costmap_2d reads, from the same mapping."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from typing import Any, Mapping, Sequence

from safe_passage.core.errors import ParameterError, shown
from safe_passage.costmap.parameters import (
    CostmapParameters,
    FootprintParameters,
    InflationLayerParameters,
    LayerParameters,
    ObstacleLayerParameters,
    Point,
    SourceParameters,
    field_names,
)

OBSTACLE_TYPE = "costmap_2d::ObstacleLayer"
VOXEL_TYPE = "costmap_2d::VoxelLayer"
INFLATION_TYPE = "costmap_2d::InflationLayer"
FROM_PARENT = {  # costmap_2d lets these override the layer's own
    OBSTACLE_TYPE: (
        "max_obstacle_height",
        "raytrace_range",
        "obstacle_range",
        "track_unknown_space",
    ),
    INFLATION_TYPE: ("cost_scaling_factor", "inflation_radius"),
}
INHERITED_BY_SOURCES = ("raytrace_range", "obstacle_range")
PRE_HYDRO = ("static_map", "map_type")
NODE_KEYS = ("plugins", "footprint", "robot_radius", "footprint_padding")


@dataclass(frozen=True)
class LoadedParameters:
    """Parameters, and everything in the mapping that has no effect or an odd one."""

    parameters: CostmapParameters
    warnings: tuple[str, ...]


def load_costmap_parameters(mapping: Mapping[str, Any]) -> LoadedParameters:
    """Parameters from the contents of costmap_2d's private namespace.

    Plugins and keys that are not known here are named in the warnings. Raises ParameterError,
    naming parameter, unit and range, for values that cannot be used and for a costmap without any
    obstacle layer known here, which would show every cell free.
    """
    reader = _Reader()
    mapping = dict(mapping)
    plugins = reader.plugins(mapping)
    layers = [reader.layer(name, kind, mapping) for name, kind in plugins]
    known = [layer for layer in layers if layer is not None]
    if not any(isinstance(layer, ObstacleLayerParameters) for layer in known):
        raise ParameterError(
            f"plugins = {[kind for _, kind in plugins]}: none is a {OBSTACLE_TYPE}, "
            "so nothing would ever be marked"
        )
    own = field_names(CostmapParameters) - {"layers", "footprint"}
    layer_names = {name for name, _ in plugins}
    used = (
        own | layer_names | set(NODE_KEYS) | {key for keys in FROM_PARENT.values() for key in keys}
    )
    reader.warn_unknown("", mapping, used)
    values = {key: mapping[key] for key in own if key in mapping}
    parameters = CostmapParameters(layers=tuple(known), footprint=_footprint(mapping), **values)
    return LoadedParameters(parameters, tuple(reader.warnings))


class _Reader:
    """Collects warnings while the mapping is taken apart."""

    def __init__(self) -> None:
        self.warnings: list[str] = []

    def plugins(self, mapping: dict[str, Any]) -> list[tuple[str, str]]:
        """(name, type) of each plugin; without `plugins`, the layers of the time before Hydro."""
        if "plugins" not in mapping:
            return self._plugins_before_hydro(mapping)
        for key in PRE_HYDRO:
            if key in mapping:
                self.warnings.append(f"{key}: unused since plugins is given")
                del mapping[key]
        listed = mapping["plugins"]
        usable = isinstance(listed, Sequence) and not isinstance(listed, str)
        if not usable or not all(
            isinstance(p, Mapping) and {"name", "type"} <= set(p) for p in listed
        ):
            raise ParameterError(
                f"plugins is {shown(listed)}, must be a list of {{name: ..., type: ...}}"
            )
        return [(str(plugin["name"]), str(plugin["type"])) for plugin in listed]

    def _plugins_before_hydro(self, mapping: dict[str, Any]) -> list[tuple[str, str]]:
        self.warnings.append("plugins: not given, reading the parameters of the time before Hydro")
        plugins = [("obstacle_layer", OBSTACLE_TYPE), ("inflation_layer", INFLATION_TYPE)]
        if mapping.pop("static_map", False):
            plugins.insert(0, ("static_layer", "costmap_2d::StaticLayer"))
        if mapping.pop("map_type", "costmap") == "voxel":
            plugins[-2] = ("obstacle_layer", VOXEL_TYPE)
        moved = dict(_namespace(mapping, "obstacle_layer"))
        for key in ("observation_sources", *str(mapping.get("observation_sources", "")).split()):
            if key in mapping:
                moved[key] = mapping.pop(key)
        mapping["obstacle_layer"] = moved
        return plugins

    def layer(self, name: str, kind: str, mapping: Mapping[str, Any]) -> LayerParameters | None:
        """Parameters of one plugin, or None (with a warning) when its type is not known."""
        if kind == VOXEL_TYPE:
            self.warnings.append(
                f"plugins: {name} of type {kind} is used as a flat {OBSTACLE_TYPE}: "
                "a ray clears its cells at every height"
            )
            kind = OBSTACLE_TYPE
        if kind not in FROM_PARENT:
            self.warnings.append(f"plugins: {name} of type {kind} is not known and has no effect")
            return None
        values = dict(_namespace(mapping, name))
        for key in FROM_PARENT[kind]:
            if key in mapping:
                if values.get(key, mapping[key]) != mapping[key]:
                    self.warnings.append(
                        f"{name}/{key} = {values[key]}: overridden by the costmap's {mapping[key]}"
                    )
                values[key] = mapping[key]
        if kind == INFLATION_TYPE:
            return self._build(InflationLayerParameters, name, values, set())
        return self._obstacle_layer(name, values, bool(mapping.get("track_unknown_space", False)))

    def _obstacle_layer(
        self, name: str, values: dict[str, Any], track_unknown: bool
    ) -> ObstacleLayerParameters:
        values.setdefault("track_unknown_space", track_unknown)
        listed = values.get("observation_sources", "")
        if not isinstance(listed, str):
            raise ParameterError(
                f"{name}/observation_sources is {shown(listed)}, must be names separated by spaces"
            )
        sources = tuple(self._source(name, source, values) for source in listed.split())
        if not sources:
            self.warnings.append(f"{name}/observation_sources: empty, the layer sees nothing")
        elsewhere = {
            "observation_sources",
            "transform_tolerance",
            *listed.split(),
            *INHERITED_BY_SOURCES,
        }
        return self._build(ObstacleLayerParameters, name, values, elsewhere, sources=sources)

    def _source(self, layer: str, name: str, values: Mapping[str, Any]) -> SourceParameters:
        if name not in values:
            self.warnings.append(f"{layer}/{name}: source without parameters, defaults are used")
        inherited = {key: values[key] for key in INHERITED_BY_SOURCES if key in values}
        source = {**inherited, **_namespace(values, name, layer)}
        built = self._build(SourceParameters, name, source, set(), layer)
        self._warn_of_ghosts(f"{layer}/{name}", built)
        return built

    def _warn_of_ghosts(self, where: str, source: SourceParameters) -> None:
        """Settings with which an obstacle stays in the map after it has left."""
        if source.marking and source.clearing and source.raytrace_range < source.obstacle_range:
            self.warnings.append(
                f"{where}/raytrace_range = {source.raytrace_range} m: below obstacle_range = "
                f"{source.obstacle_range} m, marks beyond it are never cleared"
            )
        if source.clearing and source.data_type == "LaserScan" and not source.inf_is_valid:
            self.warnings.append(
                f"{where}/inf_is_valid: false, beams without return clear nothing and leave ghosts"
            )

    def _build(
        self,
        kind: type,
        name: str,
        values: Mapping[str, Any],
        elsewhere: set,
        above: str = "",
        **extra: Any,
    ) -> Any:
        prefix = f"{above}/{name}/" if above else f"{name}/"
        own = field_names(kind) - {"name", *extra}
        self.warn_unknown(prefix, values, own | elsewhere)
        return kind(name=name, **{key: values[key] for key in own if key in values}, **extra)

    def warn_unknown(self, prefix: str, values: Mapping[str, Any], known: Any) -> None:
        for key in sorted(set(values) - set(known)):
            self.warnings.append(f"{prefix}{key}: not known and without effect")


def _namespace(values: Mapping[str, Any], name: str, above: str = "") -> Mapping[str, Any]:
    inner = values.get(name) or {}
    if not isinstance(inner, Mapping):
        path = f"{above}/{name}" if above else name
        raise ParameterError(f"{path} is {shown(inner)}, must be a namespace of parameters")
    return inner


def _footprint(mapping: Mapping[str, Any]) -> FootprintParameters:
    values = {key: mapping[key] for key in ("robot_radius", "footprint_padding") if key in mapping}
    return FootprintParameters(footprint=_points(mapping.get("footprint", ())), **values)


def _points(value: Any) -> tuple[Point, ...]:
    """Vertices from a list of pairs, or from its text as on the parameter server."""
    try:
        listed = ast.literal_eval(value) if isinstance(value, str) and value else value
        return tuple((float(x), float(y)) for x, y in listed or ())
    except (ValueError, TypeError, SyntaxError):
        raise ParameterError(
            f"footprint is {shown(value)}, must be a list of points [x, y] in m"
        ) from None
