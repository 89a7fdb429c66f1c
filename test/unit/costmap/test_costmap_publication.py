from __future__ import annotations

import numpy as np
from safe_passage.costmap import CostmapUpdate, PublicationArea, occupancy


def update(changed, origin=(0.0, 0.0)):
    return CostmapUpdate(np.zeros((10, 10), np.uint8), origin, 0.1, changed, np.zeros((3, 2)))


def test_values_of_costmap_2d_publisher():
    costs = np.array([0, 1, 2, 3, 4, 126, 252, 253, 254, 255], dtype=np.uint8)
    assert occupancy(costs).tolist() == [0, 1, 1, 1, 2, 49, 98, 99, 100, -1]


def test_whole_map_first_and_after_the_window_moved():
    area = PublicationArea(always_full=False)
    area.gather(update((0, 2, 0, 2)))
    assert area.take(update((0, 2, 0, 2))) == (True, None)
    area.gather(update((1, 2, 3, 4)))
    assert area.take(update((1, 2, 3, 4))) == (False, (1, 2, 3, 4))
    assert area.take(update((1, 2, 3, 4), origin=(0.1, 0.0))) == (True, None)


def test_parts_are_joined_until_published():
    area = PublicationArea(always_full=False)
    area.take(update(None))
    area.gather(update((1, 2, 3, 4)))
    area.gather(update(None))
    area.gather(update((5, 6, 0, 1)))
    assert area.take(update(None)) == (False, (1, 6, 0, 4))
    assert area.take(update(None)) == (False, None)


def test_always_whole_where_told_so_and_after_forgetting():
    assert [PublicationArea(True).take(update(None))[0] for _ in range(2)] == [True, True]
    area = PublicationArea(always_full=False)
    area.take(update(None))
    area.forget()
    assert area.take(update(None))[0]
