"""The folder of recordings on which the tracker is judged: what is read of it."""

import math

import numpy as np
import pytest
import rosbag
import rospy
from geometry_msgs.msg import PoseStamped
from safe_passage.core.errors import InputError
from safe_passage.evaluation.tracking_real import CAME, LEGS, VEHICLE
from safe_passage.ros.tracker_recordings import read_tracking
from sensor_msgs.msg import LaserScan

ROOM = [2.0 / max(abs(math.cos(a)), abs(math.sin(a))) for a in np.arange(360) * math.pi / 180]


def scan(i):
    message = LaserScan(angle_increment=math.pi / 180, range_max=10.0, ranges=ROOM)
    message.header.stamp = rospy.Time(10, 10**8 * i)
    return message


def pose(i, x):
    message = PoseStamped()
    message.header.stamp = rospy.Time(10, 10**8 * i)
    message.pose.position.x, message.pose.orientation.w = x, 1.0
    return message


@pytest.fixture
def bag(tmp_path):
    """Writes a bag of (topic, message) into a folder; returns the folder of all."""

    def write(folder, *messages):
        (tmp_path / folder).mkdir()
        with rosbag.Bag(str(tmp_path / folder / "tiny.bag"), "w") as out:
            for topic, message in messages:
                out.write(topic, message)
        return tmp_path

    return write


def test_a_car_is_where_it_was_seen_from_the_other(bag):
    messages = [
        *(("/scan", scan(i)) for i in range(1, 4)),
        *(("/ego_pose", pose(i, 5.0)) for i in range(5)),
        *(("/red_pose", pose(i, 6.0 + 0.1 * i)) for i in range(5)),
    ]
    (found,) = read_tracking(bag("lidar2d_vehicles", *messages))
    assert found.truth == VEHICLE
    assert found.way[:, 1:] == pytest.approx(np.zeros((3, 3)), abs=0.01)
    assert found.vehicle[:, 1] == pytest.approx([1.1, 1.2, 1.3], abs=0.01)


def test_two_scanners_have_their_mountings(bag):
    messages = [("/front_scan", scan(0)), ("/rear_scan", scan(1)), ("/front_scan", scan(2))]
    (found,) = read_tracking(bag("lidar2d_two_scanners", *messages))
    front, rear = found.scanners
    assert (front.name, len(front.scans), rear.name, len(rear.scans)) == (
        *("laser_front", 2),
        *("laser_rear", 1),
    )
    assert rear.mounting[2] == pytest.approx(math.pi)


def test_what_is_missing_is_named(bag, tmp_path):
    with pytest.raises(InputError, match="no bags in lidar2d_legs"):
        read_tracking(tmp_path)
    folder = bag("lidar2d_two_scanners", ("/scan", scan(0)))
    with pytest.raises(InputError, match=r"tiny.bag: scans of \['/scan'\]"):
        read_tracking(folder)


def test_a_car_without_poses_is_refused(bag):
    with pytest.raises(InputError, match="needs /scan, /ego_pose and /red_pose"):
        read_tracking(bag("lidar2d_vehicles", ("/scan", scan(0))))


def test_the_recordings(recordings):
    found = {one.name: one.truth for one in read_tracking(recordings, ["positive_2", "scans"])}
    assert found == {"positive_2": LEGS, "scans_demo": CAME}
