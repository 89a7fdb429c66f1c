"""Bags to recordings: what is in them, or why they cannot be used."""

import math

import pytest
import rosbag
import rospy
from damage import FEW, damaged
from geometry_msgs.msg import Point, Pose, PoseArray
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.core.errors import InputError
from safe_passage.ros.leg_recordings import read_negative, read_positive
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String


def scan(i, **changes):
    message = LaserScan(angle_increment=0.01, range_max=10.0, ranges=[1.0, math.inf, 2.0 + i])
    message.header.stamp = rospy.Time(10 + i)
    for name, value in changes.items():
        setattr(message, name, value)
    return message


def legs(*places):
    return PoseArray(poses=[Pose(position=Point(x, y, 0.0)) for x, y in places])


@pytest.fixture
def bag(tmp_path):
    """Writes a bag of (topic, message)."""

    def write(*messages):
        path = tmp_path / "walk_1.bag"
        with rosbag.Bag(str(path), "w") as out:
            for i, (topic, message) in enumerate(messages):
                out.write(topic, message, rospy.Time(100, i + 1))
        return path

    return write


def test_the_nth_legs_are_of_the_nth_scan(bag):
    path = bag(
        ("/legs", legs((1.0, 2.0))), ("/scan", scan(0)), ("/note", String("walks")),
        ("/legs", legs()), ("/scan", scan(1)),
    )  # fmt: skip
    found = read_positive(path)
    assert found.name == "walk_1"
    assert [one.stamp for one in found.scans] == [10.0, 11.0]
    assert found.scans[1].ranges.tolist() == [1.0, math.inf, 3.0]
    assert found.legs[0].tolist() == [[1.0, 2.0]]
    assert found.legs[1].shape == (0, 2)


def test_every_scanner_of_an_empty_room(bag):
    path = bag(("/rear", scan(0)), ("/front", scan(1)), ("/rear", scan(2)))
    front, rear = read_negative(path)
    assert [len(front.scans), len(rear.scans)] == [1, 2]
    assert front.legs is None
    assert front.name == rear.name == "walk_1"  # one room: never split over training and test


@pytest.mark.parametrize(
    ("messages", "complaint"),
    [
        ([], "needs one topic of sensor_msgs/LaserScan and one of .*, has none"),
        ([("/scan", scan(0))], r"has \['/scan'\]"),
        ([("/legs", legs())], r"has \['/legs'\]"),
        ([("/a", scan(0)), ("/b", scan(0)), ("/legs", legs())], r"has \['/a', '/b', '/legs'\]"),
        ([("/scan", scan(0)), ("/scan", scan(1)), ("/legs", legs())], "2 scans, but .* of 1"),
        ([("/scan", scan(0, ranges=[])), ("/legs", legs())], "a scan with no beams"),
        ([("/scan", scan(0, angle_increment=0.0)), ("/legs", legs())], "angle_increment is 0"),
    ],
)
def test_what_is_no_recording_of_legs_is_refused(bag, messages, complaint):
    with pytest.raises(InputError, match=f"walk_1.bag: .*{complaint}"):
        read_positive(bag(*messages))


def test_no_scans_no_bag_no_file(bag, tmp_path):
    with pytest.raises(InputError, match="no topic of sensor_msgs/LaserScan"):
        read_negative(bag(("/note", String("empty"))))
    text = tmp_path / "text.bag"
    text.write_text("no bag")
    noise = tmp_path / "noise.bag"
    noise.write_bytes(b"\x80 no text either\n")  # of which rosbag passes on python's own error
    for path in (text, noise, tmp_path / "none.bag"):
        with pytest.raises(InputError, match=path.name):
            read_negative(path)


@FEW
@given(data=st.data())
def test_whatever_became_of_a_bag(bag, data):
    path = bag(*[("/scan", scan(i)) for i in range(3)])
    path.write_bytes(damaged(data, path.read_bytes()))
    try:
        read_negative(path)
    except InputError as error:
        assert "walk_1.bag" in str(error)


def test_the_recorded_legs(recordings):
    paths = sorted((recordings / "lidar2d_legs").glob("positive_*.bag"))
    found = [read_positive(path) for path in paths]
    assert sum(len(one.scans) for one in found) == 1204
    assert sum(len(legs) for one in found for legs in one.legs) == 1852
    negative = read_negative(recordings / "lidar2d_legs" / "negative_2.bag")
    assert [len(one.scans) for one in negative] == [435, 435, 434]
