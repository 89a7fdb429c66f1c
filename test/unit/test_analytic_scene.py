"""The analytic aisle: its camera and its lidar see the same, exactly known world."""

import numpy as np
import pytest
from safe_passage.simulation.analytic_scene import AnalyticScene
from safe_passage.simulation.bodies import Person


@pytest.fixture(scope="module")
def scene():
    return AnalyticScene(noise=0.0)


def test_floor_depth_is_the_planes(scene):
    depth, _ = scene.render(0.0)
    camera = scene.camera
    u, v = 320, 470  # a pixel of the floor before the robot
    ray = np.array([(u - 319.5) / camera.focal, (v - 239.5) / camera.focal, 1.0])
    drop = camera.rotation() @ ray
    assert depth[v, u] == pytest.approx(-camera.z / drop[2], abs=1e-4)


def test_lidar_meets_the_racks_upright(scene):
    left = scene.scan(0.0, np.array([np.pi / 2]), z=0.12, x=0.24, max_range=20.0)
    assert left == pytest.approx([1.6])


def test_lidar_meets_a_leg_where_the_person_stands(scene):
    person = scene.persons(0.0)[1]
    bearing = np.arctan2(person.y, person.x)
    ranges = scene.scan(0.0, bearing + np.linspace(-0.06, 0.06, 41), 0.12, 0.0, 20.0)
    assert ranges.min() == pytest.approx(np.hypot(person.x, person.y), abs=0.25)


def test_same_time_same_frame_other_time_other_frame():
    scene = AnalyticScene()
    first, again, later = scene.render(1.0), scene.render(1.0), scene.render(1.5)
    assert np.array_equal(first[0], again[0], equal_nan=True)
    assert np.array_equal(first[1], again[1])
    assert not np.array_equal(first[1], later[1])


@pytest.mark.parametrize("height", [1.5, 1.75, 2.0])
def test_bodies_are_as_tall_as_they_say_and_stand_on_the_floor(height):
    parts = Person(1.0, 2.0, yaw=0.7, height=height).capsules()
    tops = [max(part.a[2], part.b[2]) + part.radius for part in parts]
    lows = [min(part.a[2], part.b[2]) - part.radius for part in parts]
    assert max(tops) == pytest.approx(height, abs=0.02)
    assert min(lows) == pytest.approx(0.0, abs=0.03)
