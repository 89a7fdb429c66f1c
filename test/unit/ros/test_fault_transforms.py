"""What bench/faults.py does to messages: each fault is one, and a healthy message stays so."""

import copy
import math

import numpy as np
import pytest
import rospy
from geometry_msgs.msg import TransformStamped, Twist
from nav_msgs.msg import Odometry
from safe_passage.msg import Person, PersonArray, TrackedObstacle, TrackedObstacleArray
from safe_passage.ros.conversions import to_cloud
from sensor_msgs.msg import JointState, LaserScan
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from bench.fault_transforms import (
    BEHIND,
    NOWHERE,
    OF_TF,
    OLD,
    SLOW,
    faults_of,
    has_nan,
    shifted,
)

HEADER = Header(stamp=rospy.Time(100), frame_id="laser")


def messages():
    cells = [0.0, 0.1, 0.2, 0.3]
    obstacle = TrackedObstacle(cells_x=cells, cells_y=cells)
    transform = TransformStamped(header=HEADER, child_frame_id="base")
    transform.transform.rotation.w = 1.0
    return (
        LaserScan(header=HEADER, ranges=[1.0] * 8, range_max=9.0),
        to_cloud(HEADER, np.ones((4, 6, 3), np.float32), np.zeros((4, 6, 3), np.uint8)),
        TrackedObstacleArray(header=HEADER, obstacles=[obstacle], sensors=["a"], alive=[True]),
        PersonArray(header=HEADER, persons=[Person()]),
        JointState(header=HEADER, name=["a", "b"], position=[0.1, 0.2]),
        Odometry(header=HEADER, child_frame_id="base"),
        Twist(),
        TFMessage([transform, copy.copy(transform)]),  # that share a header
    )


CASES = [(m, name) for m in messages() for name in faults_of(m)]


@pytest.mark.parametrize(
    ("message", "name"), CASES, ids=[f"{type(m).__name__} {name}" for m, name in CASES]
)
def test_a_fault_changes_what_is_sent_and_not_the_message(message, name):
    before, transform = copy.deepcopy(message), faults_of(message)[name]
    streams = [transform(message, number) for number in range(2 * SLOW)]
    assert message == before
    assert streams != [[message]] * len(streams)


def test_faults_that_have_no_meaning_are_left_out():
    can = {type(message).__name__: set(faults_of(message)) for message in messages()}
    assert can["Twist"] == {"silent", "slow", "NaN", "huge", "duplicated"}
    assert "truncated" not in can["Odometry"]
    assert "truncated" not in can["PersonArray"]
    assert {"empty", "truncated", "wrong frame"} <= can["LaserScan"] & can["PointCloud2"]
    assert can["TFMessage"] == set(OF_TF)


@pytest.mark.parametrize("message", [m for m in messages() if "NaN" in faults_of(m)])
def test_every_message_of_nan_has_one(message):
    for number in range(4):
        (spoilt,) = faults_of(message)["NaN"](message, number)
        if hasattr(spoilt, "point_step"):
            assert np.isnan(np.frombuffer(spoilt.data, np.float32)).all()
        else:
            assert has_nan(spoilt)


def test_scans_of_nan_keep_their_geometry_every_second_time():
    scan = messages()[0]
    (arrays,), (everything,) = (faults_of(scan)["NaN"](scan, number) for number in (0, 1))
    assert arrays.range_max == 9.0
    assert math.isnan(everything.range_max)


def test_truncated_arrays_are_shorter_than_told():
    _, cloud, tracks, _, joints, *_ = messages()
    (short,) = faults_of(cloud)["truncated"](cloud, 0)
    assert len(short.data) < short.height * short.row_step
    (short,) = faults_of(joints)["truncated"](joints, 0)
    assert len(short.position) < len(short.name)
    (of_sensors,), (of_cells,) = (faults_of(tracks)["truncated"](tracks, k) for k in (0, 1))
    assert len(of_sensors.alive) < len(of_sensors.sensors)
    assert len(of_cells.obstacles[0].cells_y) < len(of_cells.obstacles[0].cells_x)


@pytest.mark.parametrize(
    "message", [m for m in messages() if hasattr(m, "header") or hasattr(m, "transforms")]
)
def test_stamps_move_once_and_exactly(message):
    for name, seconds in (("stale", -OLD), ("future", OLD), ("out of order", -BEHIND)):
        (moved,) = faults_of(message)[name](message, 1)
        for one in getattr(moved, "transforms", [moved]):
            assert one.header.stamp.to_sec() == pytest.approx(100.0 + seconds)
    assert shifted(message, 0.0) == message


def test_rates_and_frames():
    scan, odometry = messages()[0], messages()[5]
    sent = [len(faults_of(scan)["slow"](scan, number)) for number in range(3 * SLOW)]
    assert sum(sent) == 3
    assert faults_of(scan)["silent"](scan, 0) == []
    assert len(faults_of(scan)["duplicated"](scan, 0)) == 2
    (moved,) = faults_of(odometry)["wrong frame"](odometry, 0)
    assert (moved.header.frame_id, moved.child_frame_id) == (NOWHERE, NOWHERE)


def test_no_transform_of_tf_wrong_is_one():
    message = messages()[-1]
    for number in range(3):
        (spoilt,) = OF_TF["tf wrong"](message, number)
        for one in spoilt.transforms:
            turn = one.transform.rotation
            length = math.hypot(math.hypot(turn.x, turn.y), math.hypot(turn.z, turn.w))
            assert length in (0.0, 2.0) or has_nan(one)


def test_what_may_be_nan_is_not_looked_at():
    person = PersonArray(header=HEADER, persons=[Person(height=math.nan)])
    assert has_nan(person) == "persons.height"
    assert not has_nan(person, frozenset({"height"}))
