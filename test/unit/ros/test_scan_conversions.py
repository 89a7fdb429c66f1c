"""Scans as clouds and back; results as messages."""

import math

import numpy as np
import pytest
from safe_passage.core.errors import InputError, ParameterError
from safe_passage.msg import RobotConfiguration as RobotMessage
from safe_passage.msg import ScanSegmentation
from safe_passage.ros.replay_scan_node import about_z
from safe_passage.ros.scan_conversions import (
    from_robot,
    from_scan_cloud,
    to_organised,
    to_robot,
    to_scan_cloud,
    unit,
)
from safe_passage.ros.segmentation_conversions import reason_code, reduced, to_pose
from safe_passage.ros.sensor_conversions import UnusableMessageError
from safe_passage.scan_segmentation import OrganisedScan, Reason, RobotConfiguration
from safe_passage.scan_segmentation.assembling import Assembled
from safe_passage.scan_segmentation.basic_map import Colour, ColourMap
from safe_passage.scan_segmentation.scan import Level, line_images
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

UP = (0.0, 0.0, 1.0)


def scan(lines=4, points=5):
    rng = np.random.default_rng(1)
    xyz = rng.uniform(1.0, 3.0, (lines, points, 3)).astype(np.float32)
    xyz[1, 2] = np.nan
    return OrganisedScan(xyz, np.linspace(0.0, 1.0, lines), xyz[..., 0])


def message():
    one = scan()
    beta = np.repeat(one.beta[:, None], one.points.shape[1], axis=1)
    return to_scan_cloud(Header(frame_id="scanner"), Assembled(one, beta, 0.0, 1.0))


def test_a_scan_survives_the_way_there_and_back():
    back = to_organised(from_scan_cloud(message()), UP, None)
    np.testing.assert_array_equal(back.points, scan().points)
    np.testing.assert_allclose(back.beta, scan().beta, atol=1e-6)
    np.testing.assert_array_equal(back.remission, scan().remission)
    assert (back.axis, back.up) == (UP, UP)


def test_drivers_remission_of_other_types_and_zeros_for_no_return():
    layout = np.dtype([("x", ">f4"), ("y", ">f4"), ("z", ">f4"), ("reflectance", "u1")])
    points = np.ones((1, 6), layout)
    points["reflectance"] = 200
    points[0, 0] = 0, 0, 0, 7
    fields = [PointField(n, 4 * i, PointField.FLOAT32, 1) for i, n in enumerate("xyz")]
    fields.append(PointField("reflectance", 12, PointField.UINT8, 1))
    header = Header(frame_id="a")
    cloud = PointCloud2(header, 1, 6, fields, True, 13, 78, points.tobytes(), False)
    found = from_scan_cloud(cloud)
    assert found.beta is None
    assert np.isnan(found.cloud.points[0, 0]).all()
    np.testing.assert_array_equal(found.cloud.points[0, 1:], 1.0)
    np.testing.assert_array_equal(found.cloud.remission[0], [7, 200, 200, 200, 200, 200])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda m: setattr(m.header, "frame_id", ""), "no frame_id"),
        (lambda m: setattr(m, "data", m.data[:-1]), "bytes"),
        (lambda m: setattr(m.fields[4], "offset", 18), "field beta outside"),
        (lambda m: setattr(m.fields[4], "datatype", 99), "field beta outside"),
        (lambda m: setattr(m, "width", 0), "no points"),
        (lambda m: setattr(m, "height", 0), "no points"),
        (lambda m: setattr(m, "point_step", 0), "field x outside"),
    ],
)
def test_clouds_that_cannot_be_read_say_why(change, said):
    one = message()
    change(one)
    with pytest.raises(UnusableMessageError, match=said):
        from_scan_cloud(one)


def test_angles_that_are_not_finite():
    one = message()
    values = np.frombuffer(one.data, "<f4").reshape(4, 5, 5).copy()
    values[2, 3, 4] = np.nan
    one.data = values.tobytes()
    with pytest.raises(UnusableMessageError, match="beta is not finite"):
        from_scan_cloud(one)


def test_robots():
    robot = RobotConfiguration(width=0.5, margin=0.1)
    assert from_robot(to_robot(robot)) == robot
    assert from_robot(RobotMessage()) is None
    with pytest.raises(ParameterError, match="values/length"):
        from_robot(RobotMessage(width=1.0))


def test_directions():
    assert unit((0.0, 0.0, 2.0)) == UP
    for wrong in ((0.0, 0.0, 0.0), (1.0, 2.0), (math.nan, 0.0, 1.0)):
        with pytest.raises(InputError):
            unit(wrong)


def test_every_reason_has_its_number():
    codes = [reason_code(reason) for reason in Reason]
    assert len(set(codes)) == len(codes)
    assert ScanSegmentation.OK not in codes


def test_of_cells_that_become_one_the_worst_counts():
    g, o, r, u = Colour.GREEN, Colour.ORANGE, Colour.RED, Colour.UNKNOWN
    cells = np.array([[g, g, g, o, g], [g, g, g, u, g], [g, r, o, g, g]], np.uint8)
    small = reduced(ColourMap(cells, np.array([1.0, 2.0]), 0.1), 4)
    np.testing.assert_array_equal(small.cells, [[g, u, u], [r, u, u]])
    assert small.resolution == pytest.approx(0.2)
    whole = ColourMap(cells, np.zeros(2), 0.1)
    assert reduced(whole, 15) is whole


def test_poses_stand_upright_in_a_tilted_scanners_frame():
    tilted = OrganisedScan(np.zeros((1, 1, 3)), np.zeros(1), up=unit((0.5, 0.0, 1.0)))
    level = Level.of(tilted)
    pose = to_pose(level, (1.0, 2.0, -0.5), 0.3)
    place = np.array([pose.position.x, pose.position.y, pose.position.z])
    np.testing.assert_allclose(level.points(place), [1.0, 2.0, -0.5], atol=1e-9)
    x, y, z, w = (getattr(pose.orientation, name) for name in "xyzw")
    upward = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
    np.testing.assert_allclose(upward, tilted.up, atol=1e-9)


def test_a_replayed_scan_turns_about_z_of_its_frame():
    axis, origin = unit((0.3, 1.0, 0.2)), (0.5, -0.2, 0.1)
    about = OrganisedScan(scan().points, scan().beta, None, axis, origin, unit((0.0, 0.5, 1.0)))
    turned = about_z(about)
    for before, after in zip(line_images(about), line_images(turned)):
        np.testing.assert_allclose(after, before, atol=1e-5)  # what lines are found in
    heights = [Level.of(one).points(one.points)[..., 2] for one in (about, turned)]
    np.testing.assert_allclose(heights[1], heights[0], atol=1e-5)
