"""All tracked objects, side by side in arrays."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Callable

import numpy as np

from safe_passage.core.geometry import Pose, rotation
from safe_passage.monitoring.features import Features, no_features
from safe_passage.monitoring.parameters import TrackerParameters
from safe_passage.monitoring.ragged import Ragged


@dataclass(frozen=True)
class Tracks:
    """N objects. Frame base, unless said otherwise.

    The state is that of a point of the object; `offset` leads from it to the centroid of what is
    seen of the object now. Without shape alignment the two are the same.
    """

    id: np.ndarray  # (N,) int, from 1, never used twice
    x: np.ndarray  # (N, 4) [m, m/s] position and velocity over ground of what is seen
    P: np.ndarray  # (N, 4, 4) covariance
    body: np.ndarray  # (N, 4) the same of the body that legs carry; of all else, of what is seen
    body_covariance: np.ndarray  # (N, 4, 4)
    offset: np.ndarray  # (N, 2) [m]
    origin: np.ndarray  # (N, 2) [m] where the point was when the track began
    extent: np.ndarray  # (N, 2, 2) [m^2] second moment of the cells
    cells: np.ndarray  # (N,) occupied cells
    counts: np.ndarray  # (N, S) points of each sensor
    height: np.ndarray  # (N, 2) [m] lowest and highest point, NaN: unknown
    born: np.ndarray  # (N,) [s]
    hits: np.ndarray  # (N,) cycles with an observation
    misses: np.ndarray  # (N,) cycles since the last
    unseen: np.ndarray  # (N,) [s] since the last
    fast: np.ndarray  # (N,) [s] that it has looked like motion without a break
    moving: np.ndarray  # (N,) bool, latched
    shapes: list[np.ndarray]  # N of (M, 2) [m] from the point to the cells, axes of the odometry
    references: list[np.ndarray]  # the same when the point was fixed, for shape alignment

    def __len__(self) -> int:
        return len(self.id)

    @property
    def centroid(self) -> np.ndarray:
        """(N, 2) [m] of what is seen."""
        return self.x[:, :2] + self.offset

    @property
    def position(self) -> np.ndarray:
        """(N, 2) [m] as it is told: of a walker's body, of all else the centroid."""
        return self.body[:, :2] + self.offset

    @property
    def velocity(self) -> np.ndarray:
        """(N, 2) [m/s] over ground, as it is told."""
        return self.body[:, 2:]

    @property
    def size(self) -> np.ndarray:
        """(N,) [m] as of a line with its second moment."""
        return np.sqrt(12.0 * np.trace(self.extent, axis1=1, axis2=2))

    def keep(self, which: np.ndarray) -> Tracks:
        """Those of the mask `which` (N,)."""
        return self._each(
            lambda array: array[which],
            lambda lists: [own for own, kept in zip(lists, which) if kept],
        )

    def join(self, others: Tracks) -> Tracks:
        """These and then `others`."""
        more = iter([getattr(others, field.name) for field in fields(self)])
        return self._each(lambda a: np.concatenate([a, next(more)]), lambda a: a + next(more))

    def _each(self, array: Callable, lists: Callable) -> Tracks:
        """With a function of each array and each list in place of it, in the fields' order."""
        values = [getattr(self, field.name) for field in fields(self)]
        return Tracks(*[lists(v) if isinstance(v, list) else array(v) for v in values])

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
        np.zeros(count),
        np.zeros(count),
        np.zeros(count, bool),
        shapes,
        shapes,
    )


def no_tracks(sensors: int) -> Tracks:
    """None yet."""
    return new_tracks(no_features(sensors), [], 1, 0.0, TrackerParameters())


def centroid_noise(
    extent: np.ndarray, parameters: TrackerParameters, compact: bool = False
) -> np.ndarray:
    """(N, 2, 2) [m^2] how uncertain the centroid of what is seen is as a point of the object.

    Of a large object different parts are seen from different places; the uncertainty grows with the
    cube of its extent, so that a person's stays that of the sensors and a wall's says nothing
    along the wall. compact: without that part.
    """
    noise = np.broadcast_to(parameters.position_noise**2 * np.eye(2), extent.shape)
    return noise if compact else noise + extent @ extent @ extent / parameters.extent_scale**4


def placed_shapes(shapes: list[np.ndarray], positions: np.ndarray, pose: Pose) -> Ragged:
    """Points (M, 2) [m] of each of `shapes` around its `positions` (N, 2), frame base at `pose`."""
    joined = Ragged.of(shapes, np.empty((0, 2)))
    turned = joined.values @ rotation(-pose[2]).T
    return Ragged(turned + positions[joined.owner], joined.start)
