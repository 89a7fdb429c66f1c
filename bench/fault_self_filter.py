"""The depth self-filter under faults: no image rather than one with the arm in it."""

from __future__ import annotations

import numpy as np
import rospy
from geometry_msgs.msg import TransformStamped
from safe_passage.ros.conversions import to_camera_info, to_depth_image
from safe_passage.ros.depth_conversions import from_depth_image
from sensor_msgs.msg import CameraInfo, Image, JointState
from std_msgs.msg import Header
from test_depth_self_filter import ARM, BAR, CAMERA, SIZE, URDF, WALL, depth
from tf2_msgs.msg import TFMessage

from bench.fault_subject import Input, Seen, Sent, Stated, Subject, of, silence

FILTERED, INFO = "depth_filtered/image_rect", "depth_filtered/camera_info"
TOLERANCE = 0.1  # [s] that an image waits for tf and joints
CORNER = np.s_[:20, :20]  # pixels of the wall


class DepthSelfFilterSubject(Subject):
    """A bar before a wall."""

    name = "depth_self_filter"
    launch = "depth_self_filter.launch"
    frames = frozenset({CAMERA})

    def __init__(self) -> None:
        self.outputs = {FILTERED: Image, INFO: CameraInfo}
        lost, well = silence(FILTERED), Stated(self.healthy, told=False)
        nothing_seen = Stated(lambda _: "", told=False)  # an image of NaN hides nothing
        any_frame = {"wrong frame": well}  # of joints, which have none
        any_time = {name: well for name in ("silent", "stale", "future", "wrong frame")}
        # the last that could be used counts
        any_time.update({name: Stated(self.healthy, told=True) for name in ("NaN", "empty")})
        kinds = (
            ("tf", "/tf", TFMessage, _tf, {}),
            ("joints", "joint_states", JointState, _joints, any_frame),
            ("camera_info", "depth/camera_info", CameraInfo, _info, any_time),
            ("image", "depth/image_rect", Image, _image, {"NaN": nothing_seen}),
        )
        self.inputs = tuple(
            Input(name, topic, kind, make, TOLERANCE, lost, stated=stated)
            for name, topic, kind, make, stated in kinds
        )

    def prepare(self) -> None:
        rospy.set_param("robot_description", URDF)

    def healthy(self, seen: Seen) -> str:
        images = of(FILTERED, seen)
        if not images or not of(INFO, seen):
            return "no image or no camera_info"
        wall = from_depth_image(images[-1])[CORNER]
        return "" if np.allclose(wall, WALL, atol=0.01) else "the wall is not in the image"

    def wrong(self, seen: Seen, sent: list[Sent]) -> str:
        """The arm is in an image."""
        del sent
        for image in of(FILTERED, seen):
            if (from_depth_image(image)[BAR] < 1.1 * ARM).any():  # NaN compares false
                return "the arm is in an image"
        return ""


def _tf(stamp: rospy.Time) -> TFMessage:
    place = TransformStamped(header=Header(frame_id=CAMERA, stamp=stamp), child_frame_id="post")
    place.transform.translation.z, place.transform.rotation.w = ARM, 1.0
    return TFMessage([place])


def _joints(stamp: rospy.Time) -> JointState:
    header = Header(frame_id=CAMERA, stamp=stamp)
    return JointState(header=header, name=["turn"], position=[0.0])


def _info(stamp: rospy.Time) -> CameraInfo:
    return to_camera_info(Header(frame_id=CAMERA, stamp=stamp), SIZE, (130.0, 130.0, 79.5, 59.5))


def _image(stamp: rospy.Time) -> Image:
    return to_depth_image(Header(frame_id=CAMERA, stamp=stamp), depth())
