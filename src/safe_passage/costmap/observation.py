"""What a sensor saw, and how long it is remembered."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from safe_passage.costmap.parameters import SourceParameters


@dataclass(frozen=True)
class Observation:
    """One message of a sensor, in the global frame."""

    stamp: float  # s, when it was measured
    origin: tuple[float, float, float]  # m, the sensor
    points: np.ndarray  # (N, 3) float32 m; points that are not finite mean nothing


class ObservationBuffer:
    """The observations of one source that still count, newest first."""

    def __init__(self, parameters: SourceParameters) -> None:
        self.parameters = parameters
        self._kept: deque[Observation] = deque()

    @property
    def kept(self) -> tuple[Observation, ...]:
        return tuple(self._kept)

    def add(self, observation: Observation, now: float) -> None:
        """Remember an observation that arrived at `now` (s) and forget those too old by then.

        As in costmap_2d, age is judged when a message arrives: a silent sensor's last
        observations stay. Points outside the source's height band, NaN and inf are left out.
        """
        points = np.asarray(observation.points, dtype=np.float32).reshape(-1, 3)
        height = points[:, 2]
        with np.errstate(invalid="ignore"):
            wanted = (height <= self.parameters.max_obstacle_height) & (
                height >= self.parameters.min_obstacle_height
            )
        wanted &= np.isfinite(points[:, 0]) & np.isfinite(points[:, 1])
        self._kept.appendleft(Observation(observation.stamp, observation.origin, points[wanted]))
        self._forget(now)

    def clear(self) -> None:
        self._kept.clear()

    def _forget(self, now: float) -> None:
        persistence = self.parameters.observation_persistence
        fresh = 1
        if persistence > 0:
            stale = (i for i, seen in enumerate(self._kept) if now - seen.stamp > persistence)
            fresh = next(stale, len(self._kept))
        while len(self._kept) > fresh:
            self._kept.pop()
