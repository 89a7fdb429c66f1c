"""The obstacle tracker on real recordings: what must not get worse (`evaluate recordings`)."""

from pathlib import Path

import pytest
from safe_passage.evaluation.tracking_real_report import judge_all

from bench.tracker import read_tracking

CONFIG = Path(__file__).resolve().parents[2] / "config"
NAMES = ("positive_2", "positive_3", "scans_demo", "parallel")


@pytest.fixture(scope="module")
def results(recordings):
    found = judge_all(read_tracking(recordings, NAMES), CONFIG)
    return {one.recording.name: one for one in found}


def test_who_walks_is_tracked_with_few_identities(results):
    """Measured: 84 % and 86 % of the person-cycles, the first second of each walk included."""
    for name in ("positive_2", "positive_3"):
        one = results[name]
        assert one.found == one.movers
        assert one.tracked > 0.75 * one.mover_cycles
        assert one.ids <= 3


def test_whoever_goes_round_two_scanners_keeps_one_identity(results):
    """Measured: 86 %."""
    one = results["scans_demo"]
    assert one.ids == 1
    assert one.tracked > 0.75 * one.mover_cycles


def test_another_car_is_tracked_from_a_driving_one(results):
    """Measured: 98 %, 0.22 m/s."""
    one = results["parallel"]
    assert one.ids == 1
    assert one.tracked > 0.9 * one.mover_cycles
    assert one.speed_error < 0.4


def test_what_stands_is_not_called_moving_while_the_robot_stands(results):
    assert [results[name].false_moving for name in NAMES[:3]] == [0, 0, 0]
