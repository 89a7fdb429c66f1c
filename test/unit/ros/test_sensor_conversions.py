"""Scans and clouds to arrays, or refused with a reason."""

import math

import numpy as np
import pytest
from safe_passage.ros.conversions import to_cloud, to_header
from safe_passage.ros.diagnostics import Outcome
from safe_passage.ros.sensor_conversions import (
    UnusableMessageError,
    cloud_xyz,
    sampled_xyz,
    scan_beams,
)
from sensor_msgs.msg import LaserScan, PointField

XYZ = np.arange(24, dtype=np.float32).reshape(2, 4, 3)


def make_scan(**changes):
    fields = {
        "angle_min": -1.0, "angle_increment": 0.1, "range_min": 0.5, "range_max": 9.0,
        "ranges": [1.0, 2.0],
    }  # fmt: skip
    scan = LaserScan(**{**fields, **changes})
    scan.angle_max = scan.angle_min + scan.angle_increment * (len(scan.ranges) - 1)
    return scan


def make_cloud(**changes):
    cloud = to_cloud(to_header(None, "camera"), XYZ, np.zeros((2, 4, 3), np.uint8))
    for name, value in changes.items():
        setattr(cloud, name, value)
    return cloud


def refusal(convert, message):
    with pytest.raises(UnusableMessageError) as caught:
        convert(message)
    return caught.value.outcome


def test_what_is_outside_the_scanners_range_is_no_return():
    beams = scan_beams(make_scan(ranges=[0.4, 0.5, 9.0, 9.1, math.inf, math.nan, -1.0]))
    assert np.isnan(beams.ranges).tolist() == [True, False, False, True, True, True, True]
    assert beams.angles()[1] == pytest.approx(-0.9)


@pytest.mark.parametrize(("missing", "is_used"), [(-2, True), (0, True), (2, True), (50, False)])
def test_a_scan_is_refused_where_beams_are_missing_or_too_many(missing, is_used):
    scan = make_scan(ranges=[1.0] * 100)
    scan.ranges = [1.0] * (100 - missing)
    if is_used:
        assert len(scan_beams(scan).ranges) == 100 - missing
    else:
        with pytest.raises(UnusableMessageError, match="50 beams, angles of 100"):
            scan_beams(scan)


@pytest.mark.parametrize(
    ("changes", "outcome"),
    [
        ({"ranges": []}, Outcome.EMPTY),
        ({"ranges": [math.nan] * 3}, Outcome.NOT_FINITE),
        ({"angle_increment": 0.0}, Outcome.BAD_FIELDS),
        ({"angle_increment": math.nan}, Outcome.BAD_FIELDS),
        ({"angle_min": math.inf}, Outcome.BAD_FIELDS),
        ({"range_max": 0.5}, Outcome.BAD_FIELDS),
    ],
)
def test_scans_that_say_nothing_are_refused(changes, outcome):
    assert refusal(scan_beams, make_scan(**changes)) is outcome


def test_a_scan_without_returns_says_something():
    assert np.isnan(scan_beams(make_scan(ranges=[math.inf, math.nan])).ranges).all()


def test_a_cloud_s_points():
    assert cloud_xyz(make_cloud()).tolist() == XYZ.reshape(-1, 3).tolist()


def test_padding_and_byte_order_are_respected():
    cloud = make_cloud()
    padded = np.zeros((2, 20), ">u4")
    padded[:, :16] = np.frombuffer(cloud.data, "<u4").reshape(2, 16)
    cloud.data, cloud.row_step, cloud.is_bigendian = padded.tobytes(), 80, True
    assert cloud_xyz(cloud).tolist() == XYZ.reshape(-1, 3).tolist()


@pytest.mark.parametrize(
    ("changes", "outcome"),
    [
        ({"width": 0}, Outcome.EMPTY),
        ({"height": 0}, Outcome.EMPTY),
        ({"width": 0, "height": 0, "data": b"", "row_step": 0}, Outcome.EMPTY),
        ({"width": 0, "height": 2**32 - 1}, Outcome.EMPTY),
        ({"point_step": 0}, Outcome.BAD_FIELDS),
        ({"point_step": 0, "row_step": 0, "data": b""}, Outcome.BAD_FIELDS),
        ({"fields": []}, Outcome.BAD_FIELDS),
        ({"fields": [PointField(a, 0, PointField.FLOAT64, 1) for a in "xyz"]}, Outcome.BAD_FIELDS),
        ({"fields": [PointField(a, 14, PointField.FLOAT32, 1) for a in "xyz"]}, Outcome.BAD_FIELDS),
        ({"data": b"short"}, Outcome.BAD_FIELDS),
        ({"row_step": 8}, Outcome.BAD_FIELDS),
        ({"data": np.full(32, np.nan, np.float32).tobytes()}, Outcome.NOT_FINITE),
    ],
)
def test_clouds_that_cannot_be_read_are_refused(changes, outcome):
    assert refusal(cloud_xyz, make_cloud(**changes)) is outcome
    assert refusal(lambda one: sampled_xyz(one, 2.0, 0.1), make_cloud(**changes)) is outcome


def make_picture(rows, columns, holes=False):
    """A wall 2 m ahead of a camera with 90 degrees; holes: its middle row and column are NaN."""
    v, u = np.mgrid[:rows, :columns]
    x, y = 4.0 * ((u + 0.5) / columns - 0.5), 4.0 * ((v + 0.5) / rows - 0.5)
    xyz = np.stack([x, y, np.full(u.shape, 2.0)], axis=2).astype(np.float32)
    if holes:
        xyz[rows // 2, :], xyz[:, columns // 2] = np.nan, np.nan
    return to_cloud(to_header(None, "camera"), xyz, np.zeros((rows, columns, 3), np.uint8))


def test_pixels_are_sampled_so_that_no_cell_within_reach_lacks_one():
    every = cloud_xyz(make_picture(100, 200))
    some = sampled_xyz(make_picture(100, 200), reach=2.0, spacing=0.1)
    assert {tuple(p) for p in some} <= {tuple(p) for p in every}
    for axis, extent in ((0, 2.0), (1, 2.0)):
        lines = np.unique(some[:, axis])
        assert 0.07 < np.diff(lines).max() <= 0.1001
        assert lines[0] + extent < 0.1
        assert extent - lines[-1] < 0.1


@pytest.mark.parametrize("shape", [(20, 30), (1, 400), (400, 1)])
def test_few_points_are_all_kept(shape):
    some = sampled_xyz(make_picture(*shape), reach=2.0, spacing=0.1)
    assert len(some) == shape[0] * shape[1]


def test_where_nobody_knows_how_dense_they_lie_all_are_kept():
    some = sampled_xyz(make_picture(100, 100, holes=True), reach=2.0, spacing=0.1)
    assert len(some) == 100 * 100


def test_a_cloud_in_rings_keeps_them_all():
    some = sampled_xyz(make_picture(16, 400), reach=2.0, spacing=0.1)
    assert len(np.unique(some[:, 1])) == 16
    assert len(np.unique(some[:, 0])) < 60
