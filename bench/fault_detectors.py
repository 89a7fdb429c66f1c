"""The person detectors under faults: silence, not an empty array, where nothing can be seen."""

from __future__ import annotations

import copy
import math
import tempfile
from typing import Callable

import numpy as np
import rospy
from leg_models import make_leg_model
from safe_passage.msg import PersonArray
from safe_passage.replay.sources import SceneSource
from safe_passage.ros import conversions
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud2
from test_leg_detector import message as leg_scan
from test_person_detector import CAMERA, GROUND, POSITION_ERROR, SCENE_TIME
from tf2_msgs.msg import TFMessage

from bench.fault_subject import Input, Seen, Sent, Stated, Subject, of, silence
from bench.fault_transforms import NOWHERE

PERSONS = "persons"
UNKNOWN = frozenset({"velocity", "height"})  # of persons


class PersonDetectorSubject(Subject):
    """The aisle at one moment."""

    name = "person_detector"
    launch = "person_detector.launch"
    frames = frozenset({CAMERA})
    tick, pause = 0.1, 0.03
    without_number = UNKNOWN

    def __init__(self) -> None:
        self.outputs = {PERSONS: PersonArray}
        source = SceneSource()
        self._frame = source.frame(SCENE_TIME)
        self._truth = [(p.x, p.y) for p in source.scene.persons(SCENE_TIME)]
        header = conversions.to_header(rospy.Time(), CAMERA)
        self._cloud = conversions.to_cloud(header, self._frame.xyz, self._frame.bgr)
        held = self.healthy  # the ground is tracked without tf, too
        self.inputs = (
            Input("tf", "/tf", TFMessage, self._tf, 0.0, held, told=False),
            Input("cloud", "depth_registered/points", PointCloud2, self._at, 0.0, silence(PERSONS)),
        )

    def _tf(self, stamp: rospy.Time) -> TFMessage:
        base = conversions.to_header(stamp, GROUND)
        pose = self._frame.p_base_camera, self._frame.R_base_camera
        return TFMessage([conversions.to_transform(base, CAMERA, *pose)])

    def _at(self, stamp: rospy.Time) -> PointCloud2:
        cloud = copy.copy(self._cloud)
        cloud.header = conversions.to_header(stamp, CAMERA)
        return cloud

    def healthy(self, seen: Seen) -> str:
        arrays = of(PERSONS, seen)
        if not arrays:
            return "no persons"
        places = self._places(arrays[-1])
        missing = [one for one in self._truth if not _near(places, one, POSITION_ERROR)]
        return f"nobody at {missing[0]}" if missing else ""

    def _places(self, array: PersonArray) -> np.ndarray:
        """(N, 2) [m] on the ground."""
        places = [(p.position.x, p.position.y, p.position.z) for p in array.persons]
        frame = self._frame
        in_base = np.array(places).reshape(-1, 3) @ frame.R_base_camera.T + frame.p_base_camera
        return in_base[:, :2]

    def wrong(self, seen: Seen, sent: list[Sent]) -> str:
        """Somebody seen as nobody, or nobody as somebody."""
        del sent
        for array in of(PERSONS, seen):
            if len(array.persons) != len(self._truth):
                return f"{len(array.persons)} persons, not {len(self._truth)}"
        return ""


class DepthDetectorSubject(PersonDetectorSubject):
    """The same aisle as images of depth and colours."""

    name, node = "person_detector_depth", "person_detector"
    arguments = ("input:=depth",)
    pause = 0.02

    def __init__(self) -> None:
        super().__init__()
        tf, _ = self.inputs
        depth, bgr, size = self._frame.xyz[..., 2], self._frame.bgr, self._frame.bgr.shape[:2]
        lost = silence(PERSONS)
        kinds = (
            ("depth", "depth_registered/image_rect", Image,
             lambda header: conversions.to_depth_image(header, depth)),
            ("colours", "rgb/image_rect_color", Image,
             lambda header: conversions.to_image(header, bgr)),
            ("camera_info", "rgb/camera_info", CameraInfo,
             lambda header: conversions.to_camera_info(header, size, self._frame.intrinsics)),
        )  # fmt: skip

        def of_camera(make: Callable) -> Callable:
            return lambda stamp: make(conversions.to_header(stamp, CAMERA))

        self.inputs = (
            tf,
            *(
                Input(name, topic, kind, of_camera(make), 0.0, lost)
                for name, topic, kind, make in kinds
            ),
        )


class LegDetectorSubject(Subject):
    """Somebody's legs ahead."""

    name = "leg_detector"
    launch = "leg_detector.launch"
    frames = frozenset({"robot1/laser", NOWHERE})
    tick, pause = 0.1, 0.02
    without_number = UNKNOWN

    def __init__(self) -> None:
        self.outputs = {PERSONS: PersonArray}
        self._folder = tempfile.TemporaryDirectory()
        self.arguments = (f"model:={make_leg_model(self._folder.name)}",)
        self._scan = leg_scan(rospy.Time())
        # told in the scan's own frame, whatever that is: readers drop what tf does not know
        as_told = {"wrong frame": Stated(self.healthy, told=False)}
        lost = silence(PERSONS)
        self.inputs = (Input("scan", "scan", LaserScan, self._at, 0.0, lost, stated=as_told),)

    def _at(self, stamp: rospy.Time) -> LaserScan:
        scan = copy.deepcopy(self._scan)
        scan.header.stamp = stamp
        return scan

    def healthy(self, seen: Seen) -> str:
        return "" if of(PERSONS, seen) else "no persons"

    def wrong(self, seen: Seen, sent: list[Sent]) -> str:
        """The one person is not told, or another one."""
        del sent
        for array in of(PERSONS, seen):
            places = np.array([(p.position.x, p.position.y) for p in array.persons]).reshape(-1, 2)
            if len(places) != 1 or not _near(places, (1.5, 0.0), 0.4):
                return f"persons at {places.tolist()}"
        return ""


def _near(places: np.ndarray, one: tuple[float, float], gate: float) -> bool:
    return any(math.dist(place, one) < gate for place in places)
