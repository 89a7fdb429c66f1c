"""Views are taken of an arm that stands, once a pose."""

from __future__ import annotations

import numpy as np
from safe_passage.calibration.collecting import PoseCollector

IMAGE = np.ones((2, 3), np.float32)


def collector() -> PoseCollector:
    return PoseCollector(images=3, still=0.002, apart=0.1, least_share=0.5)


def stand(one: PoseCollector, angle: float, images: int, value: float = 1.0) -> int:
    """How many views an arm gives that stands at `angle`."""
    at = {"a": angle}
    return sum(one.add(value * IMAGE, at, at) is not None for _ in range(images))


def test_one_view_of_each_pose_however_long_it_is_held() -> None:
    one = collector()
    assert stand(one, 0.0, 2) == 0
    assert stand(one, 0.0, 20) == 1
    assert stand(one, 0.5, 20) == 1
    assert stand(one, 0.05, 20) == 0  # hardly another pose
    assert [view.positions["a"] for view in one.views] == [0.0, 0.5]


def test_an_arm_that_moves_gives_none_and_its_images_are_in_no_median() -> None:
    one = collector()
    stand(one, 0.0, 2, value=9.0)
    for i in range(10):
        assert one.add(9.0 * IMAGE, {"a": 0.1 * i}, {"a": 0.1 * i + 0.1}) is None
    assert stand(one, 2.0, 3) == 1
    assert (one.views[0].depth == 1.0).all()


def test_an_arm_that_creeps_gives_none() -> None:
    one = collector()
    for i in range(30):
        at = {"a": 0.0015 * i}
        assert one.add(IMAGE, at, at) is None


def test_median_of_the_images() -> None:
    one = collector()
    for value in (1.0, 5.0, 2.0):
        stand(one, 0.0, 1, value)
    assert (one.views[0].depth == 2.0).all()
