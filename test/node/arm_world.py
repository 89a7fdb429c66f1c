#!/usr/bin/env python3
"""A simulated arm before a depth camera, as topics; with `iiwa` as argument to be looked at.

rosrun safe_passage arm_world.py iiwa
"""

import sys
import threading
from pathlib import Path

import numpy as np
import rospy
from rosgraph_msgs.msg import Clock
from safe_passage.robot_model import load_robot_model
from safe_passage.robot_model.surfaces import box
from safe_passage.ros.conversions import to_camera_info, to_depth_image, to_transform
from safe_passage.simulation.arm_scene import FLOOR, ArmScene, at, looking_at, room
from safe_passage.simulation.arms import find_urdf
from safe_passage.simulation.robots import CameraModel
from safe_passage.simulation.sensors import measured_depth
from sensor_msgs.msg import CameraInfo, Image, JointState
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

sys.path.append(str(Path(__file__).resolve().parents[1] / "worlds"))
from box_arm import ARM, POSES, T_ROOT_CAMERA, off

TICK = 0.05  # s of simulated time between images
RATE = 0.04  # s of wall time between them
HOLD = 24  # images of a pose
IMAGES = 6  # of a pose that differ
OPTICAL = "camera_depth_optical_frame"
CAMERA = CameraModel(width=480, height=360, focal=394.0, range_min=0.4)
IIWA = "pybullet_data/kuka_iiwa/model.urdf"
IIWA_POSES = [
    (0.3, 0.6, 0.2, -1.2, 0.1, 0.8, 0.0),
    (1.2, 0.4, -0.4, -1.6, 0.5, -0.6, 0.4),
    (-0.6, 0.7, 0.5, -0.9, -0.5, 1.0, 0.2),
    (0.8, -0.3, 0.3, -1.3, 0.2, 1.2, 0.9),
    (0.0, 0.2, -0.7, -1.8, 0.9, 0.3, -0.5),
]


class SeenArm:
    """An arm in its poses before a camera; its messages of any time, published by nobody."""

    def __init__(self, model, poses, T_root_camera, T_guess, prefix, camera=CAMERA):
        """T_guess: where tf has the camera, which is at T_root_camera."""
        self.model, self.T_root_camera = model, T_root_camera
        self.root, self.frame = prefix + model.root, prefix + OPTICAL
        self._prefix, self._T_guess = prefix, T_guess
        stand = box(np.array([0.9, 0.6, -FLOOR])).moved(at(0.2, 0.0, 0.5 * FLOOR))
        scene = ArmScene(model, camera, [*room(), stand])
        self._camera = camera
        self.poses = [dict(zip(model.movable, pose)) for pose in poses]
        self._images = []
        for i, pose in enumerate(self.poses):
            exact, _ = scene.exact(np.linalg.inv(T_root_camera), pose)
            draws = [np.random.default_rng((i, j)) for j in range(IMAGES)]
            self._images.append([measured_depth(exact, camera, draw) for draw in draws])

    def joints(self, number, stamp):
        """JointState of the pose of that number; so the others."""
        pose = self.poses[number]
        return JointState(header=self._header(stamp), name=list(pose), position=list(pose.values()))

    def info(self, stamp):
        size = self._camera.height, self._camera.width
        return to_camera_info(self._header(stamp), size, self._camera.intrinsics)

    def image(self, number, tick, stamp):
        return to_depth_image(self._header(stamp), self._images[number][tick % IMAGES])

    def transforms(self, number, stamp):
        header = Header(frame_id=self.root, stamp=stamp)
        T = self._T_guess
        return [
            to_transform(header, self.frame, T[:3, 3], T[:3, :3]),
            *(
                to_transform(header, self._prefix + link, T[:3, 3], T[:3, :3])
                for link, T in self.model.poses(self.poses[number]).items()
                if link != self.model.root
            ),
        ]

    def _header(self, stamp):
        return Header(frame_id=self.frame, stamp=stamp)


class ArmWorld(SeenArm):
    """The arm goes through its poses for as long as `run` runs; the world is the clock, or not."""

    def __init__(self, *args, clock=True):
        """As SeenArm."""
        super().__init__(*args)
        self.without = set()  # names of what is not published
        self.begin = 1000.0  # s of the clock's first tick
        self._clock = clock
        self._ticks, self._stop = 0, threading.Event()
        self._clock_pub = rospy.Publisher("/clock", Clock, queue_size=10) if clock else None
        self._tf_pub = rospy.Publisher("/tf", TFMessage, queue_size=10)
        self._image_pub = rospy.Publisher("depth/image_rect", Image, queue_size=10)
        self._info_pub = rospy.Publisher("depth/camera_info", CameraInfo, queue_size=10)
        self._joints_pub = rospy.Publisher("joint_states", JointState, queue_size=10)
        rospy.on_shutdown(self._stop.set)

    def run(self):
        """Until `stop`."""
        while not self._stop.wait(RATE if self._clock else TICK):
            self._tick()

    def stop(self):
        self._stop.set()

    def _tick(self):
        self._ticks += 1
        stamp = rospy.Time.from_sec(self.begin + TICK * self._ticks)
        if self._clock:
            self._clock_pub.publish(stamp)
        else:
            stamp = rospy.Time.now()
        number = self._ticks // HOLD % len(self.poses)
        if "tf" not in self.without:
            self._tf_pub.publish(self.transforms(number, stamp))
        if "joints" not in self.without:
            self._joints_pub.publish(self.joints(number, stamp))
        if "info" not in self.without:
            self._info_pub.publish(self.info(stamp))
        if "image" not in self.without:
            self._image_pub.publish(self.image(number, self._ticks, stamp))


def box_arm(T_tf_error=(0.08, 8.0)):
    """Of boxes, of the namespace robot1."""
    T = T_ROOT_CAMERA
    return ArmWorld(load_robot_model(ARM, {}), POSES, T, off(T, *T_tf_error), "robot1/")


def main():
    """A KUKA LBR iiwa, and what goes with it, in real time; tf is off, or right with `right`."""
    rospy.init_node("arm_world")
    urdf = find_urdf(IIWA)
    text = urdf.read_text().replace('filename="', f'filename="file://{urdf.parent}/')
    rospy.set_param("robot_description", text)
    T = looking_at(np.array([1.1, 0.9, 0.9]), np.array([0.0, 0.0, 0.5]))
    error = (0.0, 0.0) if "right" in sys.argv else (0.1, 8.0)
    world = ArmWorld(load_robot_model(urdf, {}), IIWA_POSES, T, off(T, *error), "", clock=False)
    world.run()


if __name__ == "__main__":
    main()
