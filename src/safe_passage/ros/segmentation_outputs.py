"""What the segmentation publishes: planes first, all of a result at once, nothing of a failure."""

from __future__ import annotations

import textwrap

import cv2
import numpy as np
import rospy
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import Image, PointCloud2
from std_msgs.msg import Header
from visualization_msgs.msg import MarkerArray

from safe_passage.msg import ScanPlanes, ScanSegmentation
from safe_passage.ros.conversions import to_cloud, to_image
from safe_passage.ros.segmentation_conversions import (
    to_failure,
    to_occupancy,
    to_planes,
    to_result,
)
from safe_passage.ros.segmentation_markers import (
    no_markers,
    plane_markers,
    result_markers,
    segment_markers,
    wall_markers,
)
from safe_passage.scan_segmentation import Planes, Segmentation
from safe_passage.scan_segmentation.picture import from_above
from safe_passage.scan_segmentation.visualisation import pictured
from safe_passage.scan_segmentation.writing import grey_values

WIDTH = 28  # letters in a line of a refusal's picture


class SegmentationOutputs:
    """All topics. They are latched: who comes later sees what holds now."""

    def __init__(self) -> None:
        self._result = _latched("~result", ScanSegmentation)
        self._planes = _latched("~planes", ScanPlanes)
        self._map = _latched("~traversability", OccupancyGrid)
        self._image = _latched("~traversability_image", Image)
        self._markers = _latched("~markers", MarkerArray)
        self._walls = _latched("~walls", MarkerArray)
        self._cloud = _latched("~cloud", PointCloud2)
        # supporting structures, made only for subscribers
        self._plane_markers = rospy.Publisher("~plane_markers", MarkerArray, queue_size=2)
        self._segments = rospy.Publisher("~segments", MarkerArray, queue_size=2)
        self._basic = rospy.Publisher("~basic_map", OccupancyGrid, queue_size=2)

    def planes(self, header: Header, planes: Planes) -> None:
        """What is known before the ground is."""
        self._planes.publish(to_planes(header, planes))
        if self._plane_markers.get_num_connections():
            self._plane_markers.publish(plane_markers(header, planes))
        if self._segments.get_num_connections():
            self._segments.publish(segment_markers(header, planes))

    def result(
        self, header: Header, found: Segmentation, robot: str, text: str
    ) -> ScanSegmentation:
        """All of it."""
        shapes = pictured(found)
        message = to_result(header, found, robot, text)
        self._planes.publish(ScanPlanes(header, message.planes))  # now with what is ground
        self._map.publish(message.map)
        self._image.publish(to_image(header, from_above(found)))
        self._cloud.publish(_grey_cloud(header, found))
        self._markers.publish(result_markers(header, found, shapes))
        self._walls.publish(wall_markers(header, shapes))
        if self._basic.get_num_connections():
            self._basic.publish(to_occupancy(header, found, found.basic))
        self._result.publish(message)
        return message

    def failure(self, header: Header, reason: int, text: str, robot: str) -> ScanSegmentation:
        """Nothing is drawn, also nothing of before, and all that is said is why."""
        message = to_failure(header, reason, text, robot)
        for publisher in (self._markers, self._walls, self._plane_markers, self._segments):
            publisher.publish(no_markers(header))
        for publisher in (self._map, self._basic):
            publisher.publish(message.map)
        self._planes.publish(ScanPlanes(header=header))
        self._cloud.publish(to_cloud(header, np.empty((1, 0, 3)), np.empty((1, 0, 3), np.uint8)))
        self._image.publish(to_image(header, _words(text)))
        self._result.publish(message)
        return message


def _latched(topic: str, kind: type) -> rospy.Publisher:
    return rospy.Publisher(topic, kind, queue_size=2, latch=True)


def _grey_cloud(header: Header, found: Segmentation) -> PointCloud2:
    """The scan as it was used, by its remission."""
    scan = found.planes.scan
    return to_cloud(header, scan.points[scan.valid][None], grey_values(found)[None])


def _words(text: str) -> np.ndarray:
    """(H, W, 3) picture of a refusal."""
    lines = ["NO RESULT", *textwrap.wrap(text, WIDTH)]
    image = np.full((40 + 30 * len(lines), 20 + 12 * WIDTH, 3), 255, np.uint8)
    for i, line in enumerate(lines):
        at = (15, 40 + 30 * i)
        cv2.putText(image, line, at, cv2.FONT_HERSHEY_SIMPLEX, 0.6, (40, 40, 200), 2, cv2.LINE_AA)
    return image
