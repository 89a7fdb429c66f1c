"""How near robot and obstacles come: circles first, the true shapes where that is not enough."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from safe_passage.separation.prediction import Prediction
from safe_passage.separation.robot_motion import Motion, Shape

BATCH = 8  # obstacles that are looked at closely together


@dataclass(frozen=True)
class Nearest:
    """Of N obstacles along one motion. Distances are 0 where shapes touch."""

    present: np.ndarray  # (N,) [m] now, without growth; far ones: a lower bound
    distance: np.ndarray  # (N, T) [m] predicted, growth included; far ones: a lower bound
    deciding: int  # index of the obstacle with the least predicted distance, -1: none
    least_present: float  # [m] inf: nobody is there
    least_predicted: float  # [m]
    time_to_collision: float  # [s] until enlarged shapes touch, inf: they do not


def nearest_along(prediction: Prediction, poses: np.ndarray, shape: Shape) -> Nearest:
    """Along `poses` (T, 3) of base at the prediction's first T times.

    Everything that is reported is exact; the bounds only spare what cannot be the nearest.
    """
    count = len(prediction)
    if not count:
        none = np.empty((0, len(poses)))
        return Nearest(none[:, 0], none, -1, np.inf, np.inf, np.inf)
    every = np.arange(len(poses))
    times, growth = prediction.times[every], prediction.growth[:, every]
    places = prediction.centre[:, None] + prediction.velocity[:, None] * times[:, None]
    apart = np.hypot(*np.moveaxis(places - poses[:, :2], -1, 0))
    bound = np.maximum(apart - prediction.radius[:, None] - shape.reach, 0.0)
    distance = np.maximum(bound - growth, 0.0)
    present = bound[:, 0]
    order = np.argsort(np.minimum(distance.min(axis=1), present))
    best = np.inf
    for first in range(0, count, BATCH):
        batch = order[first : first + BATCH]
        if np.minimum(distance[batch[0]].min(), present[batch[0]]) > best:
            break
        i, t = np.repeat(batch, len(every)), np.tile(every, len(batch))
        true = exact(prediction, i, t, poses[t], shape).reshape(len(batch), -1)
        present[batch] = np.maximum(true[:, 0], 0.0)
        distance[batch] = np.maximum(true - growth[batch], 0.0)
        best = max(distance.min(), present.min())
    return _summary(prediction, present, distance)


def _summary(prediction: Prediction, present: np.ndarray, distance: np.ndarray) -> Nearest:
    least = distance.min(axis=1)
    touches = (distance <= 0.0).argmax(axis=1)  # 0 where it never does
    touch = np.where(least <= 0.0, prediction.times[touches], np.inf)
    deciding = int(np.lexsort((present, touch, least))[0])
    collision = min(
        (_touch(row, prediction.times) for row in distance[least <= 0.0]), default=np.inf
    )
    return Nearest(
        present, distance, deciding, float(present.min()), float(least.min()), float(collision)
    )


def _touch(distance: np.ndarray, times: np.ndarray) -> float:
    """[s] when `distance` (T,) becomes 0, between two times as it fell before them."""
    k = int((distance <= 0.0).argmax())
    if k < 2:
        return float(times[k])
    fall = distance[k - 2] - distance[k - 1]
    after = distance[k - 1] / fall if fall > 0.0 else 1.0
    return float(times[k - 1] + min(after, 1.0) * (times[k] - times[k - 1]))


def exact(
    prediction: Prediction,
    i: np.ndarray,
    t: np.ndarray,
    poses: np.ndarray,
    shape: Shape,
    enough: np.ndarray | None = None,
) -> np.ndarray:
    """(Q,) [m] between obstacles `i` (Q,) at times `t` (Q,) and the robot at `poses` (Q, 3).

    Without growth; negative where they overlap. Beyond `enough` (Q,) [m] a lower bound may be told.
    """
    centre = prediction.centre[i] + prediction.velocity[i] * prediction.times[t][:, None]
    start, reach = prediction.start, prediction.radius
    most = np.full(len(i), np.inf) if enough is None else enough
    return shape.kernel.nearest(prediction.discs, start, reach, i, centre, poses, most)


@dataclass(frozen=True)
class Table:
    """Distances of the obstacles that could come near, wherever the robot is when."""

    unknown: np.ndarray  # (n,) bool: these may come from anywhere
    growth: np.ndarray  # (n, T) [m]
    distance: np.ndarray  # (n, K, T) [m] to the robot at u[k] at times[t], less the growth
    spacing: float  # [s] between two u

    def along(self, u: np.ndarray) -> np.ndarray:
        """(n, S, T) [m] on courses `u` (S, T)."""
        last = self.distance.shape[1] - 1
        at = np.clip(u / self.spacing, 0.0, last)
        low = np.minimum(at.astype(np.int64), last - 1)
        share = at - low
        t = np.arange(u.shape[1])
        return (1.0 - share) * self.distance[:, low, t] + share * self.distance[:, low + 1, t]


def make_table(
    prediction: Prediction, motion: Motion, shape: Shape, reachable: np.ndarray, enough: float
) -> Table:
    """Distances, exact below `enough` [m]; above they are at least that.

    Args:
        reachable: (T,) [s] largest u at each time; beyond it the table is not to be asked.
    """
    spacing = float(motion.u[1] - motion.u[0])
    which = np.flatnonzero(_may_come(prediction, motion, shape, enough))
    places = prediction.centre[which, None] + (
        prediction.velocity[which, None] * prediction.times[:, None]
    )
    far = enough + prediction.radius[which, None] + prediction.growth[which]
    n, k, t = _near_circles(places, motion, reachable + spacing, far + shape.reach)
    distance = np.full((len(which), len(motion.u), len(prediction.times)), enough)
    growth = prediction.growth[which[n], t]
    true = exact(prediction, which[n], t, motion.poses[k], shape, enough + growth)
    distance[n, k, t] = true - growth
    return Table(prediction.unknown[which], prediction.growth[which], distance, spacing)


def _near_circles(
    places: np.ndarray, motion: Motion, reachable: np.ndarray, far: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Obstacles, poses and times (Q,) that are nearer than `far` (n, T) [m] and reachable."""
    dx = places[:, None, :, 0] - motion.poses[:, None, 0]
    dy = places[:, None, :, 1] - motion.poses[:, None, 1]
    asked = motion.u[:, None] <= reachable
    return np.nonzero((dx * dx + dy * dy < (far * far)[:, None]) & asked)


def _may_come(prediction: Prediction, motion: Motion, shape: Shape, enough: float) -> np.ndarray:
    """(N,) whether an obstacle meets the circle around all that the robot may sweep."""
    low, high = motion.poses[:, :2].min(axis=0), motion.poses[:, :2].max(axis=0)
    middle = 0.5 * (low + high)
    swept = np.hypot(*(motion.poses[:, :2] - middle).T).max() + shape.reach
    start = prediction.centre - middle
    way = prediction.velocity * prediction.times[-1]
    length = np.maximum((way**2).sum(axis=1), 1e-12)
    share = np.clip(-(start * way).sum(axis=1) / length, 0.0, 1.0)
    passing = np.hypot(*(start + share[:, None] * way).T)
    return passing - prediction.radius - prediction.growth.max(axis=1, initial=0.0) < swept + enough
