"""What sensors know to be free, of walls and things in a room."""

import numpy as np
import pytest
from camera_room import ROOM, body, camera, cloud
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.core.geometry import compose, inverse, placed
from safe_passage.monitoring.views import CloudView, seen_from

T = camera()
TALL = (0.1, 1.7)  # [m]


def judged(view: CloudView, *places, height=TALL):
    """Passed and ended (N,) at places (x, y) [m] in base."""
    at = np.array(places, float).reshape(-1, 2)
    return view.beams(at, np.tile(height, (len(at), 1)))


def test_what_the_camera_looks_through_is_free_and_what_it_meets_is_not():
    view = CloudView.of(cloud(T, body(3.0, 0.5)), T)
    passed, ended = judged(view, (2.0, -0.3), (2.8, 0.5), (ROOM, -1.0))
    assert passed.tolist() == [True, False, False]
    assert ended.tolist() == [False, True, True]


def test_of_what_is_hidden_or_out_of_view_nothing_is_known():
    view = CloudView.of(cloud(T, body(2.0, 0.0, size=0.8)), T)
    passed, ended = judged(view, (3.5, 0.0), (-2.0, 0.0), (2.0, 2.5))
    assert not passed.any() and not ended.any()


def test_what_it_looks_over_is_not_known_to_be_free():
    """Behind a low box nothing low is seen, but a person would be."""
    view = CloudView.of(cloud(T, body(2.0, 0.0, size=0.8, height=0.6)), T)
    assert not judged(view, (2.7, 0.0), height=(0.0, 0.3))[0].any()
    assert judged(view, (2.7, 0.0), height=(0.7, 1.7))[0].all()


def test_a_3d_lidar_has_no_view_because_between_its_rings_nobody_knows():
    angles = np.linspace(-np.pi, np.pi, 720)
    ring = np.column_stack([3 * np.cos(angles), 3 * np.sin(angles), np.zeros(720)])
    assert CloudView.of(ring, np.eye(4)) is None


@pytest.mark.parametrize("points", [np.empty((0, 3)), np.full((5, 3), np.nan), np.zeros((4, 3))])
def test_a_cloud_without_points_tells_nothing(points):
    passed, ended = judged(CloudView.of(points.astype(np.float32), T), (2.0, 0.0), (3.0, 1.0))
    assert not passed.any() and not ended.any()


def test_points_that_are_not_finite_are_as_none():
    points = cloud(T)
    dirty = np.concatenate([points, [[np.nan, 0, 1], [np.inf, 0, 1], [0, -np.inf, 2]]]).astype(
        np.float32
    )
    assert np.array_equal(CloudView.of(dirty, T).reach, CloudView.of(points, T).reach)


coordinate = st.floats(-5.0, 5.0)
poses = st.tuples(coordinate, coordinate, st.floats(-4.0, 4.0))


@given(pose=poses, other=poses, x=coordinate, y=coordinate)
def test_places_are_the_same_seen_from_elsewhere(pose, other, x, y):
    there = seen_from(pose, other, np.array([[x, y]]))
    assert placed(there, other) == pytest.approx(placed(np.array([[x, y]]), pose), abs=1e-9)
    assert compose(inverse(other), pose)[:2] == pytest.approx(
        seen_from(pose, other, np.zeros((1, 2)))[0], abs=1e-9
    )
