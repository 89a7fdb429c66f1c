"""Snapshots of things whose places are given, for what judges tracks."""

from dataclasses import dataclass

import numpy as np
from safe_passage.core.geometry import inverse, placed, rotation
from safe_passage.monitoring.pipeline import Snapshot
from safe_passage.monitoring.ragged import Ragged
from safe_passage.monitoring.tracks import no_tracks


@dataclass(frozen=True)
class Thing:
    """A track; frame of the odometry."""

    id: int
    x: float = 0.0  # [m]
    y: float = 0.0
    vx: float = 0.0  # [m/s]
    vy: float = 0.0
    size: float = 0.4  # [m] along x
    moving: bool = False
    misses: int = 0
    confirmed: bool = True


def scene(stamp, *things, pose=(0.0, 0.0, 0.0)):
    """A snapshot of `things` at `stamp` [s], seen from the robot at `pose`."""
    n, none = len(things), no_tracks(0)
    places = np.array([(t.x, t.y) for t in things], float).reshape(-1, 2)
    turn = rotation(-pose[2])
    x = np.zeros((n, 4))
    x[:, :2] = placed(places, inverse(pose))
    x[:, 2:] = np.array([(t.vx, t.vy) for t in things], float).reshape(-1, 2) @ turn.T
    along = [np.linspace(-0.5, 0.5, max(2, round(t.size / 0.1))) * t.size for t in things]
    lines = [np.column_stack([a, 0.0 * a]) @ turn.T for a in along]
    extent = np.array([np.diag([t.size**2 / 12.0, 0.0]) for t in things]).reshape(-1, 2, 2)
    tracks = none.with_(
        id=np.array([t.id for t in things], int),
        x=x,
        P=np.broadcast_to(0.01 * np.eye(4), (n, 4, 4)),
        body=x,
        body_covariance=np.broadcast_to(0.01 * np.eye(4), (n, 4, 4)),
        offset=np.zeros((n, 2)),
        extent=turn @ extent @ turn.T,
        born=np.zeros(n),
        hits=np.full(n, 9),
        misses=np.array([t.misses for t in things], int),
        moving=np.array([t.moving for t in things], bool),
    )
    shapes = Ragged.of([x[i, :2] + line for i, line in enumerate(lines)], np.empty((0, 2)))
    confirmed = np.array([t.confirmed for t in things], bool)
    return Snapshot(stamp, pose, tracks, confirmed, shapes, None, ())  # nobody looks at the grid
