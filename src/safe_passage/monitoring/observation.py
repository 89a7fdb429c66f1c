"""Tracks after having been seen: their place, speed, and whether they move (paper 000, 4.3, 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from safe_passage._monitoring import ShapeAligner
from safe_passage.core.geometry import Pose, rotation
from safe_passage.monitoring.features import LEAST_NEW, MOSTLY, Features
from safe_passage.monitoring.fusion_grid import FusionGrid
from safe_passage.monitoring.gait import follow
from safe_passage.monitoring.hypotheses import Hypotheses
from safe_passage.monitoring.motion import squared_mahalanobis, update
from safe_passage.monitoring.parameters import TrackerParameters
from safe_passage.monitoring.ragged import Ragged, moments
from safe_passage.monitoring.shape_alignment import align
from safe_passage.monitoring.tracks import Tracks, centroid_noise, placed_shapes

CUT = 0.3  # [m] standard deviation of the centroid of a part that was cut off a cluster
LEAK = 0.5  # a gait makes speed swing: so fast fades what looked like motion when it does not
WAY_NEW, TIME_NEW = 0.25, 0.5  # shares of the way and of the time after which such a one moves
ONE_BODY = 0.45  # [m] that two who walk are apart
GROWN = 1.5  # times the cells of its reference: more of the object is seen now


@dataclass(frozen=True)
class Fresh:
    """Of M objects what the sensors' last measurements show.

    Measurements that are put together are mostly the same as in the cycle before, and lie still;
    only fresh points tell how far a shape has moved.
    """

    points: Ragged  # M lists of points (., 2) [m], frame base
    age: np.ndarray  # (M,) [s] mean


@dataclass(frozen=True)
class Sight:
    """How M tracks are seen."""

    offset: np.ndarray  # (M, 2) [m] of the seen centroid from the track's point
    noise: np.ndarray  # (M, 2, 2) [m^2] of the point's measured position
    renew: np.ndarray  # (M,) bool: the reference shape does not fit any more


def observe(
    tracks: Tracks,
    grid: FusionGrid,
    hypotheses: Hypotheses,
    pairs: tuple[np.ndarray, np.ndarray],
    pose: Pose,
    aligner: ShapeAligner,
    parameters: TrackerParameters,
) -> Tracks:
    """The tracks after those of `pairs` (hypotheses (M,), tracks (M,)) have been seen."""
    seen, known = pairs
    features = hypotheses.features
    age = features.age[seen]
    cells = hypotheses.cells.of_lists(seen)
    points = Ragged(grid.position[cells.values], cells.start)
    fresh = _fresh(grid, cells)
    position = features.position[seen]
    if parameters.alignment and len(seen):
        hidden = features.shadowed[seen]
        sight = _aligned(tracks, known, points, hidden, fresh, age, pose, aligner, parameters)
    else:
        noise = centroid_noise(features.extent[seen], parameters)
        sight = Sight(tracks.offset[known], noise, np.ones(len(seen), bool))
    cut = hypotheses.part[seen, None, None] * CUT**2 * np.eye(2)
    z, noise = position - sight.offset, sight.noise + cut
    x, P = update(tracks.x[known], tracks.P[known], z, noise, age)
    shapes, references = list(tracks.shapes), list(tracks.references)
    whole = ~hypotheses.part[seen]  # a part cut off a cluster says little of the object's shape
    _store(shapes, known, points, x[:, :2] - age[:, None] * x[:, 2:], whole, pose)
    was_at = x[:, :2] - fresh.age[:, None] * x[:, 2:]
    _store(references, known, fresh.points, was_at, whole & sight.renew, pose)
    zero = np.zeros(len(seen), np.int64)
    height = features.height[seen]
    tracks = tracks.with_(x=_replaced(tracks.x, known, x), P=_replaced(tracks.P, known, P))
    body, covariance = follow(tracks, known, z, noise, age, parameters)
    return tracks.with_(
        body=body,
        body_covariance=covariance,
        offset=_replaced(tracks.offset, known, sight.offset),
        extent=_replaced(tracks.extent, known, features.extent[seen]),
        cells=_replaced(tracks.cells, known, features.cells[seen]),
        counts=_replaced(tracks.counts, known, features.counts[seen]),
        height=_replaced(
            tracks.height, known, np.where(np.isfinite(height), height, tracks.height[known])
        ),
        hits=_replaced(tracks.hits, known, tracks.hits[known] + 1),
        misses=_replaced(tracks.misses + 1, known, zero),
        unseen=_replaced(tracks.unseen, known, zero),
        shapes=shapes,
        references=references,
    )


def _aligned(
    tracks: Tracks,
    known: np.ndarray,
    points: Ragged,
    hidden: np.ndarray,
    fresh: Fresh,
    age: np.ndarray,
    pose: Pose,
    aligner: ShapeAligner,
    parameters: TrackerParameters,
) -> Sight:
    """How much of each centroid's shift is apparent, as the shape says.

    Shape and centroid each tell where the track's point is, with their covariances; what the
    centroid says beyond the mean of both is apparent motion and goes into the offset.
    """
    x, offset = tracks.x[known], tracks.offset[known]
    references = [tracks.references[t] for t in known]
    before = placed_shapes(references, x[:, :2] - fresh.age[:, None] * x[:, 2:], pose)
    position, extent = moments(points)
    extents = np.stack([moments(before)[1], extent])
    larger = np.trace(extents, axis1=2, axis2=3).argmax(axis=0)
    noise = centroid_noise(extents[larger, np.arange(len(known))], parameters)
    size = 12.0 * np.trace(extents, axis1=2, axis2=3).max(axis=0)  # [m^2] of a line as long
    least = np.where(tracks.moving[known], parameters.alignment_size, parameters.body_size)
    compact = parameters.position_noise**2 * np.eye(2) + hidden[:, None, None] * extent
    rigid = np.flatnonzero(size > least**2)
    shapes = fresh.points.of_lists(rigid), before.of_lists(rigid)
    found = align(aligner, *shapes, parameters.alignment_noise)
    trust = noise[rigid] @ np.linalg.inv(noise[rigid] + found.noise)  # in the shape
    moved = position - offset - (x[:, :2] - age[:, None] * x[:, 2:])
    apparent = np.einsum("nij,nj->ni", trust, moved[rigid] - found.displacement)
    fits = found.overlap >= parameters.alignment_overlap
    aligned = rigid[fits]
    measured = _replaced(compact, rigid, noise[rigid])
    measured[aligned] = (noise[rigid] - trust @ noise[rigid])[fits]
    renew = fresh.points.lengths > GROWN * before.lengths
    renew[np.setdiff1d(np.arange(len(known)), aligned)] = True
    return Sight(_replaced(offset, aligned, offset[aligned] + apparent[fits]), measured, renew)


def _fresh(grid: FusionGrid, cells: Ragged) -> Fresh:
    told = grid.fresh[cells.values]
    known = np.isfinite(told[:, 2])
    lengths = np.bincount(cells.owner[known], minlength=len(cells))
    points = Ragged.of_lengths(told[known, :2], lengths)
    age = np.bincount(points.owner, told[known, 2], minlength=len(cells))
    return Fresh(points, age / np.maximum(lengths, 1))


def _store(
    shapes: list[np.ndarray],
    tracks: np.ndarray,
    points: Ragged,
    positions: np.ndarray,
    which: np.ndarray,
    pose: Pose,
) -> None:
    """Put the shapes `points` around `positions` (M, 2) in the place of those of `tracks` (M,)."""
    chosen = points.of_lists(np.flatnonzero(which))
    relative = chosen.values - np.repeat(positions[which], chosen.lengths, axis=0)
    stored = Ragged(relative @ rotation(pose[2]).T, chosen.start)
    for i, track in enumerate(tracks[which].tolist()):
        shapes[track] = stored[i]


def _replaced(values: np.ndarray, at: np.ndarray, by: np.ndarray) -> np.ndarray:
    changed = values.copy()
    changed[at] = by
    return changed


def classify(
    tracks: Tracks,
    known: np.ndarray,
    features: Features,
    dt: float,
    cameras: np.ndarray,
    parameters: TrackerParameters,
) -> Tracks:
    """Whether the tracks `known` (M,) move: fast, significantly so, and away from their origin.

    What is where nothing was needs less proof. Once a track moves it stays moving (paper 000,
    section 5).

    Args:
        features: (M,) of what was seen of them; of what is partly hidden nothing new is learnt.
        dt: [s] since the last cycle.
        cameras: (S,) bool, sensors that see a part of what is around: while the robot drives other
            parts of things come into their view. What they alone see moves if it is new there.
    """
    velocity = tracks.x[known, 2:]
    way = tracks.x[known, :2] - tracks.origin[known]
    significance = squared_mahalanobis(velocity, tracks.P[known, 2:, 2:])
    new = (features.new >= MOSTLY) & (features.new * features.cells >= LEAST_NEW)
    fast = (
        (np.hypot(*velocity.T) > parameters.moving_speed)
        & ((significance > parameters.moving_significance) | new)
        & (np.hypot(*way.T) > np.where(new, WAY_NEW, 1.0) * parameters.moving_distance)
        & (tracks.cells[known] > 1)  # a single cell flickers between one thing and the next
    )
    fast &= ~_legs(tracks, known)
    fast &= new | (features.counts[:, ~cameras] > 0).any(axis=1)
    dt_seen = np.where(new, dt / TIME_NEW, np.where(features.shadowed, 0.0, dt))
    during = _replaced(
        tracks.fast,
        known,
        np.maximum(tracks.fast[known] + dt_seen * np.where(fast, 1.0, -LEAK), 0.0),
    )
    return tracks.with_(fast=during, moving=tracks.moving | (during >= parameters.moving_time))


def _legs(tracks: Tracks, known: np.ndarray) -> np.ndarray:
    """Which of the tracks `known` (M,) are so near to an older one that moves as only legs are."""
    older = np.flatnonzero(tracks.moving & (tracks.misses == 0))
    place = tracks.centroid
    away = np.hypot(*np.moveaxis(place[known, None] - place[None, older], -1, 0))
    return ((away < ONE_BODY) & (older[None] < known[:, None])).any(axis=1)
