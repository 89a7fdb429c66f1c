"""Which hypothesis is which track (paper 000, 4.2)."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from safe_passage.monitoring.features import MOSTLY, Features
from safe_passage.monitoring.hypotheses import Hypotheses
from safe_passage.monitoring.motion import squared_mahalanobis
from safe_passage.monitoring.parameters import TrackerParameters
from safe_passage.monitoring.tracks import Tracks, centroid_noise

# Within which pairs are looked at; overlapping ones at any distance.
NEIGHBOURHOOD = 0.8  # [m] of tracks that move
STANDING = 0.5  # [m] of tracks that never moved, or have not been seen for
RECENT = 0.4  # [s]: a walker turns on the spot, but who is hidden for long could be anywhere
REFOUND = 1.5  # [m] of tracks that move and what has just come: who was hidden comes out
WALKING = 0.5  # [m/s] who goes faster is not what stood there before


def associate(
    hypotheses: Hypotheses,
    tracks: Tracks,
    established: np.ndarray,
    three_dimensional: np.ndarray,
    parameters: TrackerParameters,
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs in the order of ascending distance; what is chosen rules out what contradicts it.

    Returns:
        hypotheses (M,) and their tracks (M,).
    """
    features = hypotheses.features
    pairs, overlap = candidates(features.position, tracks.centroid, hypotheses.overlaps)
    h, t = pairs.T
    squared = _squared_distance(features, tracks, h, t, parameters)
    away = np.hypot(*(features.position[h] - tracks.centroid[t]).T)
    agile = tracks.moving & (tracks.unseen <= RECENT)
    reach = np.where(agile[t], NEIGHBOURHOOD, STANDING)
    reach = np.where(tracks.moving[t] & (features.new[h] >= MOSTLY), REFOUND, reach)
    near = overlap | ((squared <= parameters.gate) & (away <= reach))
    walks = tracks.moving & (np.hypot(*tracks.x[:, 2:].T) > WALKING)
    near &= ~(tracks.moving[t] & features.left[h])
    near &= ~(walks[t] & (features.stood[h] >= MOSTLY))
    h, t, squared = h[near], t[near], np.minimum(squared[near], parameters.gate)
    total = squared + feature_distance(features, tracks, h, t, three_dimensional, parameters)
    total += parameters.seniority * ((hypotheses.claimant[h] < t) & ~established[t])
    order = np.argsort(total, kind="stable")
    order = order[total[order] <= parameters.max_distance]
    h, t = h[order], t[order]
    seen, known = choose(h, t, hypotheses.atoms)
    if not parameters.free_space:
        return seen, known
    return inherit((seen, known), (h, t), features, tracks, established)


def candidates(
    positions: np.ndarray, tracks: np.ndarray, overlaps: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (P, 2) of hypothesis and track that are neighbours or overlap; (P,) whether they do."""
    pairs = overlaps
    if len(positions) and len(tracks):
        near = cKDTree(positions).sparse_distance_matrix(
            cKDTree(tracks), REFOUND, output_type="ndarray"
        )
        pairs = np.concatenate([overlaps, np.stack([near["i"], near["j"]], axis=1)])
    key, first = np.unique(pairs[:, 0] * np.int64(len(tracks) + 1) + pairs[:, 1], return_index=True)
    return pairs[first], first < len(overlaps)


def _squared_distance(
    features: Features, tracks: Tracks, h: np.ndarray, t: np.ndarray, parameters: TrackerParameters
) -> np.ndarray:
    """Squared Mahalanobis distance of the centroids, the generic part of the distance.

    The uncertainty is the track's plus that of the smaller object's centroid: a wall's may be
    anywhere along it, which must not let it take a person's cluster.
    """
    extent = features.extent[h]
    theirs = tracks.extent[t]
    smaller = np.trace(extent, axis1=1, axis2=2) <= np.trace(theirs, axis1=1, axis2=2)
    noise = centroid_noise(np.where(smaller[:, None, None], extent, theirs), parameters)
    offset = features.position[h] - tracks.centroid[t]
    offset = offset + features.age[h, None] * tracks.x[t, 2:]
    return squared_mahalanobis(offset, tracks.P[t, :2, :2] + noise)


def feature_distance(
    features: Features,
    tracks: Tracks,
    h: np.ndarray,
    t: np.ndarray,
    three_dimensional: np.ndarray,
    parameters: TrackerParameters,
) -> np.ndarray:
    """What else tells hypotheses h (P,) from tracks t (P,); what no common sensor saw counts 0.

    Cells (generic), points by sensor, and height by 3D sensors (sensor specific); and a constant
    where no sensor has seen both.
    """
    cells, their_cells = features.cells[h], tracks.cells[t]
    more = np.maximum(cells, their_cells)
    total = parameters.cells_weight * np.abs(cells - their_cells) / np.maximum(more, 1)
    counts, their_counts = features.counts[h], tracks.counts[t]
    both = (counts > 0) & (their_counts > 0)
    common = both.any(axis=1)
    difference = np.abs(counts - their_counts) / np.maximum(np.maximum(counts, their_counts), 1)
    total += parameters.points_weight * (difference * both).sum(axis=1) / np.maximum(both.sum(1), 1)
    rise = np.abs(features.height[h, 1] - tracks.height[t, 1]) / parameters.height_scale
    known = both[:, three_dimensional].any(axis=1) & np.isfinite(rise)
    total += parameters.height_weight * np.where(known, rise, 0.0)
    return total + np.where(common, 0.0, parameters.no_common_sensor)


def choose(
    h: np.ndarray, t: np.ndarray, atoms: list[tuple[int, ...]]
) -> tuple[np.ndarray, np.ndarray]:
    """Of pairs in ascending order of distance, those that contradict no earlier one."""
    used: set[int] = set()
    taken: set[int] = set()
    chosen = []
    for hypothesis, track in zip(h.tolist(), t.tolist()):
        if track in taken or not used.isdisjoint(atoms[hypothesis]):
            continue
        taken.add(track)
        used.update(atoms[hypothesis])
        chosen.append((hypothesis, track))
    pairs = np.array(chosen, np.int64).reshape(-1, 2)
    return pairs[:, 0], pairs[:, 1]


def inherit(
    chosen: tuple[np.ndarray, np.ndarray],
    pairs: tuple[np.ndarray, np.ndarray],
    features: Features,
    tracks: Tracks,
    established: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """The chosen pairs, with what a young track has seen given to who walked there before.

    A walker's foot that stays behind keeps the walker's track, and the other foot begins one. Once
    the first is not there any more, the young track's hypothesis is the walker.
    """
    of_track = dict(zip(chosen[1].tolist(), chosen[0].tolist()))
    of_hypothesis = {h: t for t, h in of_track.items()}
    young = ~established & ~tracks.moving
    for h, t in zip(pairs[0].tolist(), pairs[1].tolist()):
        own = of_track.get(t)
        if not (tracks.moving[t] and established[t]) or (own is not None and features.here[own]):
            continue
        other = of_hypothesis.get(h)
        if other is not None and young[other] and features.here[h]:
            del of_track[other]
            if own is not None:
                del of_hypothesis[own]
            of_track[t], of_hypothesis[h] = h, t
    told = np.array(list(of_track.items()), np.int64).reshape(-1, 2)
    return told[:, 1], told[:, 0]
