"""When the robot must stand, whatever the obstacles."""

import numpy as np
import pytest
from safe_passage.separation import Inputs, Reason, Supervisor
from sep_people import parameters

WELL = Inputs(now=100.0, tracks=99.9, odometry=99.9)
AGES = np.array([30.0, 20.0, 0.5])
IDS = np.array([4, 9, 30])


def supervisor(**changes) -> Supervisor:
    """Of a tracker that has been at work for long."""
    made = Supervisor(parameters(**changes))
    made.saw_tracks(99.8, IDS, AGES - 0.1)
    made.saw_tracks(99.9, IDS, AGES)
    return made


def with_(**changes) -> Inputs:
    return Inputs(**{**vars(WELL), **changes})


@pytest.mark.parametrize(
    "changes, reason",
    [
        ({}, Reason.OK),
        ({"tracks": None}, Reason.NO_TRACKS),
        ({"tracks": 99.4}, Reason.STALE_TRACKS),
        ({"tracks": 100.2}, Reason.STALE_TRACKS),
        ({"odometry": None}, Reason.NO_ODOMETRY),
        ({"odometry": 99.4}, Reason.STALE_ODOMETRY),
        ({"odometry": 100.2}, Reason.STALE_ODOMETRY),
        ({"placed": False}, Reason.NO_TF),
        ({"all_see": False}, Reason.SENSOR_SILENT),
        ({"tracks": None, "placed": False}, Reason.NO_TRACKS),
    ],
)
def test_each_input_has_its_reason_and_nothing_is_latched(changes, reason):
    judge = supervisor()
    assert judge.judge(with_(**changes)) is reason
    assert judge.judge(WELL) is Reason.OK


@pytest.mark.parametrize(
    "stamp, ids, ages",
    [
        (99.5, IDS, AGES),  # stamps go back
        (100.0, np.array([4, 9]), np.array([0.1, 0.1])),  # the same numbers, younger
        (100.0, np.array([1, 2]), np.array([0.1, 0.1])),  # low numbers, born late
    ],
)
def test_a_tracker_that_started_anew_must_settle(stamp, ids, ages):
    judge = supervisor(settle_time=1.45)
    judge.saw_tracks(stamp, ids, np.minimum(ages, 0.1))
    assert judge.judge(with_(tracks=stamp)) is Reason.TRACKER_RESTARTED
    for k in range(1, 17):
        judge.saw_tracks(stamp + 0.1 * k, ids, 0.1 + np.full(len(ids), 0.1 * k))
        now = stamp + 0.1 * k
        found = judge.judge(with_(now=now, tracks=now, odometry=now))
        assert found is (Reason.OK if k >= 14 else Reason.TRACKER_RESTARTED), k


@pytest.mark.parametrize(
    "stamp, ids, ages",
    [
        (99.5, IDS[:0], AGES[:0]),  # only the stamp goes back
        (100.0, IDS[2:], np.array([0.1])),  # only the newest is younger
        (100.0, np.array([1]), np.array([0.1])),  # only a low number is used again
    ],
)
def test_each_sign_of_a_restart_is_enough(stamp, ids, ages):
    judge = supervisor()
    judge.saw_tracks(99.95, IDS[2:], AGES[2:] + 0.05)  # the old ones are gone
    judge.saw_tracks(stamp, ids, ages)
    assert judge.judge(with_(tracks=stamp)) is Reason.TRACKER_RESTARTED


def test_a_track_that_was_confirmed_late_is_no_restart():
    """Its number is low because it was born long ago."""
    judge = supervisor()
    judge.saw_tracks(100.0, np.array([4, 12, 30]), np.array([30.1, 15.0, 0.6]))
    assert judge.judge(WELL) is Reason.OK


def test_a_tracker_that_sees_nothing_settles_too():
    judge = Supervisor(parameters(settle_time=0.95))
    none = np.empty(0)
    for k in range(12):
        judge.saw_tracks(100.0 + 0.1 * k, none, none)
        now = 100.0 + 0.1 * k
        expected = Reason.OK if k >= 10 else Reason.TRACKER_RESTARTED
        assert judge.judge(Inputs(now, now, now)) is expected


def test_after_a_clock_jump_that_is_the_reason_until_all_is_well():
    judge = supervisor(settle_time=0.5)
    judge.clock_jumped()
    assert judge.judge(Inputs(10.0, None, None)) is Reason.CLOCK_JUMP
    judge.saw_tracks(10.0, IDS, AGES)
    assert judge.judge(Inputs(10.0, 10.0, None)) is Reason.CLOCK_JUMP
    assert judge.judge(Inputs(10.0, 10.0, 10.0)) is Reason.OK
    assert judge.judge(Inputs(11.0, 10.0, 11.0)) is Reason.STALE_TRACKS
