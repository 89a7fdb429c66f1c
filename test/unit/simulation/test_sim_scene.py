"""What rays and pictures of a scene say, against ray casting by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from safe_passage.core.geometry import matrix
from safe_passage.simulation import raycast
from safe_passage.simulation.people_assets import load_person
from safe_passage.simulation.robots import CameraModel
from safe_passage.simulation.scene import Scene
from safe_passage.simulation.walkers import PersonState
from sim_hall import BOXES, distances_by_hand, is_inside, make_cart, make_hall

WORLD = make_hall(boxes=BOXES)
STANDING = (0.0, 0.0)


@pytest.fixture(scope="module")
def scene():
    made = Scene(WORLD, make_cart(), [load_person("tall_man"), load_person("vest_woman")])
    made.place_people([None, None])
    made.settle()
    yield made
    made.close()


@given(
    st.floats(-4.5, 4.5), st.floats(-3.5, 3.5), st.floats(0.05, 2.0), st.floats(-math.pi, math.pi)
)
def test_rays_meet_blocks_where_hand_casting_says(scene, x, y, z, first):
    origin = np.array([x, y, z])
    assume(not is_inside(WORLD.blocks, origin))
    scene.place_people([None, None])
    scene.settle()
    angles = first + np.linspace(-2.3, 2.3, 61)
    level = np.stack([np.cos(angles), np.sin(angles), np.zeros(61)], axis=1)
    down = np.stack([0.8 * np.cos(angles), 0.8 * np.sin(angles), np.full(61, -0.6)], axis=1)
    for rays in (level, down):
        by_hand = distances_by_hand(WORLD.blocks, origin, rays)
        by_hand = np.minimum(by_hand, raycast.plane_z(origin, rays, 0.0))
        hits = scene.cast(origin, rays, 30.0, low=False)
        agree = np.isclose(hits.distances, by_hand, atol=1e-5)
        assert agree.mean() > 0.96  # a ray along an edge may go either way
        assert (hits.persons == -1).all()


def test_low_rays_meet_the_same_below_the_limit(scene):
    angles = np.linspace(-math.pi, math.pi, 721)
    rays = np.stack([np.cos(angles), np.sin(angles), np.zeros(721)], axis=1)
    origin = np.array([0.0, 0.0, 0.2])
    low = scene.cast(origin, rays, 30.0, low=True).distances
    assert low == pytest.approx(scene.cast(origin, rays, 30.0, low=False).distances)


def test_nothing_is_met_beyond_the_reach(scene):
    rays = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    hits = scene.cast(np.array([0.0, 0.0, 2.5]), rays, 4.5, low=False)
    assert np.isinf(hits.distances[0])  # the wall is 5 m away
    assert hits.distances[1] == pytest.approx(4.0)


@pytest.mark.parametrize("bearing", [0.3, 1.9, -2.6])
def test_rays_at_a_person_meet_it_and_say_who(scene, bearing):
    where = 1.5 * np.array([math.cos(bearing), math.sin(bearing)])
    state = PersonState(where[0], where[1], 0.0, STANDING, 0.0)
    scene.place_people([None, state])
    scene.settle()
    ray = np.array([[math.cos(bearing), math.sin(bearing), 0.0]])
    hits = scene.cast(np.array([0.0, 0.0, 1.2]), ray, 30.0, low=False)
    assert hits.persons[0] == 1
    assert 0.04 < 1.5 - hits.distances[0] < 0.35  # half a trunk


def test_both_legs_of_a_standing_person_are_met_near_the_floor(scene):
    scene.place_people([PersonState(1.5, 0.0, 0.0, STANDING, 0.0), None])
    scene.settle()
    angles = np.linspace(-0.3, 0.3, 241)
    rays = np.stack([np.cos(angles), np.sin(angles), np.zeros(241)], axis=1)
    met = scene.cast(np.array([0.0, 0.0, 0.2]), rays, 30.0, low=True).persons == 0
    assert np.count_nonzero(np.diff(met.astype(int)) == 1) == 2


def test_a_person_that_is_not_there_is_not_met(scene):
    scene.place_people([PersonState(1.5, 0.0, 0.0, STANDING, 0.0), None])
    scene.place_people([None, None])
    scene.settle()
    hits = scene.cast(np.array([0.0, 0.0, 1.2]), np.array([[1.0, 0.0, 0.0]]), 30.0, low=False)
    assert hits.persons[0] == -1 and hits.distances[0] == pytest.approx(5.0)


@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0), (-1.0, 0.5, 0.6), (1.0, -0.5, -2.4)])
@pytest.mark.parametrize(
    "camera",
    [
        CameraModel(z=1.0, pitch=0.35, width=160, height=120, focal=131.25),
        CameraModel(x=0.2, y=-0.1, z=1.5, yaw=0.5, pitch=0.7, width=161, height=91, focal=90.0),
    ],
    ids=["even", "odd"],
)
def test_depth_is_that_of_hand_casting_to_5_mm(pose, camera):
    """Half a pixel would be some 40 mm on the floor, and as much on a wall seen aslant."""
    scene = Scene(WORLD, make_cart(cameras=[vars(camera)]), [])
    scene.place_robot(pose)
    scene.settle()
    _, depth = scene.render(camera)
    scene.close()
    T = matrix(pose) @ camera.pose_in_base()
    fx, fy, cx, cy = camera.intrinsics
    v, u = np.mgrid[: camera.height, : camera.width]
    optical = np.stack([(u - cx) / fx, (v - cy) / fy, np.ones_like(u)], axis=-1).reshape(-1, 3)
    lengths = np.linalg.norm(optical, axis=1)
    rays = optical / lengths[:, None] @ T[:3, :3].T
    by_hand = distances_by_hand(WORLD.blocks, T[:3, 3], rays)
    by_hand = np.minimum(by_hand, raycast.plane_z(T[:3, 3], rays, 0.0)) / lengths
    error = np.abs(depth.ravel() - by_hand)
    assert (error < 0.005).mean() > 0.985  # all but the pixels on edges
    assert np.median(error) < 0.001


def test_the_optical_frame_looks_ahead_and_down():
    camera = CameraModel(x=0.1, z=1.5, pitch=0.5)
    T = matrix((2.0, 1.0, math.pi / 2)) @ camera.pose_in_base()
    assert T[:3, 3] == pytest.approx([2.0, 1.1, 1.5])
    assert T[:3, 2] == pytest.approx([0.0, math.cos(0.5), -math.sin(0.5)])  # z: along the view
    assert T[:3, 0] == pytest.approx([1.0, 0.0, 0.0])  # x: to the right


def test_a_person_before_the_camera_is_drawn_nearer_than_the_wall(scene):
    camera = scene.robot.cameras[0]
    scene.place_robot((0.0, 0.0, 0.0))
    scene.place_people([PersonState(2.0, 0.0, 0.0, STANDING, 0.0), None])
    scene.settle()
    bgr, depth = scene.render(camera)
    trunk = depth[5:22, 75:85]  # 1.2 to 0.9 m over the floor
    assert trunk == pytest.approx(1.9, abs=0.25)
    scene.place_people([None, None])
    scene.settle()
    empty, _ = scene.render(camera)
    assert (bgr != empty).any(axis=-1)[20:80, 72:88].mean() > 0.5
