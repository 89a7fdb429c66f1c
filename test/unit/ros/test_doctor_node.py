"""What the doctor reads of messages and nodes without knowing them."""

import io

import pytest
import rospy
from safe_passage.ros.doctor_node import read_header, subscriptions
from sensor_msgs.msg import LaserScan


def test_stamp_and_frame_of_any_message_with_a_header():
    scan = LaserScan()
    scan.header.stamp, scan.header.frame_id = rospy.Time(12, 500_000_000), "robot1/laser"
    data = io.BytesIO()
    scan.serialize(data)
    stamp, frame = read_header(data.getvalue())
    assert stamp == pytest.approx(12.5)
    assert frame == "robot1/laser"


def test_a_node_that_has_died_reads_nothing():
    assert subscriptions("http://localhost:1") == []
