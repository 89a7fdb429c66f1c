#!/usr/bin/env python3
"""Parameters changed by dynamic_reconfigure while the nodes run: they count, nothing is lost."""

import math
import sys
import threading
import unittest

import rospy
import rostest
from dynamic_reconfigure.client import Client
from dynamic_reconfigure.msg import Config, DoubleParameter, GroupState, StrParameter
from dynamic_reconfigure.srv import Reconfigure
from geometry_msgs.msg import Point, Twist, Vector3
from nav_msgs.msg import Odometry
from node_testing import TIMEOUT, CostmapView, Diagnostics, wait_until
from rosgraph_msgs.msg import Log
from safe_passage.msg import Person, PersonArray, SeparationState, TrackedObstacleArray
from safe_passage.ros.conversions import to_header
from safe_passage.ros.node_pages import cpp_table
from sensor_msgs.msg import LaserScan
from tracker_world import BASE, ODOM, World

AHEAD = 3.0  # [m] from the robot somebody stands


class LiveTuningTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.news = threading.Condition()
        cls.latest, cls.logs = {}, []
        cls.diagnostics = Diagnostics("robot1/separation_monitor", cls.news)
        cls.world = World()
        cls.world.people_after = lambda age: [(AHEAD, 0.0)]
        cls.odom = rospy.Publisher("odom", Odometry, queue_size=10)
        cls.command = rospy.Publisher("cmd_vel_in", Twist, queue_size=10)
        for topic, kind in (
            ("tracks", TrackedObstacleArray),
            ("separation_monitor/state", SeparationState),
            ("scan_front", LaserScan),
            ("scan_human_aware", LaserScan),
        ):
            rospy.Subscriber(topic, kind, cls.keep, callback_args=topic)
        rospy.Subscriber("/rosout", Log, lambda log: cls.logs.append(log.msg))
        cls.clients = {}

    @classmethod
    def keep(cls, message, topic):
        with cls.news:
            cls.latest[topic] = message
            cls.news.notify_all()

    def tick(self):
        """A step of time, at which all speak."""
        stamp = self.world.tick()
        self.world.measure(stamp)
        odometry = Odometry(header=to_header(stamp, ODOM), child_frame_id=BASE)
        self.odom.publish(odometry)
        command = Twist()
        command.linear.x = 0.5
        self.command.publish(command)

    def until(self, reached, what):
        wait_until(
            self.news, reached, lambda: f"{what}; {self.scale()}; {self.diagnostics}", self.tick
        )

    def client(self, node):
        if node not in self.clients:
            self.clients[node] = Client(f"/robot1/{node}", timeout=TIMEOUT)
        return self.clients[node]

    def change(self, node, **changes):
        """What the node tells to be in force then."""
        return self.client(node).update_configuration(changes)

    def scale(self):
        state = self.latest.get("separation_monitor/state")
        return state.scale if state and state.level != SeparationState.STOP else 0.0

    def somebody(self):
        """The track of who stands ahead."""
        array = self.latest.get("tracks")
        for one in array.obstacles if array else ():
            if abs(one.position.x - AHEAD) < 0.4 and abs(one.position.y) < 0.4:
                return one
        return None

    def assert_refused(self, node, changes, because):
        """Nothing changes, the values in force are told back, the log says why."""
        before = self.change(node)  # nothing: the values in force
        told = self.change(node, **changes)
        names = [name for name in before if name != "groups"]
        self.assertEqual({n: told[n] for n in names}, {n: before[n] for n in names})
        for name in names:
            self.assertEqual(rospy.get_param(f"/robot1/{node}/{name}"), before[name], name)
        self.until(lambda: any(because in log for log in self.logs), f"'{because}' in the log")

    def test_1_the_monitor_slows_down_by_another_distance(self):
        self.until(lambda: self.somebody() and self.scale() == 1.0, "free")
        told = self.change("separation_monitor", min_distance=2.6)
        self.assertEqual(told["min_distance"], 2.6)
        self.assertEqual(rospy.get_param("/robot1/separation_monitor/min_distance"), 2.6)
        self.until(lambda: self.scale() < 1.0, "slower")
        self.change("separation_monitor", min_distance=0.3)
        self.until(lambda: self.scale() == 1.0, "free again")

    def test_2_what_is_out_of_range_or_does_not_fit_is_refused(self):
        node = "separation_monitor"
        self.assert_refused(node, {"min_distance": -1.0}, "min_distance is -1.0, must lie in")
        self.assert_refused(node, {"horizon": 9.0}, "stop_horizon is 6.0, must lie in [9.0")
        self.assert_refused(node, {"min_distance": 2.6, "sigmas": 99.0}, "sigmas is 99.0")
        for _ in range(10):
            self.tick()
        self.until(lambda: self.scale() == 1.0, "still free")
        told = self.change(node, horizon=9.0, stop_horizon=12.0)  # together they fit
        self.assertEqual((told["horizon"], told["stop_horizon"]), (9.0, 12.0))

    def test_3_tracks_survive(self):
        self.until(self.somebody, "a track")
        number = self.somebody().id
        told = self.change("obstacle_tracker", confirm_cycles=100000)
        self.assertEqual(told["confirm_cycles"], 3)  # out of range
        told = self.change("obstacle_tracker", confirm_cycles=1000)
        self.assertEqual(told["confirm_cycles"], 1000)
        self.until(lambda: not self.somebody(), "no track is confirmed")
        self.change("obstacle_tracker", confirm_cycles=3)
        self.until(self.somebody, "the track again")
        self.assertEqual(self.somebody().id, number)

    def test_4_parts_have_their_names_before_them(self):
        client = self.client("obstacle_tracker")
        told = client.update_configuration({"person_labels/label_gate": 1.0})
        self.assertEqual(told["person_labels/label_gate"], 1.0)
        value = rospy.get_param("/robot1/obstacle_tracker/person_labels/label_gate")
        self.assertEqual(value, 1.0)

    def test_5_clients_are_told_ranges_and_units(self):
        found = self.client("separation_monitor").get_parameter_descriptions(timeout=TIMEOUT)
        release = next(one for one in found if one["name"] == "release_time")
        self.assertEqual((release["min"], release["max"], release["default"]), (0.0, 60.0, 1.0))
        self.assertIn("[s]", release["description"])
        self.assertNotIn("base_frame", [one["name"] for one in found])

    def nearest(self):
        """[m] of the merged scan that lies ahead of the real one; inf: nowhere."""
        merged = self.latest.get("scan_human_aware")
        real = self.latest.get("scan_front")
        if merged is None or real is None or merged.header.stamp != real.header.stamp:
            return math.nan
        return min(
            (m for m, r in zip(merged.ranges, real.ranges) if m < r - 0.01), default=math.inf
        )

    def test_6_the_merger_takes_another_radius_and_keeps_its_persons(self):
        someone = Person(position=Point(-2.5, 0.0, 0.0), velocity=Vector3(*3 * [math.nan]))
        persons = rospy.Publisher("persons", PersonArray, queue_size=1)

        def tell():
            self.tick()
            if not math.isfinite(self.nearest()):
                stamp = self.latest["scan_human_aware"].header.stamp
                persons.publish(PersonArray(header=to_header(stamp, BASE), persons=[someone]))

        self.until(lambda: "scan_human_aware" in self.latest, "a merged scan")
        wait_until(self.news, lambda: math.isfinite(self.nearest()), "an area", tell)
        persons.unregister()  # from here on the person is only remembered
        before = self.nearest()
        told = self.change("safety_area_merger", radius=1.0)
        self.assertEqual(told["radius"], 1.0)
        self.assertEqual(rospy.get_param("/robot1/safety_area_merger/radius"), 1.0)
        self.until(lambda: abs(self.nearest() - (before - 0.5)) < 0.05, f"0.5 m before {before}")

        told = self.change("safety_area_merger", inside_policy="block", clearance=0.4)
        self.assertEqual((told["inside_policy"], told["clearance"]), ("block", 0.4))
        node = "safety_area_merger"
        self.assert_refused(node, {"radius": 99.0}, "/radius is 99, must lie in [0.05, 10] m")
        self.assert_refused(node, {"radius": 0.5, "gate": math.nan}, "/gate is nan, must lie in")
        self.assert_refused(node, {"radius": 0.5, "hold_time": 0.1}, "/tf_tolerance is 0.2, must")
        self.assert_refused(node, {"inside_policy": "none"}, "/inside_policy is 'none', must be")
        for _ in range(10):
            self.tick()
        self.until(lambda: abs(self.nearest() - (before - 0.5)) < 0.05, f"0.5 m before {before}")

    def test_7_only_what_is_offered_can_be_changed(self):
        rospy.set_param(
            "/robot1/person_detector/ground_frame", "nowhere"
        )  # not read before a restart
        for node, name in (
            ("separation_monitor", "base_frame"),
            ("safety_area_merger", "fixed_frame"),
            ("person_detector", "ground_frame"),
        ):
            change = rospy.ServiceProxy(f"/robot1/{node}/set_parameters", Reconfigure)
            config = Config(strs=[StrParameter(name, "elsewhere")])
            told = change(config).config
            self.assertNotIn(name, [one.name for one in told.strs])
            self.until(
                lambda n=name: any(f"{n}" in log and "cannot be" in log for log in self.logs), name
            )

    def test_8_the_detector_takes_thresholds(self):
        client = self.client("person_detector")
        told = client.update_configuration({"hog/threshold": 0.5, "heads/min_points": 40})
        self.assertEqual((told["hog/threshold"], told["heads/min_points"]), (0.5, 40))
        self.assert_refused("person_detector", {"yolo/threshold": 1.5}, "yolo/threshold is 1.5")
        found = {one["name"]: one for one in client.get_parameter_descriptions(timeout=TIMEOUT)}
        self.assertEqual((found["voxel/leaf"]["min"], found["voxel/leaf"]["max"]), (0.01, 0.5))
        self.assertEqual(found["hog/threshold"]["default"], -0.3)
        self.assertNotIn("method", found)

    def test_9_the_costmap_inflates_anew_and_keeps_its_marks(self):
        costmap = CostmapView("local_costmap/costmap", self.news)
        self.until(lambda: len(costmap.lethal()) > 10, "marks")
        self.world.people_after = lambda age: []  # nothing clears: marks are remembered
        for _ in range(5):
            self.tick()

        def inflated():
            return int((costmap.grid > 0).sum())

        marks, before = len(costmap.lethal()), inflated()
        told = self.client("local_costmap").update_configuration(
            {"inflation_layer/inflation_radius": 1.0, "inflation_layer/cost_scaling_factor": 1.0}
        )
        self.assertEqual(told["inflation_layer/inflation_radius"], 1.0)
        self.until(lambda: inflated() > 1.2 * before, "wider inflation")
        self.assertGreaterEqual(len(costmap.lethal()), marks)
        refused = {"inflation_layer/inflation_radius": -1.0}
        self.assert_refused("local_costmap", refused, "inflation_layer/inflation_radius is -1.0")
        refused = {"obstacle_layer/front/min_obstacle_height": 3.0}  # over the max
        self.assert_refused("local_costmap", refused, "must not exceed")
        told = self.change("local_costmap", update_frequency=10.0)
        maps = costmap.maps
        self.until(lambda: costmap.maps > maps + 2, "maps at another rate")

    def test_a_the_self_filter_waits_and_is_tuned(self):
        told = self.change("depth_self_filter", padding=0.05, joint_tolerance=0.1)
        self.assertEqual((told["padding"], told["joint_tolerance"]), (0.05, 0.1))
        self.assert_refused(
            "depth_self_filter", {"time_uncertainty": 0.2}, "joint_tolerance is 0.1"
        )

    def test_b_the_pages_of_the_cpp_nodes_tell_what_the_nodes_tell(self):
        for node in ("person_detector", "safety_area_merger"):
            rows, live = cpp_table(node)
            rows = {row.name: row for row in rows if row.name in live}
            told = self.client(node).get_parameter_descriptions(timeout=TIMEOUT)
            self.assertEqual({one["name"] for one in told}, set(rows))
            for one in told:
                row = rows[one["name"]]
                self.assertEqual(one["default"], row.default, row.name)
                if not row.choices:
                    least_most = (one["min"], one["max"])
                    self.assertEqual(least_most[0], row.least, row.name)
                    if not isinstance(row.most, str):  # else another parameter
                        self.assertEqual(least_most[1], row.most, row.name)
                if row.unit and "(" not in one["description"]:
                    self.assertEqual(one["description"], f"[{row.unit}]")

    def test_c_requests_with_groups_as_of_rqt(self):
        for node, name, value in (
            ("separation_monitor", "min_distance", 0.35),
            ("safety_area_merger", "clearance", 0.35),
        ):
            change = rospy.ServiceProxy(f"/robot1/{node}/set_parameters", Reconfigure)
            numbers = [DoubleParameter(name, value)]
            told = change(
                Config(doubles=numbers, groups=[GroupState("Default", True, 0, 0)])
            ).config
            self.assertIn((name, value), [(one.name, one.value) for one in told.doubles])


if __name__ == "__main__":
    rospy.init_node("test_live_tuning")
    rostest.rosrun("safe_passage", "test_live_tuning", LiveTuningTest, sys.argv)
