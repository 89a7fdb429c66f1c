"""Where the arm may have been when the picture was taken."""

from __future__ import annotations

import math
from typing import Mapping

import numpy as np

from safe_passage.robot_model import JointHistory, RobotModel
from safe_passage.robot_model.surfaces import Surface

MOST = 24  # poses each side of the stamp
STILL = 5e-4  # [m] a robot that moves less does not move


def positions_around(
    joints: JointHistory, names: tuple[str, ...], stamp: float, uncertainty: float
) -> list[dict[str, float]]:
    """Joint positions `uncertainty` [s] before the stamp, at it, and as long after it.

    What is not known yet goes on as it went.

    Raises:
        InputError: names the joint whose position at the stamp is not known.
    """
    now = joints.at(stamp, names)
    if uncertainty == 0.0:
        return [now]
    before = joints.at(stamp - uncertainty, names)
    if joints.latest(names) >= stamp + uncertainty:
        after = joints.at(stamp + uncertainty, names)
    else:
        after = {name: 2.0 * now[name] - before[name] for name in names}
    return [before, now, after]


class Sweep:
    """Poses that leave no gap wider than `spacing` [m] between them on the arm's way.

    Args:
        links: names of those looked at.
    """

    def __init__(self, model: RobotModel, links: tuple[str, ...], spacing: float) -> None:
        self._model, self._links, self._spacing = model, links, spacing
        self._corners = [_corners(model.links[name]) for name in links]

    def poses(self, stations: list[dict[str, float]]) -> np.ndarray:
        """T_root_link (P, L, 4, 4) along the way through `stations`, joint positions."""
        if len(stations) == 1:
            return self._at(stations[0])[None]
        middle = len(stations) // 2
        found = [self._at(stations[middle])]
        for end in (stations[0], stations[-1]):
            count = self._steps(found[0], self._at(end))
            for share in np.linspace(0.0, 1.0, count + 1)[1:]:
                found.append(self._at(_between(stations[middle], end, share)))
        return np.stack(found)

    def _steps(self, a: np.ndarray, b: np.ndarray) -> int:
        ways = [
            np.linalg.norm(c @ (A - B)[:3, :3].T + (A - B)[:3, 3], axis=1).max()
            for c, A, B in zip(self._corners, a, b)
        ]
        way = max(ways, default=0.0)
        return 0 if way < STILL else min(MOST, math.ceil(way / self._spacing))

    def _at(self, positions: Mapping[str, float]) -> np.ndarray:
        poses = self._model.poses(positions)
        return np.array([poses[name] for name in self._links]).reshape(-1, 4, 4)


def _between(a: Mapping[str, float], b: Mapping[str, float], share: float) -> dict[str, float]:
    return {name: (1.0 - share) * a[name] + share * b[name] for name in a}


def _corners(surface: Surface) -> np.ndarray:
    """(8, 3) of its bounding box: a rigid motion moves no point inside farther than one of them."""
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    return np.array(
        [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    )
