"""Node `local_costmap`: stands in for costmap_2d, with its parameters and its topics."""

from __future__ import annotations

import threading
import time
from collections import defaultdict
from typing import Callable

import rospy
import tf2_ros
from geometry_msgs.msg import PolygonStamped
from map_msgs.msg import OccupancyGridUpdate
from nav_msgs.msg import OccupancyGrid

from safe_passage.core.geometry import Pose
from safe_passage.costmap import (
    CostmapUpdate,
    LocalCostmap,
    Observation,
    PublicationArea,
    load_costmap_parameters,
)
from safe_passage.costmap.parameters import CostmapParameters, ObstacleLayerParameters
from safe_passage.ros.clock import JumpDetector
from safe_passage.ros.costmap_conversions import to_grid, to_grid_update, to_polygon
from safe_passage.ros.costmap_inputs import CostmapSource, RobotPose
from safe_passage.ros.diagnostics import NodeDiagnostics
from safe_passage.ros.live_tuning import LiveTuning
from safe_passage.ros.sensor_input import QUEUE

OnUpdate = Callable[[CostmapUpdate, Pose, rospy.Time], None]
LIVE = ("update_frequency", "publish_frequency")
LIVE_INFLATION = ("inflation_radius", "cost_scaling_factor", "inflate_unknown")
LIVE_MARKING = ("max_obstacle_height", "footprint_clearing_enabled", "clear_crossed_cells")
LIVE_SOURCE = (
    "obstacle_range", "raytrace_range", "min_obstacle_height", "max_obstacle_height",
    "observation_persistence",
)  # fmt: skip
SILENT_AFTER = 1.0  # s without a message before diagnostics report an error


def live_names(parameters: CostmapParameters) -> list[str]:
    """Paths of what may be changed while it runs; not the window, frames, layers or sensors."""
    names = list(LIVE)
    for layer in parameters.layers:
        obstacles = isinstance(layer, ObstacleLayerParameters)
        names += [
            f"{layer.name}/{name}" for name in (LIVE_MARKING if obstacles else LIVE_INFLATION)
        ]
    names += [
        f"{layer}/{source.name}/{name}"
        for layer, source in parameters.sources
        for name in LIVE_SOURCE
    ]
    return names


class CostmapNode(rospy.SubscribeListener):
    """Parameters and topics live in `namespace`: the node's own (~), or a part of it (~name/).

    `on_update` is called after each update with it, the robot's pose in the global frame, and now.
    """

    def __init__(self, namespace: str = "~", on_update: OnUpdate | None = None) -> None:
        super().__init__()
        loaded = load_costmap_parameters(rospy.get_param(namespace.rstrip("/"), {}))
        for warning in loaded.warnings:
            rospy.logwarn(f"{rospy.resolve_name(namespace)}: {warning}")
        self._parameters = parameters = loaded.parameters
        self._costmap = LocalCostmap(parameters)
        self._on_update = on_update
        self._area = PublicationArea(parameters.always_send_full_costmap)
        self._area_lock = threading.Lock()
        self._jumps, self._published = JumpDetector(), rospy.Time()
        self._pending: dict[tuple[str, str], list[Observation]] = defaultdict(list)
        self._subscribe()
        self._advertise(namespace)
        self._tuning = LiveTuning(parameters, live_names(parameters), namespace)
        self._announce()

    def spin(self) -> None:
        """Update until shutdown; in the main thread, so that a fault ends the node."""
        while not rospy.is_shutdown():
            frequency = self._parameters.update_frequency
            rate = rospy.Rate(frequency, reset=True)
            while not rospy.is_shutdown() and self._parameters.update_frequency == frequency:
                self._tune()
                self._cycle(rospy.Time.now())
                rate.sleep()

    @property
    def base_frame(self) -> str:
        """Frame of the robot."""
        return self._parameters.robot_base_frame

    def peer_subscribe(self, *_: object) -> None:
        """A newcomer needs a whole map: the latched one lacks the updates since."""
        with self._area_lock:
            self._area.forget()

    def _subscribe(self) -> None:
        self._diagnostics = NodeDiagnostics(SILENT_AFTER)
        self.tf = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self.tf)
        self._robot = RobotPose(self._parameters, self.tf, self._diagnostics)
        self._sources = {
            (layer, source.name): CostmapSource(
                source, self._parameters, self.tf, self._diagnostics
            )
            for layer, source in self._parameters.sources
        }

    def _advertise(self, namespace: str) -> None:
        self._map_publisher = rospy.Publisher(
            f"{namespace}costmap", OccupancyGrid, self, latch=True, queue_size=1
        )
        self._update_publisher = rospy.Publisher(
            f"{namespace}costmap_updates", OccupancyGridUpdate, queue_size=10
        )
        self._footprint_publisher = rospy.Publisher(
            f"{namespace}footprint", PolygonStamped, queue_size=1
        )

    def _announce(self) -> None:
        frames = f"{self._parameters.global_frame} -> {self._parameters.robot_base_frame}"
        topics = [rospy.resolve_name(source.topic) for _, source in self._parameters.sources]
        rospy.loginfo(f"costmap waits for tf {frames} and for {', '.join(topics) or 'no sensor'}")
        if self._parameters.publish_frequency == 0:
            rospy.logwarn("publish_frequency is 0 Hz: the costmap is computed but not published")

    def _tune(self) -> None:
        """Between two cycles; what was seen stays."""
        parameters = self._tuning.take()
        if parameters is not None:
            self._parameters = parameters
            self._costmap.tune(parameters)

    def _cycle(self, now: rospy.Time) -> None:
        if self._jumps.jumped_back(now):
            self._restart()
        arrived = self._gather(now)
        pose = self._robot.at(now)
        if pose is None:
            return  # a map around an unknown place would be false
        update = self._costmap.update(pose, self._pending, now.to_sec())
        self._pending.clear()
        self._publish(update, now)
        if self._on_update:
            self._on_update(update, pose, now)
        if arrived:
            self._diagnostics.latency(time.monotonic() - min(arrived))

    def _gather(self, now: rospy.Time) -> list[float]:
        """Keeps new observations until the next update; returns when they arrived."""
        arrivals = []
        for key, source in self._sources.items():
            for observation, arrived in source.take(now):
                self._pending[key].append(observation)
                arrivals.append(arrived)
            del self._pending[key][:-QUEUE]  # the robot's pose may stay unknown for long
        return arrivals

    def _publish(self, update: CostmapUpdate, now: rospy.Time) -> None:
        frame, rate = self._parameters.global_frame, self._parameters.publish_frequency
        self._footprint_publisher.publish(to_polygon(update, frame, now))
        with self._area_lock:
            self._area.gather(update)
            if rate == 0 or (now - self._published).to_sec() * rate < 0.99:
                return
            self._published = now
            whole, changed = self._area.take(update)
        if whole:
            self._map_publisher.publish(to_grid(update, frame, now))
        elif changed:
            self._update_publisher.publish(to_grid_update(update, changed, frame, now))

    def _restart(self) -> None:
        rospy.logwarn("the clock went back: the costmap starts anew")
        self.tf.clear()
        for source in self._sources.values():
            source.restart()
        self._pending.clear()
        self._costmap.reset()
        self._published = rospy.Time()
        with self._area_lock:
            self._area.forget()


def main() -> None:
    rospy.init_node("local_costmap")
    CostmapNode().spin()
