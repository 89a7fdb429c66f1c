"""Public trackers on the same detections: norfair and Stone-Soup, as their documents advise.

A detection is the centroid of a cluster, moved to the odometry's frame, for neither of the two
knows of ego-motion. They do not tell what moves, so our rule is applied to their velocities.
"""

from __future__ import annotations

import datetime
from dataclasses import dataclass, replace
from typing import Any, Protocol, Sequence

import numpy as np
from safe_passage.core.geometry import Pose, placed
from safe_passage.evaluation.tracking_recording import Recording
from safe_passage.evaluation.tracking_runs import FRESH, Told, measurements
from safe_passage.monitoring.aggregation import Aggregator, Measurement
from safe_passage.monitoring.clustering import cluster
from safe_passage.monitoring.features import describe
from safe_passage.monitoring.free_space import FreeSpace
from safe_passage.monitoring.fusion_grid import Fusion
from safe_passage.monitoring.parameters import TrackerParameters
from safe_passage.monitoring.pipeline import IN_STRIDE
from safe_passage.monitoring.preprocessing import outside
from safe_passage.monitoring.ragged import Ragged

# Chosen by accuracy on the scenarios that our own parameters were tuned with.
NORFAIR_REACH = 0.5  # [m] from a prediction to its detection, at most
NORFAIR_MEASURED = 0.1  # [m] standard deviation of a centroid
STONESOUP_REACH = 1.0  # [m]
STONESOUP_MEASURED = 0.15  # [m]
STONESOUP_JOLT = 0.3  # [m^2/s^3] spectral density of the acceleration
MISSED = 3.0  # standard deviations, as in Stone-Soup's tutorials
POINTS = 3  # detections before a track is one


class Detector:
    """Ours up to the clusters."""

    def __init__(self, parameters: TrackerParameters) -> None:
        self._p = parameters
        heights = np.array([source.three_dimensional for source in parameters.sources], bool)
        self._aggregator = Aggregator(parameters.sources)
        self._fusion = Fusion(parameters.radius, parameters.resolution, heights)
        self._free_space = FreeSpace()
        self._footprint = np.array(parameters.footprint, float).reshape(-1, 2)

    def detect(self, stamp: float, pose: Pose, measured: Sequence[Measurement]) -> np.ndarray:
        """Centroids (N, 2) [m] of the clusters, frame of the odometry."""
        for one in measured:
            self._free_space.add(one)
            kept = outside(one.points, self._footprint, self._p.footprint_padding)
            self._aggregator.add(replace(one, points=one.points[kept]))
        grid = self._fusion.fuse(self._aggregator.points(stamp, pose))
        grid = self._free_space.judged(grid, pose, stamp)
        body = self._p.body_size
        labels = cluster(grid, self._p.min_points, body, IN_STRIDE * body, np.empty((0, 2)))
        order = np.argsort(labels, kind="stable")
        order = order[np.searchsorted(labels[order], 0) :]
        features = describe(grid, Ragged.of_lengths(order, np.bincount(labels[order])))
        return placed(features.position, np.array(pose))


@dataclass(frozen=True)
class Held:
    """A peer's track."""

    id: int
    position: np.ndarray  # (2,) [m]
    velocity: np.ndarray  # (2,) [m/s]
    significance: float  # squared Mahalanobis distance of the velocity from 0
    seen: float  # [s] of its last detection


class Peer(Protocol):
    """Another tracker."""

    def update(self, stamp: float, positions: np.ndarray) -> list[Held]:
        """Take the detections (N, 2) [m] of time `stamp` [s]."""


class Norfair:
    """Euclidean distance, its own optimised Kalman filter, three detections to begin.

    It counts cycles, not seconds: `period` [s] is that of a cycle.
    """

    NOISE = 4.0  # of a measurement, by which its filter's covariances are to be scaled

    def __init__(self, period: float) -> None:
        import norfair

        self._norfair, self._period = norfair, period
        self._tracker = norfair.Tracker(
            distance_function="euclidean",
            distance_threshold=NORFAIR_REACH,
            initialization_delay=POINTS,
        )

    def update(self, stamp: float, positions: np.ndarray) -> list[Held]:
        detections = [self._norfair.Detection(point[None], data=stamp) for point in positions]
        return [self._held(one) for one in self._tracker.update(detections)]

    def _held(self, track: Any) -> Held:
        velocity = track.estimate_velocity[0]  # [m] a cycle
        variance = track.filter.vel_variance * (NORFAIR_MEASURED**2 / self.NOISE)
        return Held(
            track.id,
            track.estimate[0],
            velocity / self._period,
            float(np.sum(velocity**2 / variance.ravel())),
            track.last_detection.data,
        )


class StoneSoup:
    """Constant velocity Kalman filter, global nearest neighbour within Mahalanobis distance.

    Tutorial 9's parts, with the k-d tree that its documents recommend for many detections.
    """

    EPOCH = datetime.datetime(2000, 1, 1)

    def __init__(self, speed: float, keep: float) -> None:
        """[m/s] standard deviation of a new track's velocity, [s] without a detection."""
        from stonesoup.dataassociator.tree import DetectionKDTreeGNN2D
        from stonesoup.deleter.time import UpdateTimeDeleter
        from stonesoup.hypothesiser.distance import DistanceHypothesiser
        from stonesoup.initiator.simple import MultiMeasurementInitiator
        from stonesoup.measures import Mahalanobis
        from stonesoup.models.measurement.linear import LinearGaussian
        from stonesoup.models.transition.linear import (
            CombinedLinearGaussianTransitionModel,
            ConstantVelocity,
        )
        from stonesoup.predictor.kalman import KalmanPredictor
        from stonesoup.types.detection import Detection
        from stonesoup.types.state import GaussianState
        from stonesoup.updater.kalman import KalmanUpdater

        self._detection = Detection
        axis = ConstantVelocity(STONESOUP_JOLT)
        predictor = KalmanPredictor(CombinedLinearGaussianTransitionModel([axis, axis]))
        self._model = LinearGaussian(4, (0, 2), STONESOUP_MEASURED**2 * np.eye(2))
        self._updater = KalmanUpdater(self._model)
        hypothesiser = DistanceHypothesiser(predictor, self._updater, Mahalanobis(), MISSED)
        self._associator = DetectionKDTreeGNN2D(
            hypothesiser, predictor, self._updater, max_distance=STONESOUP_REACH
        )
        self._deleter = UpdateTimeDeleter(datetime.timedelta(seconds=keep))
        self._initiator = MultiMeasurementInitiator(
            GaussianState(np.zeros((4, 1)), np.diag([0.0, speed**2, 0.0, speed**2])),
            deleter=UpdateTimeDeleter(datetime.timedelta(seconds=FRESH)),
            data_associator=self._associator,
            updater=self._updater,
            measurement_model=self._model,
            min_points=POINTS,
        )
        self._tracks: set[Any] = set()
        self._numbers: dict[str, int] = {}

    def update(self, stamp: float, positions: np.ndarray) -> list[Held]:
        now = self.EPOCH + datetime.timedelta(seconds=stamp)
        detections = {
            self._detection(point[:, None], timestamp=now, measurement_model=self._model)
            for point in positions
        }
        found = self._associator.associate(self._tracks, detections, now)
        used = set()
        for track, hypothesis in found.items():
            if hypothesis:
                track.append(self._updater.update(hypothesis))
                used.add(hypothesis.measurement)
            else:
                track.append(hypothesis.prediction)
        self._tracks -= self._deleter.delete_tracks(self._tracks)
        self._tracks |= self._initiator.initiate(detections - used, now)
        for track in self._tracks:
            del track[:-20]  # it would keep every state ever
        return [self._held(track, stamp) for track in self._tracks]

    def _held(self, track: Any, stamp: float) -> Held:
        number = self._numbers.setdefault(track.id, len(self._numbers) + 1)
        x = np.asarray(track.state_vector, float).ravel()
        seen = [state for state in track.states if hasattr(state, "hypothesis")]
        last = (seen[-1].timestamp - self.EPOCH).total_seconds() if seen else -np.inf
        velocity, P = x[[1, 3]], np.asarray(track.covar, float)[1::2, 1::2]
        significance = float(velocity @ np.linalg.solve(P, velocity))
        return Held(number, x[[0, 2]], velocity, significance, last)


class MovingRule:
    """Ours: fast, surely so, away from where it began, for some time; it stays so.

    period: [s] of cycles.
    """

    def __init__(self, parameters: TrackerParameters, period: float) -> None:
        self._p, self._period = parameters, period
        self._origin: dict[int, np.ndarray] = {}
        self._fast: dict[int, float] = {}
        self._moving: set[int] = set()

    def moves(self, track: Held) -> bool:
        """Whether it counts as moving; to be asked once a cycle."""
        origin = self._origin.setdefault(track.id, track.position.copy())
        fast = (
            np.hypot(*track.velocity) > self._p.moving_speed
            and track.significance > self._p.moving_significance
            and np.hypot(*(track.position - origin)) > self._p.moving_distance
        )
        self._fast[track.id] = self._fast.get(track.id, 0.0) + self._period if fast else 0.0
        if self._fast[track.id] >= self._p.moving_time:
            self._moving.add(track.id)
        return track.id in self._moving


def make_peer(name: str, parameters: TrackerParameters, period: float) -> Peer:
    """norfair or stonesoup."""
    if name == "norfair":
        return Norfair(period)
    return StoneSoup(parameters.initial_speed, parameters.max_unobserved)


def follow_with(name: str, recording: Recording, parameters: TrackerParameters) -> list[Told]:
    """Run a peer over a recording."""
    period = float(np.median(np.diff(recording.stamps)))
    detector, peer = Detector(parameters), make_peer(name, parameters, period)
    rule = MovingRule(parameters, period)
    cycles = []
    for stamp, pose, measured in zip(
        recording.stamps, recording.poses, measurements(recording, parameters)
    ):
        positions = detector.detect(float(stamp), tuple(pose), measured)
        held = peer.update(float(stamp), positions)
        cycles.append(
            Told(
                np.array([one.id for one in held], int),
                np.array([one.position for one in held], float).reshape(-1, 2),
                np.array([one.velocity for one in held], float).reshape(-1, 2),
                np.array([rule.moves(one) for one in held], bool),
                np.array([stamp - one.seen <= FRESH for one in held], bool),
            )
        )
    return cycles
