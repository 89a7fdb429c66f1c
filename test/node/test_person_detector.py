#!/usr/bin/env python3
"""Node person_detector: persons from good frames; silence, with a reason, on all others."""

import math
import sys
import tempfile
import threading
import unittest

import numpy as np
import rospy
import rostest
from node_testing import Diagnostics, output_of_refusal, wait_until
from rosgraph_msgs.msg import Clock
from safe_passage.msg import Person, PersonArray
from safe_passage.replay.sources import SceneSource
from safe_passage.ros import conversions
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from tf2_msgs.msg import TFMessage

TICK = 0.05  # s of simulated time
BURST = 12  # frames at once
SCENE_TIME = 1.0  # s, when no person hides another
POSITION_ERROR = 0.15  # m
CAMERA, GROUND = "camera_rgb_optical_frame", "base_footprint"
POINTS = "/cloud/depth_registered/points"
IMAGES = "/depth/depth_registered/image_rect + /depth/rgb/image_rect_color + /depth/rgb/camera_info"
ERROR = 2  # diagnostics


class PersonDetectorTest(unittest.TestCase):
    now = 1000.0  # s, simulated

    @classmethod
    def setUpClass(cls):
        cls.news = threading.Condition()
        source = SceneSource()
        cls.frame = source.frame(SCENE_TIME)
        cls.truth = np.array([(p.x, p.y) for p in source.scene.persons(SCENE_TIME)])
        cls.persons = {"cloud": {}, "depth": {}}
        cls.diagnostics = {
            name: Diagnostics(f"{name}/person_detector", cls.news) for name in cls.persons
        }
        cls.clock_pub = rospy.Publisher("/clock", Clock, queue_size=10)
        cls.tf_pub = rospy.Publisher("/tf", TFMessage, queue_size=100)
        cls.cloud_pub = rospy.Publisher(POINTS, PointCloud2, queue_size=BURST)
        cls.cloud_info_pub = rospy.Publisher("/cloud/rgb/camera_info", CameraInfo, queue_size=2)
        topics = IMAGES.split(" + ")
        kinds = Image, Image, CameraInfo
        cls.image_pubs = [
            rospy.Publisher(topic, kind, queue_size=BURST) for topic, kind in zip(topics, kinds)
        ]
        for name in cls.persons:
            rospy.Subscriber(f"/{name}/persons", PersonArray, cls.on_persons, callback_args=name)

    @classmethod
    def on_persons(cls, message, name):
        with cls.news:
            cls.persons[name][message.header.stamp] = message
            cls.news.notify_all()

    def tick(self, tf=True, step=TICK):
        """The world goes on by a step [s]; returns its time."""
        type(self).now += step
        stamp = rospy.Time.from_sec(self.now)
        self.clock_pub.publish(stamp)
        if tf:
            base = conversions.to_header(stamp, GROUND)
            pose = self.frame.p_base_camera, self.frame.R_base_camera
            self.tf_pub.publish([conversions.to_transform(base, CAMERA, *pose)])
        return stamp

    def cloud(self, stamp, frame=CAMERA):
        header = conversions.to_header(stamp, frame)
        return conversions.to_cloud(header, self.frame.xyz, self.frame.bgr)

    def send_cloud(self, stamp):
        self.cloud_pub.publish(self.cloud(stamp))

    def images(self, stamp):
        """Depth in metres, colours, camera info."""
        header = conversions.to_header(stamp, CAMERA)
        size = self.frame.bgr.shape[:2]
        return [
            conversions.to_depth_image(header, self.frame.xyz[..., 2]),
            conversions.to_image(header, self.frame.bgr),
            conversions.to_camera_info(header, size, self.frame.intrinsics),
        ]

    def send_images(self, stamp, change=lambda depth, rgb, info: None):
        messages = self.images(stamp)
        change(*messages)
        for publisher, message in zip(self.image_pubs, messages):
            publisher.publish(message)

    def see(self, name, send, **world):
        """Persons (N, 2) on the ground [m], from the first frame that is answered."""
        sent = []

        def step():
            sent.append(self.tick(**world))
            send(sent[-1])

        found = self.persons[name]
        wait_until(
            self.news,
            lambda: any(stamp in found for stamp in sent),
            lambda: f"persons; {self.diagnostics[name]}",
            step,
        )
        message = next(found[stamp] for stamp in sent if stamp in found)
        self.assertEqual(message.header.frame_id, CAMERA)
        for person in message.persons:
            self.assertEqual(person.method, Person.METHOD_HOG)
            self.assertGreater(person.roi.height, person.roi.width)
        places = np.array([(p.position.x, p.position.y, p.position.z) for p in message.persons])
        return (places @ self.frame.R_base_camera.T + self.frame.p_base_camera)[:, :2]

    def see_all(self, name="cloud", send=None, **world):
        places = self.see(name, send or self.send_cloud, **world)
        self.assertEqual(len(places), len(self.truth), places)
        for place in self.truth:
            nearest = np.linalg.norm(places - place, axis=1).min()
            self.assertLess(nearest, POSITION_ERROR, f"the person at {place}; seen: {places}")

    def assert_silent(self, reason, send, name="cloud", age=0.0, ticks=True, **world):
        """What `send` sends is counted under `reason`; nothing comes out until `see_all` again."""
        diagnostics = self.diagnostics[name]
        key = f"{POINTS if name == 'cloud' else IMAGES} {reason}"
        before = diagnostics.count(key)
        sent = []

        def step():
            now = self.tick(**world) if ticks else rospy.Time.from_sec(self.now)
            sent.append(now - rospy.Duration.from_sec(age))
            send(sent[-1])

        wait_until(
            self.news,
            lambda: diagnostics.count(key) > before,
            lambda: f"{key}; {diagnostics}",
            step,
        )
        # Answers come in order: those to what was sent would be there before this one.
        self.see_all(name, self.send_cloud if name == "cloud" else self.send_images)
        self.assertFalse([stamp for stamp in sent if stamp in self.persons[name]], reason)

    def test_1_says_what_it_waits_for(self):
        for name, topic in (("cloud", POINTS), ("depth", IMAGES)):
            diagnostics = self.diagnostics[name]
            wait_until(
                self.news,
                lambda said=diagnostics, what=topic: f"waiting for {what}" in said.message(),
                lambda said=diagnostics: f"'waiting for'; {said}",
                self.tick,
            )
            self.assertEqual(diagnostics.level(), ERROR)

    def test_2_silent_until_the_ground_is_known(self):
        def unknown():
            return self.diagnostics["cloud"].message("ground") == "unknown"

        wait_until(self.news, unknown, "the ground's state", lambda: self.tick(tf=False))
        self.assert_silent("NO_TF", self.send_cloud, tf=False)

    def test_3_persons_from_depth_images(self):
        def millimetres(depth, rgb, info):
            metres = np.frombuffer(depth.data, np.float32)
            depth.data = np.nan_to_num(1000 * metres).astype(np.uint16).tobytes()
            depth.encoding, depth.step = "16UC1", depth.step // 2

        self.see_all("depth", self.send_images)
        self.see_all("depth", lambda stamp: self.send_images(stamp, millimetres))

    def test_4_bad_clouds(self):
        def sender(change):
            def send(stamp):
                cloud = self.cloud(stamp)
                change(cloud)
                self.cloud_pub.publish(cloud)

            return send

        def no_number(cloud):
            cloud.data = np.full(len(cloud.data) // 4, np.nan, np.float32).tobytes()

        def covered(cloud):
            values = np.frombuffer(cloud.data, np.float32).reshape(cloud.height, cloud.width, -1)
            hidden = values.copy()
            hidden[..., :3] = np.nan
            hidden[200:240, 300:340] = values[200:240, 300:340]
            cloud.data = hidden.tobytes()

        def no_columns(cloud):
            cloud.width, cloud.row_step, cloud.data = 0, 0, b""

        def no_colours(cloud):
            cloud.fields = cloud.fields[:3]

        def doubles(cloud):
            cloud.fields[2].datatype = 8

        def truncated(cloud):
            cloud.data = cloud.data[: len(cloud.data) // 2]

        def unorganised(cloud):
            cloud.width, cloud.row_step, cloud.height = (
                cloud.width * cloud.height,
                len(cloud.data),
                1,
            )

        def field_far_outside(cloud):
            cloud.fields[3].offset = 2**32 - 4  # + 4 wraps round to 0

        def wider_than_its_data(cloud):
            cloud.width, cloud.row_step = 2**28, 0  # x 16 bytes wraps round to 0

        def nowhere(cloud):
            cloud.header.frame_id = ""

        self.see_all()
        for change in (no_number, covered, no_columns):
            self.assert_silent("EMPTY", sender(change))
        lies = (field_far_outside, wider_than_its_data)
        for change in (no_colours, doubles, truncated, unorganised, nowhere, *lies):
            self.assert_silent("BAD_FIELDS", sender(change))
        self.assert_silent(
            "BAD_FIELDS", lambda stamp: self.cloud_pub.publish(PointCloud2(header=header(stamp)))
        )

    def test_5_stale_and_future_frames(self):
        self.assert_silent("STALE", self.send_cloud, age=5.0)
        self.assert_silent("FUTURE", self.send_cloud, age=-5.0)

    def test_5_ground_of_one_camera_is_not_anothers(self):
        self.see_all()
        self.tick()
        # With a clock that stands still: waiting for tf must end then, too.
        self.assert_silent(
            "NO_TF",
            lambda stamp: self.cloud_pub.publish(self.cloud(stamp, "no_such_frame")),
            ticks=False,
        )

    def test_5_camera_info_of_an_uncalibrated_camera_is_not_used(self):
        diagnostics = self.diagnostics["cloud"]
        key = "/cloud/rgb/camera_info BAD_FIELDS"
        wait_until(
            self.news,
            lambda: diagnostics.count(key),
            lambda: f"{key}; {diagnostics}",
            lambda: self.cloud_info_pub.publish(CameraInfo(header=header(self.tick()))),
        )
        self.see_all()
        size = self.frame.bgr.shape[:2]
        info = conversions.to_camera_info(header(self.tick()), size, self.frame.intrinsics)
        good = "/cloud/rgb/camera_info OK"
        wait_until(
            self.news,
            lambda: diagnostics.count(good),
            lambda: f"{good}; {diagnostics}",
            lambda: self.cloud_info_pub.publish(info),
        )
        self.see_all()

    def test_6_bad_depth_images(self):
        def no_number(depth, rgb, info):
            depth.data = np.full(len(depth.data) // 4, np.nan, np.float32).tobytes()

        def bytes_for_depth(depth, rgb, info):
            depth.encoding, depth.step = "mono8", depth.width
            depth.data = depth.data[: depth.width * depth.height]

        def truncated(depth, rgb, info):
            depth.data = depth.data[: len(depth.data) // 2]

        def dark(depth, rgb, info):
            rgb.data = bytes(len(rgb.data))

        def no_colours(depth, rgb, info):
            rgb.encoding, rgb.step = "32FC1", 4 * rgb.width

        def uncalibrated(depth, rgb, info):
            info.K, info.P = [0.0] * 9, [0.0] * 12

        def no_numbers(depth, rgb, info):
            info.K, info.P = [math.nan] * 9, [math.nan] * 12

        def no_centre(depth, rgb, info):
            info.P[2] = math.nan

        def half_as_wide(depth, rgb, info):  # as of a camera that bins its pixels
            info.width, info.height = rgb.width // 2, rgb.height // 2

        def other_camera(depth, rgb, info):
            rgb.header = conversions.to_header(rgb.header.stamp, "other_camera")

        def other_info(depth, rgb, info):
            info.header = conversions.to_header(info.header.stamp, "other_camera")

        self.see_all("depth", self.send_images)
        for reason, change in (
            ("EMPTY", no_number),
            ("EMPTY", dark),
            ("BAD_FIELDS", bytes_for_depth),
            ("BAD_FIELDS", truncated),
            ("BAD_FIELDS", no_colours),
            ("BAD_FIELDS", uncalibrated),
            ("BAD_FIELDS", no_numbers),
            ("BAD_FIELDS", no_centre),
            ("BAD_FIELDS", half_as_wide),
            ("BAD_FIELDS", other_camera),
            ("BAD_FIELDS", other_info),
        ):
            self.assert_silent(
                reason, lambda stamp, change=change: self.send_images(stamp, change), "depth"
            )

    def test_6_depth_and_colours_of_different_times_are_not_paired(self):
        def colours_late(depth, rgb, info):  # in between the depth images of a slow camera
            rgb.header = header(rgb.header.stamp - rospy.Duration.from_sec(0.5))
            sent.append(depth.header.stamp)

        self.see_all("depth", self.send_images)
        sent = []
        diagnostics, key = self.diagnostics["depth"], f"{IMAGES} NO_PARTNER"
        before = diagnostics.count(key)
        wait_until(
            self.news,
            lambda: f"silent: {IMAGES}" in diagnostics.message(),
            lambda: f"silence; {diagnostics}",
            lambda: self.send_images(self.tick(step=1.0), colours_late),
        )
        self.see_all("depth", self.send_images)
        self.assertFalse([stamp for stamp in sent if stamp in self.persons["depth"]])
        wait_until(self.news, lambda: diagnostics.count(key) >= before + len(sent), key)

    def test_7_ground_is_held_while_tf_is_silent(self):
        self.see_all()
        diagnostics = self.diagnostics["cloud"]
        complaint = "tf: only dropped messages, last reason NO_TF"
        wait_until(
            self.news,
            lambda: complaint in diagnostics.message(),
            lambda: f"'{complaint}'; {diagnostics}",
            lambda: self.see_all(tf=False),
        )
        self.assertEqual(diagnostics.level(), ERROR)
        wait_until(
            self.news,
            lambda: "tf" not in diagnostics.message(),
            lambda: f"no complaint; {diagnostics}",
            self.see_all,
        )

    def assert_newest_count(self, name, input_name, send):
        """Of more frames than it has time for the last counts, the others are told as dropped."""
        self.see_all(name, send)
        diagnostics, found, bursts = self.diagnostics[name], self.persons[name], []
        key = f"{input_name} CROWDED_OUT"
        before = diagnostics.count(key)

        def burst():
            now = self.tick()
            ages = [rospy.Duration.from_sec(1e-3 * i) for i in reversed(range(BURST))]
            bursts.append([now - age for age in ages])
            for stamp in bursts[-1]:
                send(stamp)

        wait_until(
            self.news,
            lambda: diagnostics.count(key) > before,
            lambda: f"{key}; {diagnostics}",
            burst,
        )
        wait_until(self.news, lambda: bursts[-1][-1] in found, "the last of the last burst")
        came = [stamp for stamps in bursts for stamp in stamps if stamp in found]
        self.assertLess(len(came), BURST * len(bursts))
        self.see_all(name, send)

    def test_7_more_clouds_than_it_has_time_for(self):
        self.assert_newest_count("cloud", POINTS, self.send_cloud)

    def test_7_more_images_than_it_has_time_for(self):
        self.assert_newest_count("depth", IMAGES, self.send_images)

    def test_8_clock_that_goes_back(self):
        self.see_all()
        self.see_all("depth", self.send_images)
        type(self).now = 10.0
        self.assert_silent("NO_TF", self.send_cloud, tf=False)  # the ground is forgotten
        self.see_all("depth", self.send_images)

    def test_9_wrong_parameters_are_refused_by_name(self):
        for argument in ("_metod:=yolo", "_tf_timeout:=-1.0", "_input:=lidar"):
            name = argument[1:].split(":=")[0]
            output = output_of_refusal("person_detector", argument, f"__name:=refused_{name}")
            self.assertIn(f"/refused_{name}/{name}", output)

    def test_9_missing_and_broken_yolo_models_are_refused(self):
        with tempfile.NamedTemporaryFile(suffix=".onnx") as broken:
            broken.write(b"no network")
            broken.flush()
            for model in ("", "_yolo/model:=/no/such/model.onnx", f"_yolo/model:={broken.name}"):
                arguments = [a for a in ("_method:=yolo", model, "__name:=no_model") if a]
                output = output_of_refusal("person_detector", *arguments)
                self.assertIn("parameter yolo/model", output)
                self.assertIn(model.split(":=")[-1], output)


def header(stamp):
    return conversions.to_header(stamp, CAMERA)


if __name__ == "__main__":
    rospy.init_node("test_person_detector", disable_rostime=True)
    rostest.rosrun("safe_passage", "test_person_detector", PersonDetectorTest, sys.argv)
