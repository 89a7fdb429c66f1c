#!/usr/bin/env python3
"""Node depth_self_filter: images without the robot; silence where it is not known, and why."""

import sys
import threading
import unittest

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import TransformStamped
from node_testing import Diagnostics, output_of_refusal, wait_until
from rosgraph_msgs.msg import Clock
from safe_passage.ros.conversions import to_camera_info, to_depth_image
from safe_passage.ros.depth_conversions import from_depth_image
from sensor_msgs.msg import CameraInfo, Image, JointState, PointCloud2
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

TICK = 0.05  # s of simulated time
CAMERA = "robot1/camera_depth_optical_frame"
IMAGE, INFO, JOINTS = (
    "/robot1/" + name for name in ("depth/image_rect", "depth/camera_info", "joint_states")
)
ERROR = 2  # diagnostics
BURST = 20  # images at once
SIZE = (120, 160)  # px
WALL, ARM = 2.0, 1.0  # m
URDF = """<robot name="bar">
  <link name="post"/>
  <link name="bar">
    <visual><origin xyz="0.25 0 0"/><geometry><box size="0.5 0.06 0.06"/></geometry></visual>
  </link>
  <joint name="turn" type="continuous">
    <parent link="post"/><child link="bar"/><axis xyz="0 0 1"/>
  </joint>
</robot>"""
BAR = np.s_[58:62, 85:140]  # pixels of the bar, a metre away
HAND = np.s_[55:65, 100:110]  # of a hand before it, half a metre away


def depth(hand=False):
    """The bar before a wall."""
    image = np.full(SIZE, WALL, np.float32)
    image[BAR] = ARM - 0.03
    if hand:
        image[HAND] = 0.5
    return image


class DepthSelfFilterTest(unittest.TestCase):
    now = 1000.0  # s, simulated

    @classmethod
    def setUpClass(cls):
        cls.news = threading.Condition()
        cls.images, cls.clouds, cls.infos = {}, {}, {}
        cls.diagnostics = Diagnostics("robot1/depth_self_filter", cls.news)
        cls.clock_pub = rospy.Publisher("/clock", Clock, queue_size=10)
        cls.tf_pub = rospy.Publisher("/tf", TFMessage, queue_size=10)
        cls.image_pub = rospy.Publisher("depth/image_rect", Image, queue_size=BURST)
        cls.info_pub = rospy.Publisher("depth/camera_info", CameraInfo, queue_size=10)
        cls.joints_pub = rospy.Publisher("joint_states", JointState, queue_size=10)
        rospy.Subscriber("depth_filtered/image_rect", Image, cls.note, cls.images)
        rospy.Subscriber("depth_filtered/points", PointCloud2, cls.note, cls.clouds)
        rospy.Subscriber("depth_filtered/camera_info", CameraInfo, cls.note, cls.infos)

    @classmethod
    def note(cls, message, kept):
        with cls.news:
            kept[message.header.stamp] = message
            cls.news.notify_all()

    def tick(self, *without, image=None, age=0.0, angle=0.0, frame=CAMERA):
        """The world goes on by a step, `without` some of its messages; returns the image's."""
        type(self).now += TICK
        stamp = rospy.Time.from_sec(self.now)
        self.clock_pub.publish(stamp)
        if "tf" not in without:
            place = TransformStamped(child_frame_id="post")
            place.header.frame_id, place.header.stamp = CAMERA, stamp
            place.transform.translation.z, place.transform.rotation.w = ARM, 1.0
            self.tf_pub.publish([place])
        header = Header(frame_id=frame, stamp=stamp)
        if "joints" not in without:
            self.joints_pub.publish(JointState(header=header, name=["turn"], position=[angle]))
        if "info" not in without:
            self.info_pub.publish(to_camera_info(header, SIZE, (130.0, 130.0, 79.5, 59.5)))
        header = Header(frame_id=frame, stamp=stamp - rospy.Duration.from_sec(age))
        self.image_pub.publish(to_depth_image(header, depth()) if image is None else image(header))
        return header.stamp

    def see(self, image=None):
        """The first answer to a good image."""
        sent = []
        wait_until(
            self.news,
            lambda: any(stamp in self.images for stamp in sent),
            lambda: f"an image; {self.diagnostics}",
            lambda: sent.append(self.tick(image=image)),
        )
        return next(self.images[stamp] for stamp in sent if stamp in self.images)

    def assert_silent(self, reason, *without, **changes):
        """Images are counted under `reason` and not passed on; a good one is, afterwards."""
        key = f"{IMAGE} {reason}"
        before, sent = self.diagnostics.count(key), []
        wait_until(
            self.news,
            lambda: self.diagnostics.count(key) > before,
            lambda: f"{key}; {self.diagnostics}",
            lambda: sent.append(self.tick(*without, **changes)),
        )
        late = sent[5:]  # the first ones may have had what came before
        self.assertFalse([stamp for stamp in late if stamp in self.images], reason)
        self.see()

    def test_1_says_what_it_waits_for(self):
        wait_until(
            self.news,
            lambda: f"waiting for: {JOINTS}" in self.diagnostics.message(),
            lambda: f"'waiting for'; {self.diagnostics}",
            lambda: self.clock_pub.publish(rospy.Time.from_sec(self.now)),
        )
        for topic in (IMAGE, INFO):
            self.assertIn(f"waiting for: {topic}", self.diagnostics.message())
        self.assertEqual(self.diagnostics.level(), ERROR)

    def test_2_without_a_model_nothing_passes_and_then_the_robot_is_gone(self):
        key = f"{IMAGE} NO_MODEL"
        wait_until(
            self.news,
            lambda: self.diagnostics.count(key) > 0,
            lambda: f"{key}; {self.diagnostics}",
            self.tick,
        )
        self.assertEqual(self.images, {})
        rospy.set_param("robot_description", URDF)
        answer = self.see()
        image = from_depth_image(answer)
        self.assertTrue(np.isnan(image[BAR]).all())
        self.assertEqual(np.nanmin(image), WALL)
        self.assertEqual((answer.header.frame_id, answer.encoding), (CAMERA, "32FC1"))

    def test_3_cloud_and_camera_info_come_with_it(self):
        stamps = set()

        def step():
            stamps.add(self.see().header.stamp)

        wait_until(
            self.news, lambda: stamps & set(self.clouds) & set(self.infos), "cloud and info", step
        )
        stamp = next(iter(stamps & set(self.clouds)))
        self.assertEqual((self.clouds[stamp].height, self.clouds[stamp].width), SIZE)

    def test_4_millimetres_and_a_hand_before_the_arm(self):
        def millimetres(header):
            rows = (1000 * depth(hand=True)).astype("<u2")
            return Image(header, *SIZE, "16UC1", 0, 2 * SIZE[1], rows.tobytes())

        image = from_depth_image(self.see(millimetres))
        self.assertEqual(image.dtype, np.uint16)
        self.assertTrue((image[HAND] == 500).all())
        self.assertTrue((image[58:62, 115:140] == 0).all())

    def test_5_what_is_missing_stops_the_images(self):
        self.see()
        self.assert_silent("NO_JOINTS", "joints")
        self.assert_silent("NO_TF", "tf")

    def test_6_bad_images(self):
        self.see()
        self.assert_silent("BAD_FIELDS", image=lambda h: Image(h, 2, 2, "rgb8", 0, 6, b"x" * 12))
        self.assert_silent("EMPTY", image=lambda h: Image(h, 0, 0, "32FC1", 0, 0, b""))
        self.assert_silent("BAD_FIELDS", frame="")
        self.assert_silent("NO_CAMERA", image=lambda h: to_depth_image(h, depth()[::2]))
        self.assert_silent("STALE", age=5.0)
        self.assert_silent("FUTURE", age=-5.0)

    def test_7_of_more_images_than_it_has_time_for_the_newest_pass(self):
        """All wait for the joint states, which come last; the others are told as dropped."""
        self.see()
        key = f"{IMAGE} CROWDED_OUT"
        before, sent, newest = self.diagnostics.count(key), [], []

        def burst():
            for i in reversed(range(1, BURST)):
                sent.append(rospy.Time.from_sec(self.now + TICK - 1e-3 * i))
                self.image_pub.publish(
                    to_depth_image(Header(frame_id=CAMERA, stamp=sent[-1]), depth())
                )
            newest.append(self.tick())

        wait_until(
            self.news,
            lambda: self.diagnostics.count(key) > before,
            lambda: f"{key}; {self.diagnostics}",
            burst,
        )
        wait_until(self.news, lambda: newest[-1] in self.images, "the last of the last burst")
        self.assertLess(len([stamp for stamp in sent if stamp in self.images]), len(sent))
        self.see()

    def test_7_goes_on_after_the_clock_went_back(self):
        self.see()
        type(self).now = 10.0
        self.assertLess(self.see().header.stamp.to_sec(), 500.0)

    def test_8_wrong_parameters_are_refused(self):
        cases = (
            ("padding", "-1.0", "must lie in"),
            ("visual", "7", "must be true or false"),
            ("arm", "2", "is not known"),
        )
        for i, (name, value, said) in enumerate(cases):
            output = output_of_refusal("depth_self_filter", f"_{name}:={value}", f"__name:=no_{i}")
            self.assertIn(f"parameter /robot1/no_{i}/{name}", output)
            self.assertIn(said, output)
        output = output_of_refusal(
            "depth_self_filter", "_excluded_links:=[gripper]", "__name:=no_l"
        )
        self.assertIn("link gripper", output)
        rospy.set_param(
            "broken",
            URDF.replace('<box size="0.5 0.06 0.06"/>', '<mesh filename="package://gone/a.stl"/>'),
        )
        output = output_of_refusal(
            "depth_self_filter", "_description_parameter:=broken", "__name:=no_m"
        )
        self.assertIn("parameter /robot1/broken: link bar: package://gone/a.stl", output)


if __name__ == "__main__":
    rospy.init_node("test_depth_self_filter", disable_rostime=True)
    rostest.rosrun("safe_passage", "test_depth_self_filter", DepthSelfFilterTest, sys.argv)
