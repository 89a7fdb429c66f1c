"""Node warehouse_sim: a simulated robot with its sensors, among people; it makes the clock."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import Twist as TwistMessage
from nav_msgs.msg import OccupancyGrid, Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, JointState, LaserScan, PointCloud2
from std_msgs.msg import Header
from std_srvs.srv import Empty, EmptyResponse
from visualization_msgs.msg import MarkerArray

import safe_passage._person_detection as detection
from safe_passage.core.errors import ParameterError, shown
from safe_passage.core.geometry import compose, inverse, matrix
from safe_passage.core.parameters import check_flag, check_range, check_text
from safe_passage.msg import PersonArray
from safe_passage.ros import conversions, simulation_conversions
from safe_passage.ros.parameters import read_parameters
from safe_passage.simulation.arms import read_description
from safe_passage.simulation.drive import Twist
from safe_passage.simulation.faults import make_fault_plan
from safe_passage.simulation.robots import CameraModel, LidarModel, load_robot
from safe_passage.simulation.simulator import Simulator
from safe_passage.simulation.worlds import load_world

CLOCK_START = 1.0  # [s] a clock at 0 means that none is running
MOST_BEHIND = 0.1  # [s] behind another simulator's clock
PEOPLE_RATE = 10.0  # [Hz] of the truth about people


@dataclass(frozen=True)
class WarehouseSimParameters:
    """Private parameters of the node."""

    world: str = ""  # yaml file, see config/worlds
    robot: str = ""  # yaml file, see config/robots
    seed: int = 0  # of all noise
    real_time_factor: float = 1.0  # simulated seconds a second, at most
    follow_clock: bool = False  # another simulator makes the clock: keep in its time
    faults: tuple = ()  # of sensors, tf and odometry, see simulation/faults.py
    map_frame: str = "map"
    odom_frame: str = "odom"
    base_frame: str = "base_footprint"
    robot_frame: str = "base_link"  # the same place: the robot is flat

    def __post_init__(self) -> None:
        check_text("world", self.world)
        check_text("robot", self.robot)
        if isinstance(self.seed, bool) or not isinstance(self.seed, int) or self.seed < 0:
            raise ParameterError(f"seed is {shown(self.seed)}, must be a whole number from 0 on")
        check_flag("follow_clock", self.follow_clock)
        check_range("real_time_factor", self.real_time_factor, 0.01, 100.0, "")


class WarehouseSimNode:
    """Steps the simulator, paces it, publishes what is due."""

    def __init__(self) -> None:
        self._p = read_parameters(WarehouseSimParameters)
        world, robot = (
            load_world(Path(self._p.world).expanduser()),
            load_robot(Path(self._p.robot).expanduser()),
        )
        self._world, self._robot = world, robot
        self._sim = Simulator(world, robot, self._p.seed)
        sensors = [sensor.name for sensor in (*robot.lidars, *robot.cameras)]
        where = rospy.resolve_name("~faults")
        self._faults = make_fault_plan(self._p.faults, sensors, self._p.seed, where)
        self._late: list[tuple[float, Callable[[], None]]] = []  # due [s], what to do
        self._advertise()
        self._tf, self._static_tf = (
            tf2_ros.TransformBroadcaster(),
            tf2_ros.StaticTransformBroadcaster(),
        )
        rospy.Subscriber("cmd_vel", TwistMessage, self._on_command, queue_size=1)
        rospy.Service("~reset", Empty, self._on_reset)
        self._command, self._reset = Twist(), False
        self._began = self._first_stamp()
        self._commanded = -math.inf
        self._publish_still()
        rospy.loginfo(f"world {world.name}, robot {robot.name}, {len(self._sim.bodies)} people")

    def spin(self) -> None:
        """Simulate until shutdown, no faster than wanted."""
        if self._p.follow_clock:
            self._follow()
            return
        step = self._sim.STEP / self._p.real_time_factor
        due = time.monotonic()
        while not rospy.is_shutdown():
            self._cycle()
            due = max(due + step, time.monotonic() - step)  # what was lost is not caught up
            time.sleep(max(0.0, due - time.monotonic()))

    def _first_stamp(self) -> float:
        """[s] of the clock when the simulation starts."""
        if not self._p.follow_clock:
            return CLOCK_START
        rospy.loginfo("waiting for the other simulator's /clock")
        while rospy.get_time() == 0.0 and not rospy.is_shutdown():
            time.sleep(0.05)
        return rospy.get_time()

    def _follow(self) -> None:
        """Simulate until shutdown, in the time that the clock tells."""
        before, step = 0.0, self._sim.STEP
        while not rospy.is_shutdown():
            now = rospy.get_time()
            self._reset, before = self._reset or now < before, now
            behind = now - self._began - self._sim.time
            if behind > MOST_BEHIND:  # what was lost is not caught up
                self._began += behind - step
            if behind >= step or self._reset:
                self._cycle()
            else:
                time.sleep(0.2 * step)

    def _advertise(self) -> None:
        if not self._p.follow_clock:
            self._clock_pub = rospy.Publisher("/clock", Clock, queue_size=10)
        self._odom_pub = rospy.Publisher("odom", Odometry, queue_size=10)
        self._joints_pub = rospy.Publisher("joint_states", JointState, queue_size=10)
        self._map_pub = rospy.Publisher("map", OccupancyGrid, queue_size=1, latch=True)
        self._persons_pub = rospy.Publisher("~persons", PersonArray, queue_size=1)
        self._markers_pub = rospy.Publisher("~markers", MarkerArray, queue_size=1)
        self._world_pub = rospy.Publisher("~world_markers", MarkerArray, queue_size=1, latch=True)
        self._lidars = [
            (lidar, rospy.Publisher(lidar.topic, LaserScan, queue_size=50))
            for lidar in self._robot.lidars
        ]
        self._cameras = [(camera, _CameraTopics(camera)) for camera in self._robot.cameras]

    def _publish_still(self) -> None:
        """What never changes: map, world, places of the sensors."""
        stamp = self._stamp()
        header = conversions.to_header(stamp, self._p.map_frame)
        self._map_pub.publish(simulation_conversions.to_map(header, self._sim.map))
        whenever = conversions.to_header(rospy.Time(), self._p.map_frame)  # rviz may come later
        self._world_pub.publish(simulation_conversions.world_markers(whenever, self._world))
        base = conversions.to_header(stamp, self._p.base_frame)
        places = [(self._p.robot_frame, np.eye(4))]
        places += [(lidar.frame, lidar.pose_in_base()) for lidar in self._robot.lidars]
        places += [(camera.frame, camera.pose_in_base()) for camera in self._robot.cameras]
        if self._robot.arm:
            description = read_description(self._robot.arm)
            rospy.set_param("robot_description", description.urdf)
            places.append((description.root, self._robot.arm.pose_in_base()))
        self._static_tf.sendTransform(
            [conversions.to_transform(base, name, T[:3, 3], T[:3, :3]) for name, T in places]
        )

    def _cycle(self) -> None:
        if self._reset:
            self._restart()
        if self._commanded != -math.inf:
            self._sim.base.command(self._command, self._commanded)
        self._sim.base.drift = self._faults.odometry_drift(self._sim.time)
        self._sim.step()
        stamp = self._stamp()
        if not self._p.follow_clock:
            self._clock_pub.publish(Clock(stamp))
        self._publish_base(stamp)
        for lidar, publisher in self._lidars:
            if publisher.get_num_connections() and self._speaks(lidar.name, lidar.rate):
                self._publish_scan(lidar, publisher, stamp)
        for camera, topics in self._cameras:
            if topics.wanted() and self._speaks(camera.name, camera.rate):
                self._publish_frame(camera, topics, stamp)
        self._send_late()
        if self._sim.joint_names:
            header, names = conversions.to_header(stamp, ""), list(self._sim.joint_names)
            self._joints_pub.publish(JointState(header, names, self._sim.arm_positions, [], []))
        if self._is_due(PEOPLE_RATE):
            self._publish_people(stamp)

    def _speaks(self, sensor: str, rate: float) -> bool:
        """Whether the sensor has something to say now, and no fault keeps it from saying so."""
        return self._is_due(rate) and self._faults.delivered(sensor, self._sim.time)

    def _send(self, sensor: str, publish: Callable[[], None]) -> None:
        """Now, or as late as a fault has it."""
        delay = self._faults.delay(sensor, self._sim.time)
        if delay > 0.0:
            self._late.append((self._sim.time + delay, publish))
        else:
            publish()

    def _send_late(self) -> None:
        due = [publish for moment, publish in self._late if moment <= self._sim.time]
        self._late = [late for late in self._late if late[0] > self._sim.time]
        for publish in due:
            publish()

    def _stamp(self) -> rospy.Time:
        return rospy.Time.from_sec(self._began + self._sim.time)

    def _is_due(self, rate: float) -> bool:
        """Whether a multiple of 1 / rate lies in the step that was just made."""
        now, before = self._sim.time, self._sim.time - self._sim.STEP
        return math.floor(now * rate + 1e-6) > math.floor(before * rate + 1e-6)

    def _publish_base(self, stamp: rospy.Time) -> None:
        p, base = self._p, self._sim.base
        odom = conversions.to_header(stamp, p.odom_frame)
        to_odom, to_map = matrix(base.odometry), matrix(compose(base.pose, inverse(base.odometry)))
        in_map = conversions.to_header(stamp, p.map_frame)
        if self._faults.tf_available(self._sim.time):
            self._tf.sendTransform(
                [
                    conversions.to_transform(in_map, p.odom_frame, to_map[:3, 3], to_map[:3, :3]),
                    conversions.to_transform(odom, p.base_frame, to_odom[:3, 3], to_odom[:3, :3]),
                ]
            )
        self._odom_pub.publish(
            simulation_conversions.to_odometry(odom, p.base_frame, base.odometry, base.twist)
        )

    def _publish_scan(
        self, lidar: LidarModel, publisher: rospy.Publisher, stamp: rospy.Time
    ) -> None:
        header = conversions.to_header(stamp, lidar.frame)
        limits = (lidar.range_min, lidar.range_max)
        scan = conversions.to_scan(header, lidar.angles(), self._sim.scan(lidar).ranges, limits)
        self._send(lidar.name, lambda: publisher.publish(scan))

    def _publish_frame(self, camera: CameraModel, topics: _CameraTopics, stamp: rospy.Time) -> None:
        header, frame = conversions.to_header(stamp, camera.frame), self._sim.frame(camera)
        self._send(camera.name, lambda: topics.publish(header, camera, frame.bgr, frame.depth))

    def _publish_people(self, stamp: rospy.Time) -> None:
        header = conversions.to_header(stamp, self._p.map_frame)
        states = self._sim.people()
        heights = [body.height_m for body in self._sim.bodies]
        self._persons_pub.publish(simulation_conversions.to_persons(header, states, heights))
        if self._markers_pub.get_num_connections():
            robot = (self._sim.base.pose, self._robot)
            self._markers_pub.publish(
                simulation_conversions.live_markers(header, states, self._sim.bodies, *robot)
            )

    def _on_command(self, message: TwistMessage) -> None:
        linear, angular = message.linear, message.angular
        self._command = Twist(linear.x, linear.y, angular.z)
        self._commanded = self._sim.time

    def _on_reset(self, _: Empty) -> EmptyResponse:
        self._reset = True
        return EmptyResponse()

    def _restart(self) -> None:
        """Back to the start; the clock goes back with it."""
        self._sim.restart()
        self._reset, self._commanded, self._late = False, -math.inf, []
        self._began = self._first_stamp()
        rospy.logwarn("the simulation starts anew: its clock goes back")


class _CameraTopics:
    """Topics of one RGB-D camera; what nobody reads is not made."""

    def __init__(self, camera: CameraModel) -> None:
        self._info = rospy.Publisher(camera.camera_info, CameraInfo, queue_size=1)
        self._image = rospy.Publisher(camera.image, Image, queue_size=1)
        self._depth = rospy.Publisher(camera.depth, Image, queue_size=1)
        self._cloud = rospy.Publisher(camera.points, PointCloud2, queue_size=1)

    def wanted(self) -> bool:
        """Whether anybody reads."""
        return any(p.get_num_connections() for p in (self._image, self._depth, self._cloud))

    def publish(
        self, header: Header, camera: CameraModel, bgr: np.ndarray, depth: np.ndarray
    ) -> None:
        size = (camera.height, camera.width)
        self._info.publish(conversions.to_camera_info(header, size, camera.intrinsics))
        self._image.publish(conversions.to_image(header, bgr))
        if self._depth.get_num_connections():
            self._depth.publish(conversions.to_depth_image(header, depth))
        if self._cloud.get_num_connections():
            frame = detection.from_depth(depth, bgr, detection.Intrinsics(*camera.intrinsics))
            self._cloud.publish(conversions.to_cloud(header, frame.xyz, bgr))


def main() -> None:
    """Run the node."""
    rospy.init_node("warehouse_sim")
    WarehouseSimNode().spin()
