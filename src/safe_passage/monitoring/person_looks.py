"""What a person detector says, and on which tracks it falls. Frame: the odometry's."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage

from safe_passage.core.geometry import placed, rotation
from safe_passage.monitoring.pipeline import Snapshot
from safe_passage.monitoring.ragged import Ragged

HIDING = 0.3  # [m] what is nearer to the camera by that much hides what is behind it
BODY = 0.25  # [m] half the width of a person
PIECE_GAP = 0.8  # [m] two legs of a person are nearer to each other


@dataclass(frozen=True)
class View:
    """The part of the floor on which a detector would have found a person."""

    origin: tuple[float, float]  # [m] of the camera
    heading: float  # [rad]
    width: float  # [rad]
    near: float  # [m]
    far: float  # [m]


@dataclass(frozen=True)
class Look:
    """One answer of a detector, also that it saw nobody."""

    stamp: float  # [s]
    position: np.ndarray  # (K, 2) [m] of each person on the floor
    probability: np.ndarray  # (K,) [0, 1] that it is one
    view: View | None = None  # None: where it looked is not known
    said: tuple[Any, ...] = ()  # K; what the detector itself says of each, handed through

    def told(self, detection: int) -> Any:
        """What the detector says of a person; None: nothing."""
        return self.said[detection] if self.said else None


@dataclass(frozen=True)
class Places:
    """N tracks at one time."""

    position: np.ndarray  # (N, 2) [m] centroids
    velocity: np.ndarray  # (N, 2) [m/s] over ground
    cells: Ragged  # (M, 2) [m] of each track
    size: np.ndarray  # (N,) [m]

    def at(self, ahead: float) -> Places:
        """The same `ahead` [s] later; earlier, if negative."""
        way = ahead * self.velocity
        cells = Ragged(self.cells.values + way[self.cells.owner], self.cells.start)
        return Places(self.position + way, self.velocity, cells, self.size)

    def pieces(self, track: int) -> np.ndarray:
        """(M, 2) [m] where it is: its centroid, or those of its parts that lie far apart."""
        cells = self.cells[track]
        if self.size[track] > PIECE_GAP and len(cells) > 1:
            owner = fcluster(linkage(cells, "single"), PIECE_GAP, "distance")
            if owner.max() > 1:
                return np.array([cells[owner == i].mean(axis=0) for i in range(1, owner.max() + 1)])
        return self.position[track : track + 1]

    def distances(self, point: np.ndarray) -> np.ndarray:
        """(N,) [m] from `point` (2,) to the centroid or the nearest cell of each."""
        nearest = np.hypot(*(self.position - point).T)
        np.minimum.at(nearest, self.cells.owner, np.hypot(*(self.cells.values - point).T))
        return nearest


def places_of(snapshot: Snapshot) -> Places:
    """All tracks of a cycle."""
    tracks, pose = snapshot.tracks, snapshot.pose
    cells = Ragged(placed(snapshot.shapes.values, pose), snapshot.shapes.start)
    velocity = tracks.velocity @ rotation(pose[2]).T
    return Places(placed(tracks.position, pose), velocity, cells, tracks.size)


def match(look: Look, places: Places, fits: np.ndarray, gate: float) -> list[int]:
    """The track on which each detection falls, -1: none of them; `places` are of the look's time.

    Nearest pairs first, one detection a track: of two persons who are one track, the second one is
    told for itself. fits: (N,) which tracks may be a person. gate: [m] farthest.
    """
    pairs = []
    for k, point in enumerate(look.position):
        distance = places.distances(point)
        near = np.flatnonzero(fits & (distance <= gate))
        pairs += [(float(distance[i]), k, i) for i in near.tolist()]
    owner, taken = [-1] * len(look.position), set()
    for _, k, i in sorted(pairs):
        if owner[k] < 0 and i not in taken:
            owner[k] = i
            taken.add(i)
    return owner


def in_sight(view: View, places: Places, track: int) -> bool:
    """Whether a person in the place of `track` is in the view, and nothing before it."""
    origin = np.array(view.origin)
    away = places.position[track] - origin
    distance = float(np.hypot(*away))
    bearing = math.atan2(away[1], away[0])
    wide = math.asin(min(1.0, BODY / max(distance, BODY)))
    off = abs(math.remainder(bearing - view.heading, 2.0 * math.pi))
    if not view.near <= distance <= view.far or off + wide > 0.5 * view.width:
        return False
    others = places.cells.owner != track
    beams = places.cells.values[others] - origin
    before = np.hypot(*beams.T) < distance - HIDING
    aside = np.angle(np.exp(1j * (np.arctan2(beams[:, 1], beams[:, 0]) - bearing)))
    return not (before & (np.abs(aside) < wide)).any()
