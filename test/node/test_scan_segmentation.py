#!/usr/bin/env python3
"""Nodes scan_assembler and scan_segmentation_server: clouds as they were, results, refusals."""

import math
import re
import subprocess
import sys
import threading
import unittest
from pathlib import Path
from xmlrpc.client import ServerProxy

import actionlib
import numpy as np
import rosgraph
import roslib.packages
import rospy
import rostest
import rotating_scanner
import tf2_ros
from nav_msgs.msg import OccupancyGrid
from node_testing import Diagnostics, output_of_refusal, wait_until
from rosgraph_msgs.msg import Clock
from rotating_scanner import LINES, PERIOD, SCANNER
from safe_passage.evaluation.segmentation_places import garage
from safe_passage.msg import (
    RobotConfiguration,
    ScanPlanes,
    ScanSegmentation,
    SegmentScanAction,
    SegmentScanGoal,
)
from safe_passage.ros.conversions import to_header, to_transform
from safe_passage.ros.scan_conversions import to_scan_cloud
from safe_passage.ros.sensor_conversions import cloud_grid
from safe_passage.scan_segmentation.assembling import Assembled
from safe_passage.simulation.scan_scene import Block, Place, Scanner, scan_place
from safe_passage.srv import SelectRobot
from sensor_msgs.msg import Image, JointState, LaserScan, PointCloud2
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

SERVER = "scan_segmentation_server"
ERROR = 2  # diagnostics
STAGES = ["lines", "planes", "ground", "map", "traversability", "doors"]
GARAGE, _ = scan_place(garage(), SCANNER, 11)
WALL = Place(blocks=(Block((2.0, -3.0, -2.0), (2.2, 3.0, 4.0)),))  # and nothing to stand on
LONG_AGO = rospy.Time()
TOPICS = {
    "result": ScanSegmentation,
    "planes": ScanPlanes,
    "traversability": OccupancyGrid,
    "traversability_image": Image,
    "markers": MarkerArray,
    "walls": MarkerArray,
    "cloud": PointCloud2,
}


def to_message(scan, stamp, frame="scanner"):
    beta = np.repeat(scan.beta[:, None], scan.points.shape[1], axis=1)
    return to_scan_cloud(to_header(stamp, frame), Assembled(scan, beta, 0.0, 0.0))


class ScanSegmentationTest(unittest.TestCase):
    now = 1000.0  # s, simulated
    line = 0  # of the scanner

    @classmethod
    def setUpClass(cls):
        cls.news = threading.Condition()
        cls.messages = {}  # topic -> all that came
        cls.assembler = Diagnostics("robot1/scan_assembler", cls.news)
        cls.tf_assembler = Diagnostics("robot1/tf_assembler", cls.news)
        cls.server = Diagnostics(f"robot1/{SERVER}", cls.news)
        cls.clock_pub = rospy.Publisher("/clock", Clock, queue_size=10)
        cls.tf_pub = rospy.Publisher("/tf", TFMessage, queue_size=200)
        cls.scan_pub = rospy.Publisher("scan", LaserScan, queue_size=200)
        cls.joint_pub = rospy.Publisher("joint_states", JointState, queue_size=200)
        cls.cloud_pub = rospy.Publisher("rotating_scan/points", PointCloud2, queue_size=5)
        for topic, kind in TOPICS.items():
            rospy.Subscriber(f"{SERVER}/{topic}", kind, cls.note, topic)
        rospy.Subscriber("rotating_scan/points", PointCloud2, cls.note, "points")
        rospy.Subscriber("tf_points", PointCloud2, cls.note, "tf_points")
        cls.broadcaster = tf2_ros.StaticTransformBroadcaster()
        level = to_header(rospy.Time(0), "odom")
        place = np.array(SCANNER.position)
        cls.broadcaster.sendTransform(to_transform(level, "scanner", place, SCANNER.rotation()))
        cls.client = actionlib.ActionClient(f"{SERVER}/segment_scan", SegmentScanAction)
        cls.advance()

    @classmethod
    def note(cls, message, topic):
        with cls.news:
            cls.messages.setdefault(topic, []).append(message)
            cls.news.notify_all()

    @classmethod
    def advance(cls, seconds=0.05):
        cls.now += seconds
        cls.clock_pub.publish(rospy.Time.from_sec(cls.now))

    def last(self, topic):
        with self.news:
            return self.messages[topic][-1]

    def turn(self, lines=LINES // 2, step=1, frame="laser", tf=True):
        """The scanner goes on by `lines`, by now in the past: no message is from the future."""
        begin, first = self.now, self.line
        type(self).line += lines * step
        self.advance(lines * PERIOD)
        numbers = [first + step * i for i in range(lines + 1)]
        stamps = [rospy.Time.from_sec(begin + i * PERIOD) for i in range(lines + 1)]
        for number, stamp in zip(numbers, stamps):
            self.joint_pub.publish(rotating_scanner.joint(number, stamp))
            if tf:
                self.tf_pub.publish([rotating_scanner.laser(number, stamp)])
        for number, stamp in zip(numbers[:-1], stamps):
            self.scan_pub.publish(rotating_scanner.scan(number, stamp, frame))

    def clouds(self, topic, count=1):
        """As many new clouds of the turning scanner."""
        known = len(self.messages.get(topic, []))
        wait_until(
            self.news,
            lambda: len(self.messages.get(topic, [])) >= known + count,
            lambda: f"{topic}; {self.assembler}",
            self.turn,
        )
        return self.messages[topic][known : known + count]

    def ask(self, cloud=None, cancel_at="", **goal):
        """The action's state, result and feedback."""
        ended, said = [], []

        def on_feedback(handle, feedback):
            said.append(feedback)
            if feedback.stage == cancel_at:
                handle.cancel()

        def on_transition(handle):
            if handle.get_comm_state() == actionlib.CommState.DONE:
                with self.news:
                    ended.append((handle.get_terminal_state(), handle.get_result()))
                    self.news.notify_all()

        wait_until(
            self.news,
            lambda: self.client.wait_for_server(rospy.Duration(0, 1000000)),
            "the action server",
            self.advance,
        )
        cloud = cloud or PointCloud2()
        handle = self.client.send_goal(
            SegmentScanGoal(cloud=cloud, **goal), on_transition, on_feedback
        )
        wait_until(self.news, lambda: ended, lambda: f"a result; {self.server}", self.advance)
        del handle
        state, result = ended[0]
        return state, result.segmentation, said

    def garage(self, frame="scanner"):
        return to_message(GARAGE, rospy.Time.from_sec(self.now), frame)

    def settled(self, since=LONG_AGO):
        """The last result, of `since` or later, once all that was published with it is here."""

        def arrived():
            if not all(self.messages.get(topic) for topic in TOPICS):
                return False
            last = {topic: self.messages[topic][-1] for topic in TOPICS}
            stamp = last["result"].header.stamp  # topics may come after the goal's own answer
            headers = [
                one.markers[0].header if isinstance(one, MarkerArray) else one.header
                for one in last.values()
            ]
            planes = last["planes"].planes, last["result"].planes
            agree = len(planes[0]) == len(planes[1]) and all(h.stamp == stamp for h in headers)
            return agree and stamp >= since

        wait_until(self.news, arrived, f"all topics since {since}", self.advance)
        return self.last("result")

    def assert_nothing_drawn(self, reason):
        """All that was drawn is gone, and it is said why."""
        wait_until(
            self.news,
            lambda: self.messages["result"][-1].reason == reason,
            lambda: f"reason {reason}, not {self.messages['result'][-1].text}",
            self.advance,
        )
        result = self.settled()
        self.assertFalse(result.success)
        self.assertTrue(result.text)
        self.assertEqual((result.planes, result.doors, result.stairs), ([], [], []))
        self.assertEqual(len(result.map.data), 0)
        for topic in ("markers", "walls"):
            self.assertEqual([m.action for m in self.last(topic).markers], [Marker.DELETEALL])
        self.assertEqual(len(self.last("traversability").data), 0)
        self.assertEqual(self.last("cloud").width, 0)
        self.assertEqual(self.last("planes").planes, [])

    def test_01_say_what_they_wait_for(self):
        wait_until(
            self.news,
            lambda: "waiting for: /robot1/joint_states" in self.assembler.message(),
            lambda: f"'waiting for'; {self.assembler}",
            self.advance,
        )
        self.assertIn("waiting for: /robot1/scan", self.assembler.message())
        self.assertEqual(self.assembler.level(), ERROR)
        state, result, _ = self.ask()
        self.assertEqual(state, actionlib.GoalStatus.ABORTED)
        self.assertEqual(result.reason, ScanSegmentation.NO_CLOUD)
        self.assertIn("no cloud on /robot1/rotating_scan/points yet", result.text)

    def test_02_clouds_are_the_room(self):
        for topic in ("points", "tf_points"):
            cloud = self.clouds(topic, 2)[1]
            self.assertEqual((cloud.header.frame_id, cloud.height), ("scanner", LINES))
            self.assert_the_room(cloud)

    def assert_the_room(self, cloud):
        grid = cloud_grid(cloud, ("intensity", "beta"))
        numbers = grid["intensity"][:, 0].astype(int)
        self.assertEqual(sorted(numbers), list(range(LINES)))  # a whole turn, each line once
        points = np.stack([grid[axis] for axis in "xyz"], axis=-1)
        exact = np.stack([rotating_scanner.truth(number) for number in numbers])
        self.assertLess(np.nanmax(np.linalg.norm(points - exact, axis=-1)), 1e-3)
        steps = np.diff(grid["beta"].mean(axis=1))
        np.testing.assert_allclose(steps, 2.0 * math.pi / LINES, atol=1e-4)

    def test_03_a_sweep_with_a_hole_is_none(self):
        self.clouds("points")
        self.assert_counted("sweep BROKEN_SWEEP", lambda: self.turn(4, step=4))
        self.assert_counted("sweep NO_TURN", lambda: self.turn(4, step=0))
        self.clouds("points")

    def assert_counted(self, key, step):
        before = self.assembler.count(key)
        wait_until(
            self.news,
            lambda: self.assembler.count(key) > before,
            lambda: f"{key}; {self.assembler}",
            step,
        )

    def test_04_bad_scans(self):
        def sender(change, age=0.0):
            def send():
                self.advance()
                message = rotating_scanner.scan(0, rospy.Time.from_sec(self.now - age))
                change(message)
                self.scan_pub.publish(message)

            return send

        def attribute(name, value):
            return lambda message: setattr(message, name, value)

        scan = "/robot1/scan"
        for reason, send in (
            ("EMPTY", sender(attribute("ranges", []))),
            ("NOT_FINITE", sender(attribute("ranges", [math.nan] * 45))),
            ("BAD_FIELDS", sender(attribute("angle_increment", math.nan))),
            ("BAD_FIELDS", sender(attribute("time_increment", -1.0))),
            ("BAD_FIELDS", sender(lambda m: setattr(m.header, "frame_id", ""))),
            ("STALE", sender(lambda m: None, age=9.0)),
            ("FUTURE", sender(lambda m: None, age=-9.0)),
            ("NO_JOINTS", sender(lambda m: None)),
        ):
            self.assert_counted(f"{scan} {reason}", send)
        self.clouds("points")

    def test_05_a_goal_gets_planes_stages_and_a_result(self):
        state, result, said = self.ask(self.garage(), robot="smallest")
        self.assertEqual(state, actionlib.GoalStatus.SUCCEEDED, result.text)
        self.assertTrue(result.success)
        self.assertEqual((result.reason, result.robot), (ScanSegmentation.OK, "smallest"))
        self.assertEqual([one.stage for one in said], STAGES)
        self.assertEqual(sorted(one.fraction for one in said), [one.fraction for one in said])
        self.assertGreater(sum(plane.ground for plane in result.planes), 0)
        door = result.doors[0]
        self.assertAlmostEqual(door.width, 0.90, delta=0.03)
        self.assertEqual(door.passable_by, ["smallest"])
        self.settled(result.header.stamp)
        # in the scanner's frame, whose z points ahead and x to the left
        self.assertAlmostEqual(door.pose.position.z, 4.0, delta=0.1)
        self.assertEqual(result.map.header.frame_id, "scanner")
        drawn = {m.ns for m in self.last("markers").markers if m.action == Marker.ADD}
        self.assertLessEqual({"drivable", "obstacles", "doors", "scanner"}, drawn)
        self.assertGreater(len(self.last("walls").markers[1].points), 0)
        # planes came before all the rest, without ground
        with self.news:
            early = [m for m in self.messages["planes"] if m.header.stamp == result.header.stamp]
        self.assertGreater(len(early[0].planes), 3)
        self.assertFalse(any(plane.ground for plane in early[0].planes))

    def test_06_supporting_structures_for_who_asks(self):
        got = {}
        topics = {"plane_markers": MarkerArray, "segments": MarkerArray, "basic_map": OccupancyGrid}
        subscribers = [
            rospy.Subscriber(f"{SERVER}/{topic}", kind, lambda m, t=topic: got.update({t: m}))
            for topic, kind in topics.items()
        ]
        wait_until(
            self.news,
            lambda: set(got) == set(topics),
            lambda: f"{set(topics)}, only {set(got)}",
            lambda: self.ask(self.garage()),
        )
        self.assertGreater(len(got["segments"].markers[1].points), 100)
        self.assertGreater(max(got["basic_map"].data), 0)
        for subscriber in subscribers:
            subscriber.unregister()

    def test_07_values_of_a_robot_and_robots_nobody_knows(self):
        box = RobotConfiguration(0.5, 0.4, 0.5, 0.3, 0.05, 0.0)
        _, result, _ = self.ask(self.garage(), values=box)
        self.assertEqual((result.success, result.robot), (True, "values"))
        self.assertIn("values", result.doors[0].passable_by)
        _, result, _ = self.ask(self.garage(), robot="giant")
        self.assertEqual(result.reason, ScanSegmentation.BAD_ROBOT)
        self.assertIn("smallest, wide, high", result.text)
        self.assert_nothing_drawn(ScanSegmentation.BAD_ROBOT)
        box.width = -1.0
        _, result, _ = self.ask(self.garage(), values=box)
        self.assertIn("values/width is -1.0", result.text)

    def test_08_a_goal_can_be_given_up(self):
        state, result, said = self.ask(self.garage(), cancel_at="lines")
        self.assertIn(state, (actionlib.GoalStatus.PREEMPTED, actionlib.GoalStatus.RECALLED))
        self.assertEqual(result.reason, ScanSegmentation.CANCELLED)
        self.assertLess(len(said), len(STAGES))
        self.assert_nothing_drawn(ScanSegmentation.CANCELLED)

    def test_09_the_latest_for_another_robot(self):
        latest = rospy.ServiceProxy(f"{SERVER}/segment_latest", Trigger)
        select = rospy.ServiceProxy(f"{SERVER}/select_robot", SelectRobot)
        self.advance()
        sent = self.garage()
        self.cloud_pub.publish(sent)
        wait_until(
            self.news,
            lambda: self.last("result").header.stamp == sent.header.stamp,
            lambda: f"the cloud; {self.server}",
            lambda: (self.advance(), latest()),
        )
        self.assertTrue(self.last("result").success)
        answer = select("wide")
        self.assertTrue(answer.success)
        self.assertIn("for wide", answer.message)
        self.assertIn("1 doors, 0 passable", answer.message)
        self.assertEqual(answer.known, ["smallest", "wide", "high"])
        wait_until(self.news, lambda: self.last("result").robot == "wide", "wide", self.advance)
        answer = select("giant")
        self.assertFalse(answer.success)
        self.assertIn("'giant' is not known", answer.message)
        self.assertIn("1 passable", select("smallest").message)

    def test_10_a_scan_without_ground_draws_nothing(self):
        self.assertTrue(self.ask(self.garage())[1].success)
        scan, _ = scan_place(WALL, SCANNER, 5)
        state, result, _ = self.ask(to_message(scan, rospy.Time.from_sec(self.now)))
        self.assertEqual(state, actionlib.GoalStatus.ABORTED)
        self.assertIn("ground", result.text)
        self.assert_nothing_drawn(ScanSegmentation.NO_GROUND)
        self.assertTrue(self.ask(self.garage())[1].success)

    def test_11_bad_clouds(self):
        def changed(**values):
            cloud = self.garage()
            for name, value in values.items():
                setattr(cloud, name, value)
            return cloud

        good = self.garage()
        nothing = PointCloud2(header=good.header, fields=good.fields, point_step=good.point_step)
        unknown = np.full_like(GARAGE.points, np.nan)
        blind = type(GARAGE)(unknown, GARAGE.beta)
        bad = ScanSegmentation.BAD_CLOUD
        for cloud, reason, said in (
            (nothing, bad, "EMPTY"),
            (changed(fields=good.fields[1:]), bad, "no float32 field x"),
            (changed(data=good.data[:100]), bad, "bytes for"),
            (changed(header=to_header(good.header.stamp, "")), bad, "no frame_id"),
            (to_message(blind, good.header.stamp), bad, "NOT_FINITE"),
            (self.garage("nowhere"), ScanSegmentation.NO_TF, "nowhere"),
            (to_message(GARAGE, good.header.stamp), ScanSegmentation.OK, "planes"),
        ):
            _, result, _ = self.ask(cloud)
            self.assertEqual(result.reason, reason, result.text)
            self.assertIn(said, result.text)
            if reason != ScanSegmentation.OK:
                self.assert_nothing_drawn(reason)
        self.cloud_pub.publish(changed(fields=good.fields[1:]))
        key = "/robot1/rotating_scan/points BAD_FIELDS"
        wait_until(
            self.news, lambda: self.server.count(key) > 0, lambda: f"{self.server}", self.advance
        )

    def test_12_clouds_without_angles_and_lines(self):
        points = GARAGE.points.reshape(1, -1, 3)
        cloud = self.garage()
        cloud.height, cloud.width = 1, points.shape[1]
        cloud.row_step = cloud.width * cloud.point_step
        cloud.fields = cloud.fields[:3]
        _, result, _ = self.ask(cloud)
        self.assertTrue(result.success, result.text)
        self.assertGreater(len(result.planes), 4)

    def test_13_goes_on_after_the_clock_went_back(self):
        self.assertTrue(self.ask(self.garage())[1].success)
        type(self).now = 10.0
        self.advance()
        self.assert_nothing_drawn(ScanSegmentation.NO_CLOUD)
        self.clouds("points", 2)
        self.assertTrue(self.ask(self.garage())[1].success)

    def test_14_a_server_that_was_restarted(self):
        path, *_ = roslib.packages.find_node("safe_passage", SERVER)
        name = "restarted"
        rospy.set_param(name, rospy.get_param(SERVER))
        latest = f"{name}/segment_latest"
        drawn = []
        rospy.Subscriber(f"{name}/markers", MarkerArray, drawn.append)
        for _ in range(2):
            drawn.clear()
            node = subprocess.Popen([path, f"__name:={name}"])
            try:
                wait_until(self.news, lambda: answers(latest), "the service", self.advance)
                answer = rospy.ServiceProxy(latest, Trigger)()
                self.assertIn("no cloud on", answer.message)
                # what another life of it left on a screen is taken away
                wait_until(self.news, lambda: drawn, "markers", self.advance)
                self.assertEqual(drawn[0].markers[0].action, Marker.DELETEALL)
            finally:
                node.terminate()
                node.wait(20.0)

    def test_15_ten_million_points_are_thinned_out_and_that_is_said(self):
        scan, _ = scan_place(garage(), Scanner(lines=870), 12)
        points = scan.points.repeat(8, axis=0).repeat(8, axis=1)
        self.assertGreater(points[..., 0].size, 10_000_000)
        beta = np.repeat(scan.beta, 8)
        cloud = to_message(type(scan)(points, beta), rospy.Time.from_sec(self.now))
        before = peak_memory(f"/robot1/{SERVER}")
        _, result, _ = self.ask(cloud)
        self.assertTrue(result.success, result.text)
        self.assertIn("thinned out: one line in 8, of it one point in 8", result.text)
        self.assertLess(peak_memory(f"/robot1/{SERVER}") - before, 6 * len(cloud.data))

    def test_16_an_old_cloud_is_not_the_latest(self):
        latest = rospy.ServiceProxy(f"{SERVER}/segment_latest", Trigger)
        self.advance()
        sent = self.garage()
        self.cloud_pub.publish(sent)
        wait_until(
            self.news,
            lambda: self.last("result").header.stamp == sent.header.stamp,
            lambda: f"the cloud; {self.server}",
            lambda: (self.advance(), latest()),
        )
        self.advance(601.0)  # max_age is 600 s
        wait_until(
            self.news,
            lambda: self.last("result").reason == ScanSegmentation.NO_CLOUD,
            lambda: f"a refusal, not {self.last('result').text}",
            lambda: (self.advance(), latest()),
        )
        self.assertRegex(self.last("result").text, r"the last cloud on \S+/points is 60\d s old")
        self.assert_nothing_drawn(ScanSegmentation.NO_CLOUD)
        self.cloud_pub.publish(sent)
        key = "/robot1/rotating_scan/points STALE"
        wait_until(
            self.news, lambda: self.server.count(key) > 0, lambda: f"{self.server}", self.advance
        )

    def test_17_without_tf_the_assembler_drops_scans_and_says_so(self):
        self.clouds("tf_points")
        known = len(self.messages["tf_points"])
        dropped = "/robot1/scan: only dropped messages, last reason NO_TF"
        wait_until(
            self.news,
            lambda: dropped in self.tf_assembler.message(),
            lambda: f"NO_TF; {self.tf_assembler}",
            lambda: self.turn(frame="nowhere"),
        )
        self.assertEqual(self.tf_assembler.level(), ERROR)
        self.assertGreater(self.tf_assembler.count("/robot1/scan NO_TF"), 0)
        self.assertEqual(len(self.messages["tf_points"]), known)
        self.clouds("tf_points")

    def test_17_what_turns_is_not_interpolated_across_a_gap_of_tf(self):
        self.clouds("tf_points")
        known = len(self.messages["tf_points"])
        for _ in range(6):  # a turn and a tenth: between its ends lies a tenth
            self.turn(LINES // 6 + 1, tf=False)
        self.clouds("tf_points", 2)
        for cloud in self.messages["tf_points"][known:]:
            self.assert_the_room(cloud)

    def test_18_wrong_parameters_are_refused(self):
        cases = (
            ("scan_assembler", "sweep", "9.0", "must lie in"),
            ("scan_assembler", "speed", "1.0", "is not known"),
            (SERVER, "speed", "1.0", "is not known"),
            (SERVER, "robots", "1.0", "needs robots"),
        )
        for i, (program, name, value, said) in enumerate(cases):
            output = output_of_refusal(program, f"_{name}:={value}", f"__name:=no_{i}")
            self.assertIn(f"parameter /robot1/no_{i}/{name}", output)
            self.assertIn(said, output)


def peak_memory(node):
    """[bytes] of a node, the most that it has had so far."""
    api = rosgraph.Master(rospy.get_name()).lookupNode(node)
    _, _, pid = ServerProxy(api).getPid(rospy.get_name())
    status = Path(f"/proc/{pid}/status").read_text()
    return 1024 * int(re.search(r"VmHWM:\s+(\d+) kB", status).group(1))


def answers(service):
    try:
        rospy.wait_for_service(service, 0.1)
    except rospy.ROSException:
        return False
    return True


if __name__ == "__main__":
    rospy.init_node("test_scan_segmentation", disable_rostime=True)
    rostest.rosrun("safe_passage", "test_scan_segmentation", ScanSegmentationTest, sys.argv)
