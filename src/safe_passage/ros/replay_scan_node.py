"""Command `replay_scan`: a 3D scan of a file, or an analytic place, as a scanner's cloud."""

from __future__ import annotations

import argparse
from pathlib import Path

import actionlib
import numpy as np
import rospy
import tf2_ros
from sensor_msgs.msg import PointCloud2

from safe_passage.evaluation.segmentation_places import garage, hallway
from safe_passage.msg import ScanSegmentation, SegmentScanAction, SegmentScanGoal
from safe_passage.ros.conversions import to_header, to_transform
from safe_passage.ros.scan_conversions import to_scan_cloud, unit
from safe_passage.scan_segmentation.assembling import Assembled
from safe_passage.scan_segmentation.organise import organise
from safe_passage.scan_segmentation.reading import read_cloud
from safe_passage.scan_segmentation.scan import Level, OrganisedScan, axis_rotation
from safe_passage.simulation.scan_scene import Scanner, scan_place

PLACES = {"garage": garage, "hallway": hallway}
SEED = 3
HEIGHT = 1.2  # [m] of the scanner over the floor, of places


def main() -> None:
    """Publish once, latched, and ask for the result as soon as the server is there."""
    rospy.init_node("replay_scan")
    args = _parser().parse_args(rospy.myargv()[1:])
    scan = _scan(args)
    header = to_header(rospy.Time.now(), args.frame)
    cloud = to_scan_cloud(
        header, Assembled(scan, np.repeat(scan.beta[:, None], scan.points.shape[1], 1), 0.0, 0.0)
    )
    broadcaster = tf2_ros.StaticTransformBroadcaster()
    level = to_header(header.stamp, args.level_frame)
    turn = Level.of(scan).R_level_scan
    broadcaster.sendTransform(to_transform(level, args.frame, np.array([0, 0, HEIGHT]), turn))
    publisher = rospy.Publisher("rotating_scan/points", PointCloud2, queue_size=1, latch=True)
    publisher.publish(cloud)
    rospy.loginfo(f"{args.what}: {cloud.height} lines of {cloud.width} points on {publisher.name}")
    client = actionlib.SimpleActionClient(
        "scan_segmentation_server/segment_scan", SegmentScanAction
    )
    client.wait_for_server()
    while not rospy.is_shutdown():
        client.send_goal_and_wait(SegmentScanGoal(cloud=cloud))
        answer = client.get_result().segmentation
        rospy.loginfo(answer.text)
        if answer.reason != ScanSegmentation.NO_TF:
            break  # else the server has not heard of the frame yet
    rospy.spin()


def _scan(args: argparse.Namespace) -> OrganisedScan:
    if args.what in PLACES:
        scanner = Scanner(position=(0.0, 0.0, HEIGHT), pitch=args.pitch)
        return scan_place(PLACES[args.what](), scanner, SEED)[0]
    cloud = read_cloud(Path(args.what))
    return about_z(organise(cloud, unit(args.up), args.axis and unit(args.axis)))


def about_z(scan: OrganisedScan) -> OrganisedScan:
    """The same in a frame with z along the axis and its origin in the scanner."""
    R = axis_rotation(scan.axis)
    points = ((scan.points - np.array(scan.origin)) @ R.T).astype(np.float32)
    return OrganisedScan(points, scan.beta, scan.remission, up=unit(R @ np.array(scan.up)))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="replay_scan", description=__doc__)
    add = parser.add_argument
    add("what", nargs="?", default="garage", help=f"a file with a scan, or {', '.join(PLACES)}")
    add("--up", type=float, nargs=3, default=(0, 0, 1), metavar=("X", "Y", "Z"))
    add("--axis", type=float, nargs=3, metavar=("X", "Y", "Z"), help="of the rotation")
    add("--pitch", type=float, default=0.0, help="[rad] of the scanner in a place")
    add("--frame", default="scanner", help="of the cloud")
    add("--level-frame", default="odom", help="whose z is up")
    return parser
