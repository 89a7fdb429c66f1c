"""Where the sensors have seen nothing before: what is there now has come.

A beam that met something has passed through free space on its way. What stands now where beams have
passed a short while ago was not there then, whatever it touches now; what stands where they ended
was; of what lay behind their ends nothing is known. The paper knows moving from standing by tracks
alone, which cannot tell a walker close to a wall from the wall.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from safe_passage.core.geometry import Pose
from safe_passage.monitoring.aggregation import Measurement
from safe_passage.monitoring.fusion_grid import FusionGrid
from safe_passage.monitoring.views import CloudView, ScanView, View, seen_from

APART = 0.4  # [s] between the scans that are remembered
KEPT = 2.5  # [s] that they are
PASSING = 1.0  # [s] that a walker needs to pass a point; what was met before stands there


@dataclass(frozen=True)
class _Seen:
    """What one measurement saw free."""

    stamp: float  # [s]
    pose: Pose  # of base in the odometry's frame
    view: View

    def beams(self, grid: FusionGrid, pose: Pose) -> tuple[np.ndarray, np.ndarray]:
        """Through which cells of the grid around base at `pose` beams passed; where they ended.

        A scanner's beams pass under what only cameras see, such as a table.
        """
        told = grid.scanned if isinstance(self.view, ScanView) else np.isfinite(grid.height[:, 0])
        at = seen_from(pose, self.pose, grid.position[told])
        passed, ended = np.zeros((2, len(told)), bool)
        passed[told], ended[told] = self.view.beams(at, grid.height[told])
        return passed, ended


class FreeSpace:
    """Remembers some views of the last seconds."""

    def __init__(self) -> None:
        self._views: dict[str, deque[_Seen]] = {}
        self._last: dict[str, _Seen] = {}

    def add(self, measurement: Measurement) -> None:
        """Remember this one, if it has a view and is newer than its source's last."""
        last = self._last.get(measurement.source)
        if measurement.view is None or (last and measurement.stamp <= last.stamp):
            return
        view = _Seen(measurement.stamp, measurement.pose, measurement.view)
        self._last[measurement.source] = view
        views = self._views.setdefault(measurement.source, deque())
        if not views or measurement.stamp - views[-1].stamp >= APART:
            views.append(view)

    def judged(self, grid: FusionGrid, pose: Pose, stamp: float) -> FusionGrid:
        """The grid around base at `pose`, with what is known of its cells a short while before, and
        whether the last measurements still have what those put together show.

        Args:
            stamp: [s] now; what was seen too long ago is forgotten.
        """
        free, met = np.zeros((2, len(grid.cell)), bool)
        for views in self._views.values():
            while views and stamp - views[0].stamp > KEPT:
                views.popleft()
            for view in views:
                passed, ended = view.beams(grid, pose)
                free |= passed
                if stamp - view.stamp > PASSING:
                    met |= ended
        left = np.zeros(len(grid.cell), bool)
        for view in self._last.values():
            if stamp - view.stamp < APART:
                left |= view.beams(grid, pose)[0]
        left &= ~np.isfinite(grid.fresh[:, 2])
        return replace(grid, new=free & ~met, stood=met & ~free, left=left)

    def cameras(self) -> set[str]:
        """Sources that see a part of a turn, and that again and again from elsewhere."""
        return {name for name, one in self._last.items() if isinstance(one.view, CloudView)}

    def reset(self) -> None:
        """Forget everything."""
        self._views.clear()
        self._last.clear()
