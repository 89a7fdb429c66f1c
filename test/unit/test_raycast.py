"""Ray casting against distances worked out by hand, and against marching along the ray."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.simulation import raycast

FORWARD = np.array([[1.0, 0.0, 0.0]])
ORIGIN = np.zeros(3)
UP = np.array([0.0, 0.0, 1.0])


def test_plane_is_met_downwards_only():
    down = np.array([[0.6, 0.0, -0.8], [0.6, 0.0, 0.8], [1.0, 0.0, 0.0]])
    distances = raycast.plane_z(np.array([0.0, 0.0, 1.6]), down, 0.0)
    assert distances == pytest.approx([2.0, np.inf, np.inf])


def test_box_by_hand():
    low, high = np.array([2.0, -1.0, -1.0]), np.array([3.0, 1.0, 1.0])
    assert raycast.box(ORIGIN, FORWARD, low, high) == pytest.approx([2.0])
    assert np.isinf(raycast.box(ORIGIN, -FORWARD, low, high))
    assert np.isinf(raycast.box(np.array([0.0, 2.0, 0.0]), FORWARD, low, high))


def test_sphere_and_capsule_by_hand():
    centre = np.array([3.0, 0.0, 0.0])
    assert raycast.sphere(ORIGIN, FORWARD, centre, 1.0) == pytest.approx([2.0])
    upright = raycast.capsule(ORIGIN, FORWARD, centre - UP, centre + UP, 0.5)
    assert upright == pytest.approx([2.5])
    along = raycast.capsule(ORIGIN, FORWARD, np.array([2.0, 0, 0]), np.array([4.0, 0, 0]), 0.5)
    assert along == pytest.approx([1.5])


coordinate = st.floats(-2.0, 2.0)
point = st.tuples(coordinate, coordinate, coordinate).map(np.array)


@given(point, point, st.floats(0.05, 1.0), st.floats(-3.1, 3.1), st.floats(-1.5, 1.5))
def test_capsule_distance_ends_on_its_surface(a, b, radius, azimuth, elevation):
    if np.linalg.norm(b - a) < 0.01:
        return
    origin = np.array([5.0, 5.0, 5.0])
    ray = np.array(
        [
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        ]
    )
    distance = raycast.capsule(origin, ray[None], a, b, radius)[0]
    along = np.linspace(0.0, 20.0, 4001)
    points = origin + along[:, None] * ray
    foot = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    gaps = np.linalg.norm(points - a - foot[:, None] * (b - a), axis=1) - radius
    if np.isinf(distance):
        assert gaps.min() > -0.01
    else:
        end = origin + distance * ray
        s = np.clip((end - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        assert np.linalg.norm(end - a - s * (b - a)) == pytest.approx(radius, abs=1e-6)
        assert gaps[along < distance - 0.01].min(initial=np.inf) > -1e-6
