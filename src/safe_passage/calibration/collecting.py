"""Images of an arm that somebody moves -> a view each time that it stands still in a new pose."""

from __future__ import annotations

from typing import Mapping

import numpy as np

from safe_passage.calibration.accumulation import temporal_median
from safe_passage.calibration.pipeline import ArmView
from safe_passage.robot_model.joint_history import moved


class PoseCollector:
    """Takes images in as they come.

    Args:
        images: of one pose, of which the median is taken.
        still: [rad or m] by which an arm that stands still moves at most.
        apart: [rad or m] by which a joint differs at least from that of every pose taken.
        least_share: of the images in which a pixel must have a depth.
    """

    def __init__(self, images: int, still: float, apart: float, least_share: float) -> None:
        self._images, self._still, self._apart = images, still, apart
        self._least_share = least_share
        self._standing: list[np.ndarray] = []
        self._since: Mapping[str, float] = {}
        self.views: list[ArmView] = []

    def add(
        self, depth: np.ndarray, before: Mapping[str, float], now: Mapping[str, float]
    ) -> ArmView | None:
        """One image, and the view that it completes, if it does.

        Args:
            depth: (H, W) float32 [m], NaN = none.
            before: positions of the joints some time before the image.
            now: at the image.
        """
        known = any(moved(view.positions, now) < self._apart for view in self.views)
        if known or moved(before, now) > self._still:
            self._standing = []
            return None
        if not self._standing or moved(self._since, now) > self._still:
            self._standing, self._since = [], dict(now)
        self._standing.append(depth)
        if len(self._standing) < self._images:
            return None
        view = ArmView(temporal_median(self._standing, self._least_share), self._since)
        self._standing = []
        self.views.append(view)
        return view
