"""The scan assembler under faults: no cloud with a hole, or with a line where it was not."""

from __future__ import annotations

import numpy as np
import rospy
import rotating_scanner
from rotating_scanner import LINES, PERIOD
from safe_passage.ros.sensor_conversions import cloud_grid
from scipy.spatial import cKDTree
from sensor_msgs.msg import JointState, LaserScan, PointCloud2
from tf2_msgs.msg import TFMessage

from bench.fault_subject import Input, Seen, Sent, Stated, Subject, of, silence

CLOUD = "rotating_scan/points"
NEAR = 0.1  # [m] of a point to the room: neighbouring lines are 0.6 m apart


class ScanAssemblerSubject(Subject):
    """The turning scanner in its room."""

    name = "scan_assembler"
    launch = "scan_segmentation.launch"
    arguments = ("joint:=platform",)
    frames = frozenset({"scanner"})
    tick, pause = PERIOD, 0.005
    recovery, judged = 5.0, 2.2  # a sweep takes 1.6 s

    def __init__(self) -> None:
        self.outputs = {CLOUD: PointCloud2}
        truth = [rotating_scanner.truth(number) for number in range(LINES)]
        self._room = cKDTree(np.concatenate(truth))
        lost, well = silence(CLOUD), Stated(self.healthy, told=False)
        # half the lines remain: too few for a cloud
        # and with a joint for the angle no tf is asked for the scan's frame
        scans = {"out of order": Stated(lost, told=True), "wrong frame": well}
        self.inputs = (
            Input("joints", "joint_states", JointState, _joint, 0.5, lost,
                  stated={"wrong frame": well}),
            Input("scan", "scan", LaserScan, _scan, 0.5, lost, stated=scans),
        )  # fmt: skip

    def healthy(self, seen: Seen) -> str:
        return "" if of(CLOUD, seen) else "no cloud"

    def wrong(self, seen: Seen, sent: list[Sent]) -> str:
        """A hole, or a point where nothing is."""
        del sent
        for cloud in of(CLOUD, seen):
            grid = cloud_grid(cloud)
            points = np.stack([grid[axis] for axis in "xyz"], axis=-1)
            if grid.shape[0] < LINES - 1:
                return f"a cloud of {grid.shape[0]} lines, not {LINES}"
            off, _ = self._room.query(points[np.isfinite(points).all(axis=-1)])
            if off.max() > NEAR:
                return f"a point {off.max():.2f} m off"
        return ""


class TfAssemblerSubject(ScanAssemblerSubject):
    """The same, with the angle of tf."""

    name, node = "scan_assembler_tf", "scan_assembler"
    arguments = ()

    def __init__(self) -> None:
        super().__init__()
        lost = silence(CLOUD)
        scans = {"out of order": Stated(lost, told=True)}
        # tf that moves must keep its own stamps: two that have changed places
        swapped = {"out of order": Swapped()}
        self.inputs = (
            Input("tf", "/tf", TFMessage, _tf, 0.5, lost, special=swapped),
            Input("scan", "scan", LaserScan, _scan, 0.5, lost, stated=scans),
        )


class Swapped:
    """Every second message is held back until the next is out."""

    def __init__(self) -> None:
        self._held: list = []

    def __call__(self, message: TFMessage, number: int) -> list:
        if number % 2 == 0:
            self._held = [message]
            return []
        return [message, *self._held]


def _tf(stamp: rospy.Time) -> TFMessage:
    return TFMessage([rotating_scanner.laser(_number(stamp), stamp)])


def _number(stamp: rospy.Time) -> int:
    return round(stamp.to_sec() / PERIOD)


def _joint(stamp: rospy.Time) -> JointState:
    return rotating_scanner.joint(_number(stamp), stamp)


def _scan(stamp: rospy.Time) -> LaserScan:
    return rotating_scanner.scan(_number(stamp), stamp)
