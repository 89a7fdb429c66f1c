"""Faults on demand act on what they name, when they are told to, the same way each time."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.core.errors import ParameterError
from safe_passage.simulation.faults import Fault, FaultPlan, make_fault_plan

SENSORS = ("laser", "camera")


def plan(*entries: dict, seed: int = 0) -> FaultPlan:
    return make_fault_plan(list(entries), SENSORS, seed)


def delivered(faults: FaultPlan, sensor: str, count: int = 4000) -> list[bool]:
    return [faults.delivered(sensor, 0.025 * i) for i in range(count)]


def test_without_faults_all_is_well():
    for well in (FaultPlan(), make_fault_plan(None, SENSORS)):
        assert all(delivered(well, "laser", 50)) and well.tf_available(1.0)
        assert well.delay("laser", 1.0) == well.odometry_drift(1.0) == 0.0


@given(st.floats(0.0, 1e4), st.floats(0.0, 1e3), st.floats(0.0, 2e4))
def test_a_fault_acts_from_its_start_until_before_its_end(start, lasts, time):
    fault = {"kind": "silence", "target": "laser", "start": start, "end": start + lasts}
    assert plan(fault).delivered("laser", time) == (not start <= time < start + lasts)
    assert plan(fault).delivered("camera", time)


def test_without_an_end_a_fault_lasts():
    silent = plan({"kind": "silence", "target": "camera", "start": 5.0})
    assert silent.delivered("camera", 4.999) and not silent.delivered("camera", 1e6)


def test_dropout_loses_that_share_of_messages_and_of_no_other_sensor():
    lossy = plan({"kind": "dropout", "target": "laser", "value": 0.3})
    assert sum(delivered(lossy, "laser")) / 4000 == pytest.approx(0.7, abs=0.03)
    assert all(delivered(lossy, "camera"))


def test_two_dropouts_at_once_are_independent():
    lossy = plan(*[{"kind": "dropout", "target": "laser", "value": 0.5}] * 2)
    assert sum(delivered(lossy, "laser")) / 4000 == pytest.approx(0.25, abs=0.03)


@pytest.mark.parametrize("share, kept", [(0.0, 200), (1.0, 0)])
def test_a_dropout_of_none_and_of_all(share, kept):
    lossy = plan({"kind": "dropout", "target": "laser", "value": share})
    assert sum(delivered(lossy, "laser", 200)) == kept


def test_the_same_seed_loses_the_same_messages_in_whatever_order_they_are_asked():
    lossy = {"kind": "dropout", "target": "laser", "value": 0.5}
    first = delivered(plan(lossy), "laser", 400)
    again = plan(lossy)
    backwards = [again.delivered("laser", 0.025 * i) for i in reversed(range(400))][::-1]
    assert backwards == first
    assert delivered(plan(lossy, seed=1), "laser", 400) != first


def test_sensors_lose_different_messages():
    both = plan(*[{"kind": "dropout", "target": name, "value": 0.5} for name in SENSORS])
    assert delivered(both, "laser", 400) != delivered(both, "camera", 400)


def test_latencies_tf_gaps_and_drift():
    faults = plan(
        {"kind": "latency", "target": "camera", "start": 1.0, "end": 3.0, "value": 0.2},
        {"kind": "latency", "target": "camera", "start": 2.0, "value": 0.5},
        {"kind": "tf_gap", "start": 4.0, "end": 5.0},
        {"kind": "odometry_drift", "start": 6.0, "value": 0.1},
        {"kind": "odometry_drift", "start": 7.0, "value": -0.3},
    )
    assert [faults.delay("camera", t) for t in (0.0, 1.0, 2.0, 3.0)] == [0.0, 0.2, 0.7, 0.5]
    assert faults.delay("laser", 2.0) == 0.0
    assert [faults.tf_available(t) for t in (3.9, 4.0, 4.9, 5.0)] == [True, False, False, True]
    assert [faults.odometry_drift(t) for t in (5.0, 6.0, 7.0)] == pytest.approx([0.0, 0.1, -0.2])


GOOD = {"kind": "dropout", "target": "laser", "value": 0.1}
WRONG = [
    ({"kind": "fire"}, r"faults\[1\]/kind is 'fire', must be one of dropout, latency"),
    ({"target": "laser"}, r"faults\[1\]: kind is missing"),
    ({**GOOD, "untill": 3}, r"faults\[1\]/untill is not known"),
    ({**GOOD, "value": 1.1}, r"faults\[1\]/value is 1.1, must lie in \[0.0, 1.0\] share"),
    ({**GOOD, "value": "much"}, r"faults\[1\]/value is 'much', must be a number"),
    ({**GOOD, "value": math.nan}, r"faults\[1\]/value is nan"),
    ({**GOOD, "start": -1.0}, r"faults\[1\]/start is -1.0"),
    ({**GOOD, "start": 3.0, "end": 2.0}, r"faults\[1\]/end is 2.0"),
    ({**GOOD, "target": "lasr"}, r"faults\[1\]/target is 'lasr', must be one of camera, laser"),
    ({"kind": "silence"}, r"faults\[1\]/target is '', must be the name of a sensor"),
    (
        {"kind": "silence", "target": "laser", "value": 1},
        r"faults\[1\]/value is 1.0, but a silence",
    ),
    ({"kind": "latency", "target": "laser", "value": -0.1}, r"faults\[1\]/value is -0.1"),
    ({"kind": "tf_gap", "target": "laser"}, r"faults\[1\]/target is 'laser', must be left out"),
    ({"kind": "odometry_drift", "value": 3.0}, r"faults\[1\]/value is 3.0"),
    ("dropout", r"faults\[1\] is 'dropout', must be a mapping"),
]


@pytest.mark.parametrize("entry, message", WRONG, ids=[str(entry) for entry, _ in WRONG])
def test_what_is_wrong_is_named(entry, message):
    with pytest.raises(ParameterError, match=message):
        plan(GOOD, entry)


def test_faults_can_be_made_without_yaml():
    assert not FaultPlan([Fault("tf_gap")]).tf_available(3.0)
    with pytest.raises(ParameterError, match="value is 2.0"):
        Fault("dropout", "laser", value=2.0)
