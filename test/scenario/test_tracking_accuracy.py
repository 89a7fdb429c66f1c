"""The obstacle tracker on simulated scenarios with exact truth: what must not get worse."""

from pathlib import Path

import pytest
from safe_passage.evaluation.parallel import Workers
from safe_passage.evaluation.tracking_catalogue import TUNING_SEED, Catalogue
from safe_passage.evaluation.tracking_report import Line, judge_all, total
from safe_passage.evaluation.tracking_runs import ABLATION, tracker_parameters

CONFIG = Path(__file__).resolve().parents[2] / "config"
NAMES = ("crossing_driving", "fig6", "static_driving")


@pytest.fixture(scope="module")
def scenarios():
    return [Catalogue(CONFIG, TUNING_SEED).make(name) for name in NAMES]


@pytest.fixture(scope="module")
def lines(scenarios) -> dict[str, Line]:
    found = judge_all(scenarios, tracker_parameters(CONFIG), Workers())
    return {line.scenario: line for line in found}


def test_people_who_cross_are_tracked_while_the_robot_drives(lines):
    score = lines["crossing_driving"].score
    assert score.mota > 0.85
    assert score.idf1 > 0.80
    assert score.motp < 0.20


def test_who_walks_around_the_robot_keeps_one_identity(lines):
    """Fig. 6, through the fields of view of two lidars and two depth cameras."""
    assert lines["fig6"].ids == 1
    assert lines["fig6"].score.mota > 0.85


def test_what_stands_is_not_called_moving_while_the_robot_drives(lines):
    assert lines["static_driving"].score.false_moving_share < 0.02


def test_nothing_moves_that_comes_into_the_view_of_a_camera_on_a_turning_robot():
    scenario = Catalogue(CONFIG, TUNING_SEED, camera_rate=5.0).make("static_turning")
    (line,) = judge_all([scenario], tracker_parameters(CONFIG), Workers())
    assert line.score.static_tracks > 50
    assert line.score.false_moving_share < 0.02


def test_the_papers_extensions_are_worth_it(scenarios, lines):
    baseline = total(
        judge_all(scenarios, tracker_parameters(CONFIG, ABLATION["baseline"]), Workers())
    )
    ours = total(list(lines.values()))
    assert ours.score.mota > baseline.score.mota + 0.1
    assert ours.score.false_moving_share < baseline.score.false_moving_share
