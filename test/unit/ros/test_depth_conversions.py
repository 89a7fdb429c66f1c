"""Depth images between messages and arrays; bags of an arm into views."""

import numpy as np
import pytest
import rosbag
import rospy
from safe_passage.core.errors import InputError
from safe_passage.ros.calibration_recordings import read_arm_bag
from safe_passage.ros.conversions import to_camera_info, to_depth_image
from safe_passage.ros.depth_conversions import (
    from_camera_info,
    from_depth_image,
    to_points,
    to_same_image,
)
from safe_passage.ros.diagnostics import Outcome
from safe_passage.ros.sensor_conversions import UnusableMessageError, cloud_xyz
from sensor_msgs.msg import CameraInfo, Image, JointState
from std_msgs.msg import Header

HEADER = Header(frame_id="camera", stamp=rospy.Time(7))
DEPTH = np.array([[1.0, np.nan, 2.5], [0.5, 3.0, 4.0]], np.float32)


def test_images_of_both_kinds_padded_and_of_either_byte_order():
    np.testing.assert_array_equal(from_depth_image(to_depth_image(HEADER, DEPTH)), DEPTH)
    rows = np.array([[1000, 0, 2500, 7], [500, 3000, 65535, 7]])
    for endian in "<>":
        data = rows.astype(endian + "u2").tobytes()
        message = Image(HEADER, 2, 3, "16UC1", endian == ">", 8, data)
        image = from_depth_image(message)
        np.testing.assert_array_equal(image, rows[:, :3])
        assert image.dtype == np.uint16
        again = to_same_image(message, image)
        np.testing.assert_array_equal(from_depth_image(again), rows[:, :3])
        assert (again.header, again.encoding) == (HEADER, "16UC1")


@pytest.mark.parametrize(
    ("changes", "outcome"),
    [
        ({"encoding": "rgb8"}, Outcome.BAD_FIELDS),
        ({"height": 0}, Outcome.EMPTY),
        ({"step": 4}, Outcome.BAD_FIELDS),
        ({"data": b"short"}, Outcome.BAD_FIELDS),
    ],
)
def test_what_is_no_depth_image(changes, outcome):
    message = to_depth_image(HEADER, DEPTH)
    for name, value in changes.items():
        setattr(message, name, value)
    with pytest.raises(UnusableMessageError) as error:
        from_depth_image(message)
    assert error.value.outcome is outcome


def test_a_camera_and_its_points():
    camera = from_camera_info(to_camera_info(HEADER, (2, 3), (100.0, 90.0, 1.0, 0.5)))
    assert (camera.width, camera.height, camera.fy) == (3, 2, 90.0)
    cloud = to_points(HEADER, DEPTH, camera)
    assert (cloud.width, cloud.height) == (3, 2)
    points = cloud_xyz(cloud)
    np.testing.assert_allclose(
        points[np.isfinite(points[:, 2])], camera.points(DEPTH), rtol=1e-5, atol=1e-7
    )
    with pytest.raises(UnusableMessageError):
        from_camera_info(CameraInfo())


def write(path, without=(), depth_topics=("camera/depth/image",)):
    """The arm stands at 0, moves, stands at 0.5."""
    with rosbag.Bag(str(path), "w") as out:
        for i in range(60):
            stamp = rospy.Time.from_sec(100.0 + 0.05 * i)
            angle = float(np.interp(i, [20, 40], [0.0, 0.5]))
            header = Header(frame_id="camera", stamp=stamp)
            if "joints" not in without:
                joints = JointState(header=header, name=["a"], position=[angle])
                out.write("joint_states", joints, stamp)
            for topic in depth_topics:
                out.write(topic, to_depth_image(header, DEPTH + np.float32(angle)), stamp)
            if "info" not in without:
                info = to_camera_info(header, (2, 3), (100.0, 90.0, 1.0, 0.5))
                out.write("camera/depth/camera_info", info, stamp)
                out.write("camera/rgb/camera_info", info, stamp)
    return path


def test_a_bag_is_cut_into_poses(tmp_path):
    recording = read_arm_bag(write(tmp_path / "arm.bag"), ("a",), 0.5)
    assert [view.positions["a"] for view in recording.views] == pytest.approx([0.0, 0.5])
    np.testing.assert_allclose(recording.views[1].depth, DEPTH + 0.5)
    assert recording.camera.fx == 100.0


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"without": ("joints",)}, "never stands still with its joints a"),
        ({"without": ("info",)}, "one camera_info"),
        ({"depth_topics": ()}, "one topic of depth images"),
        ({"depth_topics": ("one/image", "two/image")}, "one topic of depth images"),
    ],
)
def test_what_a_bag_lacks_is_named(tmp_path, arguments, says):
    with pytest.raises(InputError, match=says):
        read_arm_bag(write(tmp_path / "arm.bag", **arguments), ("a",), 0.5)
