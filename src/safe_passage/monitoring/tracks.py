"""All tracked objects, side by side in arrays."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from safe_passage.monitoring.hypotheses import Features
from safe_passage.monitoring.parameters import TrackerParameters


@dataclass(frozen=True)
class Tracks:
    """N objects. Frame base, unless said otherwise.

    The state is that of a point of the object; `offset` leads from it to the centroid of what is
    seen of the object now. Without shape alignment the two are the same.
    """

    id: np.ndarray  # (N,) int, from 1, never used twice
    x: np.ndarray  # (N, 4) [m, m/s] position and velocity over ground
    P: np.ndarray  # (N, 4, 4) covariance
    offset: np.ndarray  # (N, 2) [m]
    origin: np.ndarray  # (N, 2) [m] where the point was when the track began
    extent: np.ndarray  # (N, 2, 2) [m^2] second moment of the cells
    cells: np.ndarray  # (N,) occupied cells
    counts: np.ndarray  # (N, S) points of each sensor
    height: np.ndarray  # (N, 2) [m] lowest and highest point, NaN: unknown
    born: np.ndarray  # (N,) [s]
    hits: np.ndarray  # (N,) cycles with an observation
    misses: np.ndarray  # (N,) cycles since the last
    fast: np.ndarray  # (N,) cycles in a row that looked like motion
    moving: np.ndarray  # (N,) bool, latched
    shapes: list[np.ndarray]  # N of (M, 2) [m] from the point to the cells, axes of the odometry

    def __len__(self) -> int:
        return len(self.id)

    @property
    def position(self) -> np.ndarray:
        """(N, 2) [m] centroid of what is seen."""
        return self.x[:, :2] + self.offset

    @property
    def velocity(self) -> np.ndarray:
        """(N, 2) [m/s] over ground."""
        return self.x[:, 2:]

    def keep(self, which: np.ndarray) -> Tracks:
        """Those of the mask `which` (N,)."""
        arrays = {f.name: getattr(self, f.name)[which] for f in fields(self) if f.name != "shapes"}
        shapes = [shape for shape, kept in zip(self.shapes, which) if kept]
        return Tracks(**arrays, shapes=shapes)

    def join(self, others: Tracks) -> Tracks:
        """These and then `others`."""
        arrays = {
            f.name: np.concatenate([getattr(self, f.name), getattr(others, f.name)])
            for f in fields(self)
            if f.name != "shapes"
        }
        return Tracks(**arrays, shapes=self.shapes + others.shapes)

    def with_(self, **changes: object) -> Tracks:
        """A copy with these arrays in place of its own."""
        return replace(self, **changes)  # type: ignore[arg-type]


def new_tracks(
    features: Features,
    shapes: list[np.ndarray],
    first_id: int,
    stamp: float,
    parameters: TrackerParameters,
) -> Tracks:
    """A track of each observation; it stands, as far as one can know."""
    count = len(features.position)
    x = np.zeros((count, 4))
    x[:, :2] = features.position
    P = np.zeros((count, 4, 4))
    P[:, :2, :2] = centroid_noise(features.extent, parameters, compact=True)
    P[:, [2, 3], [2, 3]] = parameters.initial_speed**2
    zero = np.zeros(count, np.int64)
    return Tracks(
        np.arange(first_id, first_id + count),
        x,
        P,
        np.zeros((count, 2)),
        features.position.copy(),
        features.extent,
        features.cells,
        features.counts,
        features.height,
        np.full(count, stamp),
        zero + 1,
        zero,
        zero,
        np.zeros(count, bool),
        shapes,
    )


def no_tracks(sensors: int) -> Tracks:
    """None yet."""
    none = np.empty(0)
    features = Features(
        np.empty((0, 2)),
        np.empty((0, 2, 2)),
        np.empty(0, np.int64),
        np.empty((0, sensors), np.int64),
        np.empty((0, 2)),
        none,
    )
    return new_tracks(features, [], 1, 0.0, TrackerParameters())


def centroid_noise(
    extent: np.ndarray, parameters: TrackerParameters, compact: bool = False
) -> np.ndarray:
    """(N, 2, 2) [m^2] how uncertain the centroid of what is seen is as a point of the object.

    Of a large object different parts are seen from different places; the uncertainty grows with the
    square of its extent, so that a person's stays that of the sensors and a wall's says nothing
    along the wall. compact: without that part.
    """
    noise = np.broadcast_to(parameters.position_noise**2 * np.eye(2), extent.shape)
    return noise if compact else noise + extent @ extent / parameters.extent_scale**2
