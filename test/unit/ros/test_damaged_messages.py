"""Whatever comes from the network: a result, or a clear error of ours."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from safe_passage.core.errors import SafePassageError
from safe_passage.ros.depth_conversions import from_camera_info, from_depth_image
from safe_passage.ros.scan_conversions import from_scan_cloud
from safe_passage.ros.sensor_conversions import UnusableMessageError, sampled_xyz, scan_beams
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud2, PointField

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


@FEW
@given(cloud=clouds)
def test_clouds_from_the_network(cloud):
    for read in (lambda one: sampled_xyz(one, 5.0, 0.06), from_scan_cloud):
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
