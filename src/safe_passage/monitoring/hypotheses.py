"""What may be an object: clusters, unions of clusters and parts of clusters (paper 000, 4.1).

The finest pieces in play are called atoms: a cluster that nothing splits is one atom, a split one
has an atom for each track on it. A hypothesis is a set of atoms, and two hypotheses contradict each
other if and only if they share one.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Sequence

import numpy as np
from scipy.spatial import cKDTree

from safe_passage.monitoring.clustering import sizes as cluster_sizes
from safe_passage.monitoring.features import Features, describe
from safe_passage.monitoring.fusion_grid import FusionGrid, cell_index
from safe_passage.monitoring.ragged import Ragged, gather

LARGELY = 0.5  # share of a track's cells on a cluster
MOST_PARTS = 6  # of which every pair is tried; of more only all together
APART_BY = 1.5  # times the largest piece of it is a moving thing long
APART = 1e3  # [m] between clusters, so that one search keeps them apart


@dataclass(frozen=True)
class Rules:
    """When clusters are put together and taken apart."""

    composite_overlap: float  # share of a cluster's cells that a track must cover; > 1: never
    split_overlap: float  # share of a track's cells that a cluster must cover; > 1: never
    body: float  # [m] a cluster of this size may be one person
    walker: float  # [m] so long is one in stride, in scans that are put together
    moving: np.ndarray  # (N,) bool, of the tracks: one of those that share a cluster must move
    established: np.ndarray  # (N,) bool: only such may share a cluster of a body's size
    bodies: np.ndarray  # (B, 2) [m] where tracks of a body's size should be, frame base


@dataclass(frozen=True)
class Hypotheses:
    """All that is considered in one cycle; the clusters first."""

    cells: Ragged  # obstacle cells of the grid, by hypothesis
    atoms: list[tuple[int, ...]]  # by hypothesis
    features: Features
    part: np.ndarray  # (H,) bool: it contains a part of a cluster that others have a part of
    fallen: np.ndarray  # (F, 2) int: track that largely lies on a cluster of a body's size, cluster
    claimant: np.ndarray  # (H,) oldest track on such a cluster in it; the number of tracks: none
    overlaps: np.ndarray  # (P, 2) int: hypothesis, track that largely lie on each other

    def __len__(self) -> int:
        return len(self.atoms)


def propose(
    grid: FusionGrid,
    clusters: np.ndarray,
    shapes: Ragged,
    rules: Rules,
) -> Hypotheses:
    """Clusters, and what the predicted tracks suggest beside them.

    Args:
        grid: of this cycle.
        clusters: (K,) cluster of each obstacle cell, -1: none.
        shapes: points [m] of each predicted track's shape, frame base.
        rules: what is suggested.
    """
    count = int(clusters.max(initial=-1)) + 1
    cover = _Cover(grid, clusters, count, shapes)
    sizes = cluster_sizes(grid, clusters, count)
    known = clusters >= 0
    came = np.bincount(clusters[known], ~grid.new[known], minlength=count) == 0
    owners = cover.owners(rules, sizes)
    atoms = _Atoms(grid, clusters, count, shapes, owners)
    sets: dict[tuple[int, ...], None] = {tuple(whole): None for whole in atoms.of_cluster}
    for whole in atoms.of_cluster:
        if len(whole) > 1:
            sets.update(((part,), None) for part in whole)
    parts = atoms.of_track(cover.covered(rules, came))
    for track, own in parts.items():
        unions = _unions(own)
        if rules.moving[track]:
            unions = [own for own in unions if atoms.are_near(own, grid.position, rules.walker)]
        sets.update((own, None) for own in unions)
    for own in _bodies(grid, clusters, sizes, atoms, rules):
        sets.update((own, None) for own in _unions(own))
    chosen = [own for own in sets if not atoms.joins_two(own, rules.moving & rules.established)]
    fallen = (cover.track_share >= LARGELY) & (sizes <= rules.body)
    cells = atoms.cells.unions(chosen)
    return Hypotheses(
        cells,
        chosen,
        describe(grid, cells),
        atoms.parts(chosen),
        np.argwhere(fallen),
        atoms.claimants(chosen, fallen),
        _overlaps(chosen, parts, cover, atoms),
    )


def _unions(own: Sequence[int]) -> list[tuple[int, ...]]:
    """All of these atoms together, and pairs if there are not too many."""
    pairs = combinations(own, 2) if 2 < len(own) <= MOST_PARTS else ()
    return [tuple(own), *pairs] if len(own) > 1 else []


class _Cover:
    """Which obstacle cells lie on, or beside, which predicted track."""

    def __init__(self, grid: FusionGrid, clusters: np.ndarray, count: int, shapes: Ragged) -> None:
        self._clusters, self._count, self._tracks = clusters, count, len(shapes)
        own = cell_index(shapes.values, grid.side, grid.resolution)
        inside = own >= 0
        around = (np.array([[-1], [0], [1]]) * grid.side + np.array([-1, 0, 1])).ravel()
        near = np.clip(own[inside, None] + around, 0, grid.side**2 - 1)
        cell = grid.label[near]  # (T, 9) obstacle cell, -1: free
        hit, _ = np.nonzero(cell >= 0)
        cell = cell[cell >= 0].astype(np.int64)
        known = clusters[cell] >= 0
        hit, cell = hit[known], cell[known]
        shape_point = np.flatnonzero(inside)[hit]
        track = shapes.owner[shape_point]
        # cells of clusters on tracks; points of tracks on clusters
        pairs = np.unique(track * np.int64(max(len(clusters), 1)) + cell)
        on_track, covered = np.divmod(pairs, max(len(clusters), 1))
        self.cluster_share = self._table(on_track, clusters[covered])
        self.cluster_share /= np.maximum(np.bincount(clusters[clusters >= 0], minlength=count), 1)
        points = np.unique(shape_point * np.int64(max(count, 1)) + clusters[cell])
        point, cluster = np.divmod(points, max(count, 1))
        self.track_share = self._table(shapes.owner[point], cluster)
        self.track_share /= np.maximum(shapes.lengths, 1)[:, None]

    def _table(self, track: np.ndarray, cluster: np.ndarray) -> np.ndarray:
        """(tracks, clusters) how often each pair occurs."""
        size = self._tracks * self._count
        at = track * self._count + cluster
        return np.bincount(at, minlength=size).reshape(self._tracks, self._count).astype(float)

    def owners(self, rules: Rules, sizes: np.ndarray) -> dict[int, np.ndarray]:
        """Tracks of each cluster that carries two or more objects; sizes (clusters,) [m].

        Of things that never moved it does not matter which part is whose; and what was a short
        while ago seen beside a person is its other leg.
        """
        largely = self.track_share >= rules.split_overlap
        largely &= rules.established[:, None] | (sizes > rules.body)
        shared = (largely.sum(axis=0) >= 2) & (largely & rules.moving[:, None]).any(axis=0)
        return {int(j): np.flatnonzero(largely[:, j]) for j in np.flatnonzero(shared)}

    def covered(self, rules: Rules, came: np.ndarray) -> list[tuple[int, int]]:
        """(track, cluster) of each cluster that a track covers to a large extent.

        What `came` (clusters,) a short while ago is no part of what stands.
        """
        largely = self.cluster_share >= rules.composite_overlap
        largely &= rules.moving[:, None] | ~came
        return list(zip(*(axis.tolist() for axis in np.nonzero(largely))))

    def touching(self, least: float) -> tuple[np.ndarray, np.ndarray]:
        """Tracks and clusters of which either lies on the other by this share."""
        track, cluster = np.nonzero(np.maximum(self.track_share, self.cluster_share) >= least)
        return track, cluster


class _Atoms:
    """The finest pieces."""

    def __init__(
        self,
        grid: FusionGrid,
        clusters: np.ndarray,
        count: int,
        shapes: Ragged,
        owners: dict[int, np.ndarray],
    ) -> None:
        self.of_cell = clusters.astype(np.int64)
        self.of_cluster: list[list[int]] = [[j] for j in range(count)]
        self.of_owner: dict[tuple[int, int], int] = {}  # (track, cluster): atom
        self.owner: dict[int, int] = {}  # atom: track
        total = count
        for cluster, pieces in _parts(grid, clusters, shapes, owners).items():
            numbers = [
                cluster,
                *range(total, total + len(pieces) - 1),
            ]  # the first keeps the number
            total += len(pieces) - 1
            self.of_cluster[cluster] = numbers
            for atom, (track, cells) in zip(numbers, pieces):
                self.of_owner[track, cluster] = atom
                self.owner[atom] = track
                self.of_cell[cells] = atom
        order = np.argsort(self.of_cell, kind="stable")
        order = order[np.searchsorted(self.of_cell[order], 0) :]
        lengths = np.bincount(self.of_cell[order], minlength=total)
        self.cells = Ragged.of_lengths(order, lengths)

    def joins_two(self, own: tuple[int, ...], walkers: np.ndarray) -> bool:
        """Whether the atoms `own` are parts of two tracks of which both are known to walk (N,)."""
        return sum(bool(walkers[self.owner[a]]) for a in own if a in self.owner) > 1

    def of_track(self, covered: Sequence[tuple[int, int]]) -> dict[int, list[int]]:
        """What each track consists of: clusters that it covers and its parts of split ones."""
        parts: dict[int, set] = {}
        for (track, _), atom in self.of_owner.items():
            parts.setdefault(track, set()).add(atom)
        for track, cluster in covered:
            if len(self.of_cluster[cluster]) == 1:
                parts.setdefault(track, set()).add(cluster)
        return {track: sorted(own) for track, own in parts.items()}

    def are_near(self, own: tuple[int, ...], position: np.ndarray, walker: float) -> bool:
        """Whether the atoms `own` can be one thing that moves: those of two who part cannot."""
        boxes = [position[self.cells[a]] for a in own]
        longest = max(float(np.hypot(*np.ptp(box, axis=0))) for box in boxes)
        whole = float(np.hypot(*np.ptp(np.concatenate(boxes), axis=0)))
        return whole <= max(walker, APART_BY * longest)

    def claimants(self, chosen: list[tuple[int, ...]], fallen: np.ndarray) -> np.ndarray:
        """(H,) first track, which is the oldest, of those `fallen` (N, J) on a cluster of each."""
        tracks = len(fallen)
        of_atom = {
            atom: int(fallen[:, j].argmax())
            for j in np.flatnonzero(fallen.any(axis=0))
            for atom in self.of_cluster[j]
        }
        return np.array([min(of_atom.get(a, tracks) for a in own) for own in chosen], np.int64)

    def parts(self, chosen: list[tuple[int, ...]]) -> np.ndarray:
        """(H,) whether each of these sets has some but not all atoms of a cluster."""
        siblings = {atom: set(own) for own in self.of_cluster for atom in own if len(own) > 1}
        return np.array(
            [any(not siblings.get(a, set()) <= set(own) for a in own) for own in chosen], bool
        )


def _bodies(
    grid: FusionGrid, clusters: np.ndarray, sizes: np.ndarray, atoms: _Atoms, rules: Rules
) -> list[list[int]]:
    """Atoms of the small clusters around each body: a leg may step out of the predicted shape."""
    small = np.flatnonzero(sizes <= rules.body)
    if rules.composite_overlap > 1.0 or not len(small) or not len(rules.bodies):
        return []
    known = clusters >= 0
    count = np.bincount(clusters[known], minlength=len(sizes))
    middle = np.stack(
        [
            np.bincount(clusters[known], grid.position[known, axis], minlength=len(sizes)) / count
            for axis in (0, 1)
        ],
        axis=1,
    )
    near = cKDTree(middle[small]).query_ball_point(rules.bodies, 0.5 * rules.body)
    return [
        sorted(atom for i in found for atom in atoms.of_cluster[small[i]])
        for found in near
        if len(found) > 1
    ]


def _parts(
    grid: FusionGrid, clusters: np.ndarray, shapes: Ragged, owners: dict[int, np.ndarray]
) -> dict[int, list[tuple[int, np.ndarray]]]:
    """For each cluster its tracks, each with the obstacle cells that are nearest to it."""
    if not owners:
        return {}
    names = np.array([(j, i) for j, tracks in owners.items() for i in tracks])
    points, lengths = gather(shapes, names[:, 1])
    layer = np.repeat(names[:, 0], lengths) * APART
    tree = cKDTree(np.column_stack([points, layer]))
    cells = np.flatnonzero(np.isin(clusters, list(owners)))
    _, nearest = tree.query(np.column_stack([grid.position[cells], clusters[cells] * APART]))
    name = np.repeat(np.arange(len(names)), lengths)[nearest]
    parts: dict[int, list[tuple[int, np.ndarray]]] = {}
    for n, (cluster, track) in enumerate(names.tolist()):
        own = cells[name == n]
        if len(own):
            parts.setdefault(cluster, []).append((track, own))
    return parts


def _overlaps(
    chosen: list[tuple[int, ...]], parts: dict[int, list[int]], cover: _Cover, atoms: _Atoms
) -> np.ndarray:
    """(P, 2) hypothesis and track that belong together whatever their centroids say."""
    number = {own: h for h, own in enumerate(chosen)}
    pairs = {(number[own], t) for t, p in parts.items() for own in [tuple(p)] if own in number}
    pairs |= {(number[(a,)], t) for t, p in parts.items() for a in p if (a,) in number}
    for track, cluster in zip(*(axis.tolist() for axis in cover.touching(0.3))):
        whole = tuple(atoms.of_cluster[cluster])
        if whole in number:
            pairs.add((number[whole], track))
    return np.array(sorted(pairs), np.int64).reshape(-1, 2)
