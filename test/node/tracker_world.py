"""A wall and people, as two lidars and a depth camera of a robot measure them, exactly.

A robot's topics are in its namespace, its frames have its name before them.
"""

import math

import numpy as np
import rospy
from rosgraph_msgs.msg import Clock
from safe_passage.core.geometry import matrix
from safe_passage.ros.conversions import to_cloud, to_header, to_transform
from safe_passage.simulation import raycast
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import LaserScan, PointCloud2
from tf2_msgs.msg import TFMessage

ODOM, BASE = "robot1/odom", "robot1/base_link"
WALL = np.array([-4.0, 2.9, 0.0]), np.array([4.0, 3.1, 2.0])  # [m] two corners, frame odom
BODY_RADIUS, BODY_HEIGHT = 0.2, 1.7  # [m]
BEAMS, STEP = 541, math.radians(0.5)
RANGE_MAX = 20.0  # [m]
TICK = 0.04  # [s] of simulated time


def mounting(x, y, z, turns):
    """(4, 4) in base; `turns`: yaw, pitch, roll [rad]."""
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("ZYX", turns).as_matrix()
    T[:3, 3] = x, y, z
    return T


class Lidar:
    """Level, 270 degrees; `turn` -1: its beams go clockwise."""

    KIND = LaserScan

    def __init__(self, name, T_base_sensor, turn):
        self.name, self.T_base_sensor = name, T_base_sensor
        self._increment = turn * STEP
        self.angles = -turn * math.radians(135) + self._increment * np.arange(BEAMS)
        zero = np.zeros(BEAMS)
        self._rays = np.stack([np.cos(self.angles), np.sin(self.angles), zero], axis=1)

    def measure(self, header, pose, people):
        """A LaserScan."""
        ranges = cast(pose, self.T_base_sensor, self._rays, people)
        return LaserScan(
            header=header, angle_min=self.angles[0],
            angle_max=self.angles[-1], angle_increment=self._increment, range_min=0.05,
            range_max=RANGE_MAX, ranges=ranges.tolist(),
        )  # fmt: skip


class Camera:
    """64 x 48 pixels, 60 degrees wide, optical frame."""

    KIND = PointCloud2
    SIZE = 48, 64

    def __init__(self, name, T_base_body):
        self.name = name
        optical = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
        self.T_base_sensor = T_base_body.copy()
        self.T_base_sensor[:3, :3] = T_base_body[:3, :3] @ optical
        v, u = np.mgrid[: self.SIZE[0], : self.SIZE[1]].reshape(2, -1)
        rays = np.stack([u - 31.5, v - 23.5, np.full(u.shape, 55.4)], axis=1)
        self._rays = rays / np.linalg.norm(rays, axis=1)[:, None]

    def measure(self, header, pose, people):
        """A PointCloud2, the floor in it."""
        floor = raycast.plane_z(self.T_base_sensor[:3, 3], self._rays @ self._turn().T, 0.0)
        ranges = np.minimum(cast(pose, self.T_base_sensor, self._rays, people), floor)
        ranges[~np.isfinite(ranges)] = np.nan
        xyz = (ranges[:, None] * self._rays).astype(np.float32).reshape(*self.SIZE, 3)
        return to_cloud(header, xyz, np.zeros(xyz.shape, np.uint8))

    def _turn(self):
        return self.T_base_sensor[:3, :3]


def cast(pose, T_base_sensor, rays, people):
    """(N,) [m] from the sensor along `rays` (N, 3) to wall and people; inf: nothing.

    pose: of base in odom; people: places (x, y) [m], frame odom.
    """
    T = matrix(pose) @ T_base_sensor
    origin, directions = T[:3, 3], rays @ T[:3, :3].T
    nearest = raycast.box(origin, directions, *WALL)
    for x, y in people:
        low, high = np.array([x, y, 0.0]), np.array([x, y, BODY_HEIGHT - BODY_RADIUS])
        nearest = np.minimum(nearest, raycast.capsule(origin, directions, low, high, BODY_RADIUS))
    return nearest


SENSORS = {  # topic -> sensor, in the order of obstacle_tracker.yaml
    "scan_front": Lidar("laser_front", mounting(0.4, 0.3, 0.2, (0.8, 0.0, 0.0)), turn=-1),
    "scan_rear": Lidar("laser_rear", mounting(-0.4, -0.3, 0.2, (-2.3, 0.0, math.pi)), turn=1),
    "camera/points": Camera("camera", mounting(0.3, 0.0, 1.3, (0.0, 0.5, 0.0))),
}


class World:
    """Makes the clock; people and robot are where their functions say."""

    def __init__(self, robot="robot1"):
        self._robot = robot
        self._now = 100.0  # [s]
        self.measured = rospy.Time()  # when a sensor spoke last
        self._clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self._tf = rospy.Publisher("/tf", TFMessage, queue_size=100)
        self._sensors = {
            topic: rospy.Publisher(f"/{robot}/{topic}", sensor.KIND, queue_size=10)
            for topic, sensor in SENSORS.items()
        }
        self.begin()

    def begin(self):
        """Nobody is there and the robot stands, until told otherwise."""
        self._began = self._now
        self.people_after = lambda age: []  # [s] since then -> places (x, y) [m], odom
        self.pose_after = lambda age: (0.0, 0.0, 0.0)  # of the robot, odom

    @property
    def age(self):
        """[s] since `begin`."""
        return self._now - self._began

    def since(self, stamp):
        """[s] from `begin` to the stamp."""
        return stamp.to_sec() - self._began

    def set_back(self, seconds):
        """The clock to `seconds`."""
        self._now = seconds
        self.begin()

    def tick(self, tf=True):
        """A step of time; returns its stamp."""
        self._now += TICK
        microseconds = round(1e6 * self._now)
        stamp = rospy.Time(microseconds // 10**6, 1000 * (microseconds % 10**6))
        self._clock.publish(stamp)
        if tf:
            self.publish_tf(stamp)
        return stamp

    def publish_tf(self, stamp):
        """The robot's place, and the sensors' in it."""
        T = matrix(self.pose_after(self.since(stamp)))
        odom, base = to_header(stamp, self.frame("odom")), self.frame("base_link")
        found = [to_transform(odom, base, T[:3, 3], T[:3, :3])]
        for sensor in SENSORS.values():
            T, header = sensor.T_base_sensor, to_header(stamp, base)
            found.append(to_transform(header, self.frame(sensor.name), T[:3, 3], T[:3, :3]))
        self._tf.publish(found)

    def frame(self, name):
        """As tf knows it."""
        return f"{self._robot}/{name}"

    def message(self, topic, stamp):
        """What the sensor measures then."""
        age = self.since(stamp)
        sensor = SENSORS[topic]
        header = to_header(stamp, self.frame(sensor.name))
        return sensor.measure(header, self.pose_after(age), self.people_after(age))

    def publish(self, topic, message):
        """As it is."""
        self._sensors[topic].publish(message)

    def measure(self, stamp, topics=tuple(SENSORS)):
        """These sensors speak."""
        self.measured = stamp
        for topic in topics:
            self.publish(topic, self.message(topic, stamp))
