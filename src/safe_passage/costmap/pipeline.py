"""The local costmap: observations and a robot pose in, costs out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping, Sequence, Tuple, Union

import numpy as np

from safe_passage.core.errors import ParameterError
from safe_passage.costmap.costs import FREE_SPACE, NO_INFORMATION
from safe_passage.costmap.footprint import footprint_polygon, inscribed_radius, place_polygon
from safe_passage.costmap.grid import Box, CellBox, RollingGrid
from safe_passage.costmap.inflation_layer import InflationLayer
from safe_passage.costmap.observation import Observation
from safe_passage.costmap.obstacle_layer import ObstacleLayer
from safe_passage.costmap.parameters import CostmapParameters, InflationLayerParameters

SourceKey = Tuple[str, str]  # name of the layer, name of the source in it
Layer = Union[ObstacleLayer, InflationLayer]


@dataclass(frozen=True)
class CostmapUpdate:
    """The costmap after an update."""

    costs: np.ndarray  # (rows, columns) uint8, row = y; a view that the next update changes
    origin: tuple[float, float]  # m, lower-left corner in the global frame
    resolution: float  # m a cell
    changed: CellBox | None  # cells recomputed; None when nothing was
    footprint: np.ndarray  # (N, 2) m, padded outline in the global frame


def _built_of(p: CostmapParameters) -> tuple:
    """What the grids and buffers are made for."""
    layers = [
        (layer.name, layer.enabled, type(layer), [source.name for source in sources])
        for layer in p.layers
        for sources in [getattr(layer, "sources", ())]
    ]
    window = (p.shape, p.resolution, p.origin_x, p.origin_y, p.track_unknown_space)
    return window, p.footprint, p.rolling_window, layers


class LocalCostmap:
    """Stands in for costmap_2d: same parameters, same costs.

    >>> from safe_passage.costmap import CostmapParameters, LocalCostmap
    >>> costmap = LocalCostmap(CostmapParameters(rolling_window=True, width=1, height=1))
    >>> costmap.update((0.0, 0.0, 0.0), {}, now=0.0).costs.shape
    (20, 20)
    """

    def __init__(self, parameters: CostmapParameters) -> None:
        self.parameters = parameters
        self._footprint = footprint_polygon(parameters.footprint)
        default = NO_INFORMATION if parameters.track_unknown_space else FREE_SPACE
        self._master = RollingGrid(
            parameters.shape,
            parameters.resolution,
            (parameters.origin_x, parameters.origin_y),
            default,
        )
        radius = inscribed_radius(self._footprint)
        self._layers: list[Layer] = [
            InflationLayer(layer, parameters.resolution, radius)
            if isinstance(layer, InflationLayerParameters)
            else ObstacleLayer(layer, parameters)
            for layer in parameters.layers
            if layer.enabled
        ]

    def tune(self, parameters: CostmapParameters) -> None:
        """Other parameters from the next update on; what was seen stays.

        Raises:
            ParameterError: window, robot, layers or their sensors would be others.
        """
        old, new = (
            [layer for layer in p.layers if layer.enabled] for p in (self.parameters, parameters)
        )
        if _built_of(self.parameters) != _built_of(parameters):
            raise ParameterError(
                "window, robot, layers and sensors cannot be changed while it runs"
            )
        self.parameters = parameters
        for layer, tuned, known in zip(self._layers, new, old):
            if tuned != known:
                layer.tune(tuned)  # type: ignore[arg-type]

    def update(
        self,
        pose: tuple[float, float, float],
        observations: Mapping[SourceKey, Sequence[Observation]],
        now: float,
    ) -> CostmapUpdate:
        """Roll to the robot, clear, mark, free the footprint, inflate.

        pose: robot in the global frame, x m, y m, yaw rad; observations: what arrived since the
        last update, oldest first, by (layer, source); now: s, on the clock of their stamps.
        Raises KeyError for a source that the parameters do not name, ValueError for a pose that
        is not finite.
        """
        if not np.isfinite(pose).all():
            raise ValueError(f"robot pose {pose}: must be finite")
        footprint = place_polygon(self._footprint, pose)
        self._remember(observations, now)
        self._roll(pose)
        touched = self._clear_and_mark(footprint)
        changed = self._combine_and_inflate(touched, footprint)
        return CostmapUpdate(
            self._master.cells,
            (self._master.origin_x, self._master.origin_y),
            self._master.resolution,
            changed,
            footprint,
        )

    def reset(self) -> None:
        """Forget all observations and costs; the window stays where it is."""
        self._master.cells.fill(self._master.default)
        for layer in self._layers:
            layer.reset()

    def _remember(
        self, observations: Mapping[SourceKey, Sequence[Observation]], now: float
    ) -> None:
        buffers = {
            (layer.parameters.name, name): buffer
            for layer in self._layers
            if isinstance(layer, ObstacleLayer)
            for name, buffer in layer.buffers.items()
        }
        for key, seen in observations.items():
            for observation in seen:
                buffers[key].add(observation, now)

    def _roll(self, pose: tuple[float, float, float]) -> None:
        if not self.parameters.rolling_window:
            return
        self._master.roll_around(pose[0], pose[1])
        for layer in self._layers:
            if isinstance(layer, ObstacleLayer):
                layer.grid.roll_around(pose[0], pose[1])

    def _clear_and_mark(self, footprint: np.ndarray) -> Box:
        """Each layer's new knowledge; returns the area that has to be computed anew."""
        touched = Box()
        for layer in self._layers:
            if isinstance(layer, InflationLayer):
                touched = layer.grow(touched)
                continue
            touched = touched.joined(layer.clear()).joined(layer.mark())
            if layer.parameters.footprint_clearing_enabled:
                touched = touched.touching(footprint[:, 0], footprint[:, 1])
        return touched

    def _combine_and_inflate(self, touched: Box, footprint: np.ndarray) -> CellBox | None:
        box = self._master.cell_box(touched)
        first_column, end_column, first_row, end_row = box
        if end_column <= first_column or end_row <= first_row:
            return None
        self._master.cells[first_row:end_row, first_column:end_column] = self._master.default
        for layer in self._layers:
            if isinstance(layer, InflationLayer):
                layer.inflate(self._master, box)
            else:
                layer.clear_footprint(footprint)
                layer.combine_into(self._master, box)
        return box
