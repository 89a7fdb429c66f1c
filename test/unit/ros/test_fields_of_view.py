"""Sectors of scanners and cameras, however they are mounted."""

import math

import numpy as np
import pytest
from safe_passage.monitoring.parameters import CLOUD, SourceParameters
from safe_passage.ros.fields_of_view import of_cloud, of_scan
from safe_passage.ros.sensor_conversions import Beams
from scipy.spatial.transform import Rotation

LASER = SourceParameters("laser", range_min=0.2, range_max=9.0)
CAMERA = SourceParameters("camera", type=CLOUD, range_max=5.0)


def mounted(yaw=0.0, roll=0.0, at=(1.0, 2.0, 0.3)):
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("ZYX", (yaw, 0.0, roll)).as_matrix()
    T[:3, 3] = at
    return T


def ends(field):
    return sorted(np.unwrap(field.bearings)[[0, -1]])


def test_a_scanner_sees_from_its_first_beam_to_its_last():
    beams = Beams(np.ones(91), -0.5, 1.5 / 90)
    field = of_scan(beams, mounted(yaw=0.3), LASER)
    assert ends(field) == pytest.approx([-0.2, 1.3])
    assert field.origin.tolist() == [1.0, 2.0]
    assert field.reach == (0.2, 9.0)
    assert np.abs(np.diff(field.bearings)).max() < 0.06


def test_upside_down_left_is_right():
    beams = Beams(np.ones(91), -0.5, 1.5 / 90)
    assert ends(of_scan(beams, mounted(roll=math.pi), LASER)) == pytest.approx([-1.0, 0.5])


def test_a_reversed_scanner_sees_the_same():
    forth, back = Beams(np.ones(91), -0.5, 1.5 / 90), Beams(np.ones(91), 1.0, -1.5 / 90)
    assert ends(of_scan(forth, mounted(), LASER)) == pytest.approx(
        ends(of_scan(back, mounted(), LASER))
    )


@pytest.mark.parametrize("yaw", [0.0, 2.0, 3.1])
def test_a_camera_sees_as_far_as_its_points_reach(yaw):
    bearings = np.linspace(-0.4, 0.6, 500)
    points = 3.0 * np.stack([np.cos(bearings), np.sin(bearings), 0.1 * bearings], axis=1)
    points[::7] = np.nan
    field = of_cloud(points, mounted(yaw=yaw), CAMERA)
    assert np.diff(ends(field)) == pytest.approx([1.0], abs=0.01)
    assert math.cos(np.mean(field.bearings) - yaw - 0.1) > 0.99


def test_a_cloud_from_all_around_has_no_gap():
    bearings = np.linspace(-math.pi, math.pi, 1000)
    points = np.stack([np.cos(bearings), np.sin(bearings), np.zeros(1000)], axis=1)
    assert np.diff(ends(of_cloud(points, mounted(), CAMERA))) == pytest.approx([2 * math.pi])


def test_of_no_points_nothing_is_known():
    assert of_cloud(np.full((3, 3), np.nan), mounted(), CAMERA) is None
