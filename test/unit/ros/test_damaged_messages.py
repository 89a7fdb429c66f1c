"""Whatever comes from the network: a result, or a clear error of ours."""

import math

import numpy as np
from geometry_msgs.msg import Point, Point32, Pose, PoseStamped, Quaternion, Twist, Vector3
from hypothesis import given, settings
from hypothesis import strategies as st
from nav_msgs.msg import Odometry, Path
from safe_passage.core.errors import SafePassageError
from safe_passage.costmap.parameters import SourceParameters
from safe_passage.msg import RobotConfiguration, TrackedObstacle, TrackedObstacleArray
from safe_passage.robot_model import JointHistory
from safe_passage.ros.costmap_conversions import sensor_points
from safe_passage.ros.depth_conversions import from_camera_info, from_depth_image
from safe_passage.ros.leg_conversions import from_message
from safe_passage.ros.scan_conversions import from_robot, from_scan_cloud
from safe_passage.ros.sensor_conversions import UnusableMessageError, sampled_xyz, scan_beams
from safe_passage.ros.separation_conversions import (
    silent_sensors,
    to_obstacles,
    to_path,
    to_velocity,
)
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud, PointCloud2, PointField

UNUSABLE = (SafePassageError, UnusableMessageError)
FEW = settings(deadline=None, max_examples=120)
numbers = st.integers(0, 2**32 - 1)
small = st.integers(0, 40)
names = st.sampled_from(["x", "y", "z", "intensity", "beta", "rgb", ""])
fields = st.builds(PointField, name=names, offset=small, datatype=st.integers(0, 9), count=small)
XYZ = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate("xyz")]
clouds = st.builds(
    PointCloud2,
    height=st.one_of(small, numbers),
    width=st.one_of(small, numbers),
    fields=st.one_of(st.just(XYZ), st.lists(fields, max_size=5)),
    is_bigendian=st.booleans(),
    point_step=st.one_of(small, numbers),
    row_step=st.one_of(small, numbers),
    data=st.binary(max_size=400),
)


SOURCE = SourceParameters(name="source")


def costmap_points(message):
    return sensor_points(message, SOURCE)


@FEW
@given(cloud=clouds)
def test_clouds_from_the_network(cloud):
    for read in (lambda one: sampled_xyz(one, 5.0, 0.06), from_scan_cloud, costmap_points):
        try:
            read(cloud)
        except UNUSABLE as error:
            assert str(error)


floats = st.floats(width=32)


@FEW
@given(
    scan=st.builds(
        LaserScan,
        angle_min=floats,
        angle_max=floats,
        angle_increment=floats,
        range_min=floats,
        range_max=floats,
        ranges=st.lists(floats, max_size=30),
    )
)
def test_scans_from_the_network(scan):
    try:
        ranges = np.asarray(scan_beams(scan).ranges)
    except UNUSABLE as error:
        assert str(error)
    else:
        assert len(ranges) == len(scan.ranges)
    for read in (from_message, costmap_points):
        try:
            read(scan)
        except UNUSABLE as error:
            assert str(error)


@FEW
@given(
    image=st.builds(
        Image,
        height=st.one_of(small, numbers),
        width=st.one_of(small, numbers),
        encoding=st.sampled_from(["16UC1", "32FC1", "rgb8", "", "mono16", "???"]),
        is_bigendian=st.integers(0, 1),
        step=st.one_of(small, numbers),
        data=st.binary(max_size=400),
    )
)
def test_depth_images_from_the_network(image):
    try:
        from_depth_image(image)
    except UNUSABLE as error:
        assert str(error)


@FEW
@given(
    info=st.builds(
        CameraInfo,
        height=numbers,
        width=numbers,
        K=st.lists(floats, min_size=9, max_size=9),
        P=st.lists(floats, min_size=12, max_size=12),
    )
)
def test_camera_infos_from_the_network(info):
    try:
        from_camera_info(info)
    except UNUSABLE as error:
        assert str(error)


doubles = st.floats()
vectors = st.builds(Vector3, doubles, doubles, doubles)
points = st.builds(Point, doubles, doubles, doubles)
cells = st.lists(floats, max_size=3)


@FEW
@given(cloud=st.builds(PointCloud, points=st.lists(st.builds(Point32, floats, floats, floats))))
def test_old_clouds_from_the_network(cloud):
    try:
        assert len(costmap_points(cloud)) == len(cloud.points)
    except UNUSABLE as error:
        assert str(error)


@FEW
@given(
    array=st.builds(
        TrackedObstacleArray,
        sensors=st.lists(st.text(max_size=3), max_size=2),
        alive=st.lists(st.booleans(), max_size=2),
        resolution=floats,
        obstacles=st.lists(
            st.builds(
                TrackedObstacle,
                id=numbers,
                position=points,
                velocity=vectors,
                covariance=st.lists(doubles, min_size=16, max_size=16),
                cells_x=cells,
                cells_y=cells,
            ),
            max_size=2,
        ),
    )
)
def test_tracks_from_the_network(array):
    for read in (to_obstacles, lambda one: silent_sensors(one, ())):
        try:
            read(array)
        except UNUSABLE as error:
            assert str(error)


@FEW
@given(
    twist=st.builds(Twist, vectors, vectors),
    poses=st.lists(
        st.builds(Pose, points, st.builds(Quaternion, doubles, doubles, doubles, doubles)),
        max_size=3,
    ),
    oriented=st.booleans(),
)
def test_paths_and_odometry_from_the_network(twist, poses, oriented):
    path = Path(poses=[PoseStamped(pose=pose) for pose in poses])
    with np.errstate(invalid="ignore", over="ignore"):
        assert len(to_path(path, (1.0, 2.0, 0.5), oriented)) == len(poses)
    odometry = Odometry()
    odometry.twist.twist = twist
    try:
        assert all(map(math.isfinite, to_velocity(odometry)))
    except UNUSABLE as error:
        assert str(error)


@FEW
@given(
    names=st.lists(st.sampled_from("abc"), max_size=4),
    positions=st.lists(doubles, max_size=4),
    stamp=st.floats(0.0, 2.0**32),
)
def test_joint_states_from_the_network(names, positions, stamp):
    joints = JointHistory()
    try:
        joints.add(stamp, names, positions)
        joints.at(stamp, names)
    except UNUSABLE as error:
        assert str(error)


@FEW
@given(values=st.lists(doubles, min_size=6, max_size=6))
def test_robots_from_the_network(values):
    names = ("length", "width", "height", "max_slope", "max_obstacle", "margin")
    try:
        from_robot(RobotConfiguration(**dict(zip(names, values))))
    except UNUSABLE as error:
        assert str(error)
