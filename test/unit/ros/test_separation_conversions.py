"""Tracks, paths and states between messages and the core."""

import math

import numpy as np
import pytest
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion, Twist, Vector3
from nav_msgs.msg import Odometry, Path
from safe_passage.msg import SeparationState, TrackedObstacle, TrackedObstacleArray
from safe_passage.ros.diagnostics import Outcome
from safe_passage.ros.sensor_conversions import UnusableMessageError
from safe_passage.ros.separation_conversions import (
    planar,
    silent_sensors,
    to_obstacles,
    to_path,
    to_state,
    to_twist,
    to_velocity,
)
from safe_passage.separation import Assessment, Level, Reason
from std_msgs.msg import Header


def tracked(**changes) -> TrackedObstacleArray:
    one = TrackedObstacle(
        id=7,
        moving=True,
        classification=TrackedObstacle.PERSON,
        position=Point(1.0, 2.0, 0.0),
        velocity=Vector3(0.5, -0.5, 0.0),
        covariance=np.arange(16.0),
        cells_x=[0.9, 1.1],
        cells_y=[2.0, 2.0],
    )
    for name, value in changes.items():
        setattr(one, name, value)
    return TrackedObstacleArray(resolution=0.2, obstacles=[one])


def test_obstacles_are_what_the_message_says():
    found = to_obstacles(tracked())
    assert (found.id.tolist(), found.moving.tolist(), found.person.tolist()) == (
        [7],
        [True],
        [True],
    )
    assert found.position.tolist() == [[1.0, 2.0]] and found.velocity.tolist() == [[0.5, -0.5]]
    assert found.covariance[0].tolist() == np.arange(16.0).reshape(4, 4).tolist()
    assert found.cells[0].tolist() == [[0.9, 2.0], [1.1, 2.0]]
    assert found.resolution == pytest.approx(0.2)
    assert len(to_obstacles(TrackedObstacleArray(resolution=0.1))) == 0


def test_an_obstacle_without_cells_is_at_its_position():
    assert to_obstacles(tracked(cells_x=[], cells_y=[])).cells[0].tolist() == [[1.0, 2.0]]


@pytest.mark.parametrize(
    "changes, outcome",
    [
        ({"position": Point(math.nan, 0.0, 0.0)}, Outcome.NOT_FINITE),
        ({"velocity": Vector3(0.0, math.inf, 0.0)}, Outcome.NOT_FINITE),
        ({"covariance": [math.nan] * 16}, Outcome.NOT_FINITE),
        ({"cells_x": [0.0, math.nan]}, Outcome.NOT_FINITE),
        ({"cells_x": [0.0]}, Outcome.BAD_FIELDS),
    ],
)
def test_what_cannot_be_used_is_refused(changes, outcome):
    with pytest.raises(UnusableMessageError) as raised:
        to_obstacles(tracked(**changes))
    assert raised.value.outcome is outcome


@pytest.mark.parametrize("resolution", [0.0, -1.0, math.nan, math.inf])
def test_cells_have_a_size(resolution):
    with pytest.raises(UnusableMessageError):
        to_obstacles(TrackedObstacleArray(resolution=resolution))


def test_sensors_that_should_be_alive():
    array = TrackedObstacleArray(sensors=["a", "b", "c"], alive=[True, False, False])
    assert silent_sensors(array, ("c",)) == ["b"]


def test_a_sensor_of_which_nobody_tells_whether_it_is_alive_is_refused():
    with pytest.raises(UnusableMessageError):
        silent_sensors(TrackedObstacleArray(sensors=["a", "b"], alive=[True]), ())


@pytest.mark.parametrize("part", [math.nan, math.inf, 101.0, -1e308])
def test_what_no_robot_drives_is_no_velocity(part):
    assert all(map(math.isnan, planar(Twist(linear=Vector3(0.0, part, 0.0)))))


def path_of(*poses):
    """Of (x [m], yaw [rad])."""
    turned = [Quaternion(0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw)) for _, yaw in poses]
    placed = [Pose(Point(x, 0.0, 5.0), q) for (x, _), q in zip(poses, turned)]
    return Path(poses=[PoseStamped(pose=pose) for pose in placed])


def test_a_path_is_placed_by_its_frame():
    path = path_of((0.0, 0.5), (1.0, -0.5))
    found = to_path(path, (1.0, 2.0, math.pi / 2), False)
    assert found == pytest.approx(np.array([[1.0, 2.0], [1.0, 3.0]]))
    assert to_path(Path(), (0.0, 0.0, 0.0), False).shape == (0, 2)


def test_its_orientations_are_headings_where_the_planner_means_them_so():
    path = path_of((0.0, 0.5), (1.0, -0.5))
    found = to_path(path, (1.0, 2.0, math.pi / 2), True)
    right = math.pi / 2
    assert found == pytest.approx(np.array([[1.0, 2.0, right + 0.5], [1.0, 3.0, right - 0.5]]))
    assert to_path(Path(), (0.0, 0.0, 0.0), True).shape == (0, 3)


@pytest.mark.parametrize("q", [Quaternion(), Quaternion(0.0, 0.0, math.nan, 1.0)])
def test_a_path_without_orientations_is_one_of_places(q):
    path = path_of((0.0, 0.0), (1.0, 0.0))
    path.poses[1].pose.orientation = q
    assert to_path(path, (0.0, 0.0, 0.0), True).shape == (2, 2)


def test_twists_there_and_back():
    assert planar(to_twist((0.5, -0.1, 0.3))) == (0.5, -0.1, 0.3)
    assert all(map(math.isnan, planar(Twist(angular=Vector3(math.nan, 0.0, 0.0)))))
    odometry = Odometry()
    odometry.twist.twist = to_twist((0.5, 0.0, 0.1))
    assert to_velocity(odometry) == (0.5, 0.0, 0.1)
    odometry.twist.twist.angular.z = math.inf
    with pytest.raises(UnusableMessageError):
        to_velocity(odometry)


def test_levels_and_reasons_are_those_of_the_message():
    for member in (*Level, *Reason):
        assert getattr(SeparationState, member.name) == member.value


def test_a_state_says_why():
    state = to_state(Assessment(1.0, Level.STOP, Reason.NO_TF, 0.0), Header(), "odom -> base")
    assert (state.level, state.reason, state.text) == (2, 9, "NO_TF: odom -> base")
    assert math.isnan(state.present_distance) and state.scale == 0.0
