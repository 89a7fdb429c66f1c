"""The self-filter's figures, with a margin: an arm that moves, people a hand's breadth off."""

from __future__ import annotations

import pytest
from safe_passage.core.errors import InputError
from safe_passage.evaluation.self_filter_report import Trial, compare
from safe_passage.robot_model import load_robot_model
from safe_passage.self_filter import SelfFilterParameters
from safe_passage.simulation.arm_scene import Owner
from safe_passage.simulation.arms import find_urdf


def test_the_robot_goes_and_people_stay() -> None:
    try:
        urdf = find_urdf("pybullet_data/kuka_iiwa/model.urdf")
    except InputError as error:
        pytest.skip(str(error))
    scores = compare(load_robot_model(urdf, {}), SelfFilterParameters(), Trial(25, seed=3))
    assert scores["drawn"].pixels[Owner.ROBOT] > 100000
    assert scores["drawn"].share(Owner.ROBOT) >= 0.999
    assert scores["drawn"].share(Owner.PERSON) <= 0.002
    assert scores["drawn"].worst <= 0.01
