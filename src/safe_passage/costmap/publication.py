"""What to publish of a costmap, and when a part of it is enough (costmap_2d_publisher)."""

from __future__ import annotations

import numpy as np

from safe_passage.costmap.costs import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION
from safe_passage.costmap.grid import CellBox
from safe_passage.costmap.pipeline import CostmapUpdate


def _occupancy_table() -> np.ndarray:
    table = np.zeros(256, dtype=np.int8)
    scaled = np.arange(1, INSCRIBED_INFLATED_OBSTACLE)
    table[scaled] = 1 + 97 * (scaled - 1) // 251
    table[INSCRIBED_INFLATED_OBSTACLE] = 99
    table[LETHAL_OBSTACLE] = 100
    table[NO_INFORMATION] = -1
    return table


_OCCUPANCY = _occupancy_table()


def occupancy(costs: np.ndarray) -> np.ndarray:
    """Costs (uint8) as values of nav_msgs/OccupancyGrid (int8, same shape).

    >>> import numpy as np
    >>> occupancy(np.array([0, 1, 252, 253, 254, 255], dtype=np.uint8)).tolist()
    [0, 1, 98, 99, 100, -1]
    """
    return _OCCUPANCY[costs]


class PublicationArea:
    """Gathers the cells changed since the last publication."""

    def __init__(self, always_full: bool) -> None:
        self._always_full = always_full
        self._changed: CellBox | None = None
        self._place: tuple | None = None

    def gather(self, update: CostmapUpdate) -> None:
        """Add what an update changed."""
        if update.changed is None:
            return
        if self._changed is None:
            self._changed = update.changed
            return
        old, new = self._changed, update.changed
        self._changed = (
            min(old[0], new[0]),
            max(old[1], new[1]),
            min(old[2], new[2]),
            max(old[3], new[3]),
        )

    def take(self, update: CostmapUpdate) -> tuple[bool, CellBox | None]:
        """(whole map needed, cells of a partial update or None); starts a new gathering.

        The whole map is needed first, after the window moved, and always where so configured.
        """
        place = (update.origin, update.resolution, update.costs.shape)
        whole = self._always_full or place != self._place
        changed, self._changed = self._changed, None
        self._place = place
        return whole, None if whole else changed

    def forget(self) -> None:
        """The next publication is of the whole map."""
        self._changed = self._place = None
