"""Tracks, grid and cells as messages."""

import io
import math

import numpy as np
import pytest
from safe_passage.msg import TrackedObstacle, TrackedObstacleArray
from safe_passage.ros.tracker_conversions import hull, to_cells, to_occupancy, to_tracks
from sensor_msgs import point_cloud2
from std_msgs.msg import Header
from tracker_snapshots import (
    HEIGHTS,
    PARAMETERS,
    POST,
    WALL_X,
    make_snapshot,
    nobody,
    post_is_person,
    with_moving_post,
)

HEADER = Header(frame_id="base")


@pytest.fixture(scope="module")
def snapshot():
    return with_moving_post(make_snapshot(speed=1.0))


@pytest.fixture(scope="module")
def post_and_wall(snapshot):
    post, wall = sorted(
        to_tracks(snapshot, nobody(snapshot), HEADER, PARAMETERS).obstacles,
        key=lambda o: -o.position.x,
    )
    return post, wall


def test_a_track_is_told_with_place_velocity_and_sensors(post_and_wall):
    post, wall = post_and_wall
    assert (post.position.x, post.position.y) == pytest.approx(POST, abs=0.15)
    assert post.velocity.x > 0.4
    assert abs(post.velocity.y) < 0.1
    assert (post.moving, wall.moving) == (True, False)
    assert post.observed
    assert post.age == pytest.approx(0.9, abs=0.05)
    assert post.id != wall.id
    assert min(post.points) > 0
    assert wall.points[0] > 0
    assert wall.points[1] == 0


def test_what_nobody_knows_is_said_so(post_and_wall):
    post, wall = post_and_wall
    assert (post.min_height, post.max_height) == pytest.approx(HEIGHTS)
    assert math.isnan(wall.min_height)
    assert math.isnan(wall.max_height)
    assert post.classification == TrackedObstacle.UNKNOWN
    assert math.isnan(post.person_probability)


def test_who_was_seen_by_a_detector_is_a_person(snapshot):
    told = to_tracks(snapshot, post_is_person(snapshot), HEADER, PARAMETERS).obstacles
    post, wall = sorted(told, key=lambda o: -o.position.x)
    assert post.classification == TrackedObstacle.PERSON
    assert post.person_probability == pytest.approx(0.9)
    assert wall.classification == TrackedObstacle.UNKNOWN
    assert math.isnan(wall.person_probability)


def test_covariance_is_that_of_x_y_vx_vy(snapshot, post_and_wall):
    wanted = {tuple(P.ravel()) for P in snapshot.tracks.body_covariance}
    assert {tuple(o.covariance) for o in post_and_wall} <= wanted


def test_outline_holds_the_cells(post_and_wall):
    _, wall = post_and_wall
    corners = np.array([(p.x, p.y) for p in wall.footprint.points])
    half = 0.5 * PARAMETERS.resolution
    assert corners[:, 0].min() == pytest.approx(min(wall.cells_x) - half, abs=1e-5)
    assert corners[:, 1].max() == pytest.approx(max(wall.cells_y) + half, abs=1e-5)
    assert wall.cells_x == pytest.approx([WALL_X] * len(wall.cells_x), abs=0.1)


def test_a_silent_sensor_is_marked():
    snapshot = make_snapshot(alive=("laser",))
    array = to_tracks(snapshot, nobody(snapshot), HEADER, PARAMETERS)
    assert array.sensors == ["laser", "camera"]
    assert array.alive == [True, False]


def test_what_was_seen_too_seldom_is_not_told(snapshot):
    array = to_tracks(snapshot, nobody(snapshot), HEADER, PARAMETERS)
    assert len(array.obstacles) == snapshot.confirmed.sum()


def test_messages_survive_the_wire(snapshot):
    sent, received = (
        to_tracks(snapshot, nobody(snapshot), HEADER, PARAMETERS),
        TrackedObstacleArray(),
    )
    buffer = io.BytesIO()
    sent.serialize(buffer)
    received.deserialize(buffer.getvalue())
    assert [o.id for o in received.obstacles] == [o.id for o in sent.obstacles]
    assert received.obstacles[0].cells_y == pytest.approx(sent.obstacles[0].cells_y, abs=1e-5)


def test_hull_of_one_cell_is_the_cell():
    assert sorted(hull(np.array([[1.0, 2.0]]), 0.5)) == [
        [0.75, 1.75], [0.75, 2.25], [1.25, 1.75], [1.25, 2.25],
    ]  # fmt: skip
    assert hull(np.empty((0, 2)), 0.5) == []


def test_only_obstacles_are_known_in_the_grid(snapshot):
    message = to_occupancy(snapshot.grid, HEADER)
    cells = np.array(message.data).reshape(message.info.height, message.info.width)
    assert set(message.data) == {-1, 100}
    corner = message.info.origin.position
    column = int((POST[0] - corner.x) / message.info.resolution)
    row = int((POST[1] - corner.y) / message.info.resolution)
    assert cells[row, column] == 100
    assert (cells == 100).sum() == len(snapshot.grid.cell)


def test_cells_name_their_track(snapshot, post_and_wall):
    post, wall = post_and_wall
    cloud = to_cells(snapshot, HEADER)
    names = [field.name for field in cloud.fields]
    cells = [dict(zip(names, point)) for point in point_cloud2.read_points(cloud)]
    assert len(cells) == len(snapshot.grid.cell)
    of_post = [c for c in cells if c["id"] == post.id]
    assert len(of_post) >= 4
    assert all(math.hypot(c["x"] - POST[0], c["y"] - POST[1]) < 0.5 for c in of_post)
    assert all(c["moving"] == 1.0 for c in of_post)
    assert max(c["z"] for c in of_post) == pytest.approx(HEIGHTS[1])
    assert all(c["density"] > 0.0 for c in cells)
    of_wall = [c for c in cells if c["id"] == wall.id]
    assert all(c["moving"] == 0.0 for c in of_wall)
    assert all(c["z"] == 0.0 for c in of_wall)
