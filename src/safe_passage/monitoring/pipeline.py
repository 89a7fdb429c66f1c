"""The obstacle tracker: measurements of any sensors -> tracked obstacles (paper 000, 3 and 4)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Sequence

import numpy as np

from safe_passage._monitoring import ShapeAligner
from safe_passage.core.errors import ParameterError
from safe_passage.core.geometry import Pose, compose, inverse, rotation
from safe_passage.monitoring.aggregation import Aggregator, Measurement
from safe_passage.monitoring.association import associate
from safe_passage.monitoring.clustering import cluster
from safe_passage.monitoring.features import describe
from safe_passage.monitoring.free_space import FreeSpace
from safe_passage.monitoring.fusion_grid import Fusion, FusionGrid
from safe_passage.monitoring.gait import agilities
from safe_passage.monitoring.hypotheses import Hypotheses, Rules, propose
from safe_passage.monitoring.motion import move_frame, predict
from safe_passage.monitoring.observation import classify, observe
from safe_passage.monitoring.parameters import TrackerParameters
from safe_passage.monitoring.preprocessing import outside
from safe_passage.monitoring.ragged import Ragged
from safe_passage.monitoring.tracks import Tracks, new_tracks, no_tracks, placed_shapes

OFF = 2.0  # a share that is never reached
BUILT_IN = ("sources", "footprint", "resolution", "radius")  # cannot be tuned
IN_STRIDE = 1.3  # bodies long is a walker in scans that are put together


@dataclass(frozen=True)
class Snapshot:
    """All that is tracked at one time, frame base."""

    stamp: float  # [s]
    pose: Pose  # of base in the odometry's frame
    tracks: Tracks
    confirmed: np.ndarray  # (N,) bool: observed often enough to be told
    shapes: Ragged  # (M, 2) [m] cells of each track
    grid: FusionGrid  # its label is overwritten by the next cycle
    sources: tuple[str, ...]  # alive


class ObstacleTracker:
    """Tracks everything around the robot, standing or moving."""

    def __init__(self, parameters: TrackerParameters) -> None:
        self._p = parameters
        self._three_dimensional = np.array([s.three_dimensional for s in parameters.sources], bool)
        self._footprint = np.array(parameters.footprint, float).reshape(-1, 2)
        self._aggregator = Aggregator(parameters.sources)
        self._fusion = Fusion(parameters.radius, parameters.resolution, self._three_dimensional)
        self._free_space = FreeSpace()
        self._aligner = ShapeAligner(parameters.resolution, parameters.alignment_reach)
        self.reset()

    def reset(self) -> None:
        """Forget everything; identities are not used again."""
        self._aggregator.reset()
        self._free_space.reset()
        self._tracks = no_tracks(len(self._p.sources))
        self._next_id = getattr(self, "_next_id", 1)
        self._last: tuple[float, Pose] | None = None

    def tune(self, parameters: TrackerParameters) -> None:
        """Other parameters from the next cycle on; tracks and identities stay.

        Raises:
            ParameterError: the sensors, the robot or the grid would be others.
        """
        for name in BUILT_IN:
            if getattr(parameters, name) != getattr(self._p, name):
                raise ParameterError(f"{name}: cannot be changed while it runs")
        self._p = parameters
        self._aligner = ShapeAligner(parameters.resolution, parameters.alignment_reach)

    def update(self, stamp: float, pose: Pose, measurements: Sequence[Measurement]) -> Snapshot:
        """One cycle.

        Args:
            stamp: [s] now, later than at the last cycle.
            pose: of base in the odometry's frame, now.
            measurements: since the last cycle.
        """
        for measurement in measurements:
            self._free_space.add(measurement)
            self._aggregator.add(self._without_robot(measurement))
        grid = self._fusion.fuse(self._aggregator.points(stamp, pose))
        if self._p.free_space:
            grid = self._free_space.judged(grid, pose, stamp)
        tracks = self._predict(stamp, pose)
        shapes = placed_shapes(self._expected(tracks), tracks.x[:, :2], pose)
        established = stamp - tracks.born >= self._p.fragment_age
        walkers = tracks.centroid[tracks.moving & established]
        clusters = cluster(
            grid, self._p.min_points, self._p.body_size, IN_STRIDE * self._p.body_size, walkers
        )
        hypotheses = propose(grid, clusters, shapes, self._rules(tracks, established))
        seen, known = associate(hypotheses, tracks, established, self._three_dimensional, self._p)
        tracks = observe(tracks, grid, hypotheses, (seen, known), pose, self._aligner, self._p)
        features = hypotheses.features.of(seen)
        tracks = classify(tracks, known, features, self._elapsed(stamp), self._cameras(), self._p)
        tracks = self._drop_lost(tracks, hypotheses, seen, known, established)
        tracks = self._start_new(tracks, grid, hypotheses, seen, stamp, pose)
        self._tracks, self._last = tracks, (stamp, pose)
        return Snapshot(
            stamp,
            pose,
            tracks,
            tracks.hits >= self._p.confirm_cycles,
            placed_shapes(tracks.shapes, tracks.x[:, :2], pose),
            grid,
            self._aggregator.alive(),
        )

    def _expected(self, tracks: Tracks) -> list[np.ndarray]:
        """The shape that each track should show.

        Large things that stand are expected as they were: who walks away from a table would
        otherwise take its shape along, cycle by cycle.
        """
        stands = ~tracks.moving & (tracks.size > self._p.body_size)
        pairs = zip(tracks.shapes, tracks.references, stands)
        return [reference if still else shape for shape, reference, still in pairs]

    def _cameras(self) -> np.ndarray:
        """(S,) bool, as far as is known what they see."""
        known = self._free_space.cameras() if self._p.free_space else set()
        return np.array([source.name in known for source in self._p.sources], bool)

    def _elapsed(self, stamp: float) -> float:
        """[s] since the last cycle."""
        return stamp - self._last[0] if self._last else 0.0

    def _rules(self, tracks: Tracks, established: np.ndarray) -> Rules:
        p = self._p
        return Rules(
            p.composite_overlap if p.composites else OFF,
            p.split_overlap if p.splits else OFF,
            p.body_size,
            IN_STRIDE * p.body_size,
            tracks.moving,
            established,
            tracks.centroid[tracks.size <= p.body_size],
        )

    def _without_robot(self, measurement: Measurement) -> Measurement:
        kept = outside(measurement.points, self._footprint, self._p.footprint_padding)
        points = measurement.points[kept]
        return replace(measurement, points=points)

    def _predict(self, stamp: float, pose: Pose) -> Tracks:
        """Where the tracks are now, seen from where the robot is now."""
        tracks = self._tracks
        if self._last is None:
            return tracks
        dt, from_pose = self._elapsed(stamp), self._last[1]
        motion, drift = compose(inverse(from_pose), pose), self._p.odometry_drift
        seen, carried = agilities(tracks, self._p)
        x, P = predict(tracks.x, tracks.P, dt, seen)
        x, P = move_frame(x, P, motion, drift)
        body, covariance = predict(tracks.body, tracks.body_covariance, dt, carried)
        body, covariance = move_frame(body, covariance, motion, drift)
        turn = rotation(-motion[2])
        origin = (tracks.origin - motion[:2]) @ turn.T
        extent = turn @ tracks.extent @ turn.T
        offset = tracks.offset @ turn.T
        return tracks.with_(
            x=x,
            P=P,
            body=body,
            body_covariance=covariance,
            origin=origin,
            extent=extent,
            offset=offset,
            unseen=tracks.unseen + dt,
        )

    def _drop_lost(
        self,
        tracks: Tracks,
        hypotheses: Hypotheses,
        seen: np.ndarray,
        known: np.ndarray,
        established: np.ndarray,
    ) -> Tracks:
        """Without those not seen for too long, and without legs that turn out to be a person's."""
        keep = (tracks.unseen <= self._p.max_unobserved) & (tracks.misses <= tracks.hits)
        used = {atom for h in seen.tolist() for atom in hypotheses.atoms[h]}
        for track, whole in hypotheses.fallen.tolist():
            if whole in used and not established[track]:
                keep[track] = False
        keep[known] = True
        return tracks.keep(keep)

    def _start_new(
        self,
        tracks: Tracks,
        grid: FusionGrid,
        hypotheses: Hypotheses,
        seen: np.ndarray,
        stamp: float,
        pose: Pose,
    ) -> Tracks:
        """A track of each cluster, or what is left of it, that belongs to none."""
        used = {atom for h in seen.tolist() for atom in hypotheses.atoms[h]}
        free = [
            h
            for h, own in enumerate(hypotheses.atoms)
            if used.isdisjoint(own) and hypotheses.features.here[h]
        ]
        chosen: list[int] = []
        for h in free:  # whole clusters come first
            if used.isdisjoint(hypotheses.atoms[h]):
                chosen.append(h)
                used.update(hypotheses.atoms[h])
        cells = hypotheses.cells.unions([(h,) for h in chosen])
        features = describe(grid, cells)
        turn = rotation(pose[2]).T
        shapes = [
            (grid.position[cells[i]] - features.position[i]) @ turn for i in range(len(chosen))
        ]
        fresh = new_tracks(features, shapes, self._next_id, stamp, self._p)
        self._next_id += len(chosen)
        return tracks.join(fresh)
