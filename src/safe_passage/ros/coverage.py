"""coverage: which part of a robot's surroundings how many of its sensors see."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Sequence

import numpy as np
import rospy
from geometry_msgs.msg import Vector3
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from safe_passage.core.errors import InputError, SafePassageError
from safe_passage.coverage.field import BANDS, Body, Coverage, bodies_of, cover, links_of
from safe_passage.coverage.report import COLOURS, as_markdown, draw, summary
from safe_passage.robot_model.robot import RobotModel, load_robot_model
from safe_passage.ros.markers import to_colour, to_marker, to_points
from safe_passage.ros.packages import package_folder
from safe_passage.simulation.arms import find_urdf
from safe_passage.simulation.robots import Robot, load_robot


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="coverage",
        description="Which part of a robot's surroundings how many of its sensors see, by height.",
    )
    parser.add_argument("robot", help="yaml as config/robots/*.yaml, or one of these by name")
    parser.add_argument("--urdf", type=Path, help="what hides the view: this, not the yaml's parts")
    parser.add_argument("--root-height", type=float, default=0.0, help="[m] of its root link")
    parser.add_argument("--joints", nargs="*", default=[], metavar="NAME=RAD", help="0 by default")
    parser.add_argument("--out", type=Path, help="folder for coverage.json and coverage.png")
    parser.add_argument("--rviz", action="store_true", help="publish markers until it is stopped")
    return parser.parse_args(arguments)


def examined(args: argparse.Namespace, config: Path) -> tuple[Robot, Coverage]:
    """The robot that the arguments name, and what it sees.

    Raises:
        SafePassageError: a file or joint is not usable.
    """
    named = config / "robots" / f"{args.robot}.yaml"
    robot = load_robot(named if named.is_file() else Path(args.robot).expanduser())
    return robot, cover(robot, _bodies(robot, args))


def _bodies(robot: Robot, args: argparse.Namespace) -> list[Body]:
    positions = _positions(args.joints)
    if args.urdf:
        model = load_robot_model(args.urdf, package_folder)
        T = np.eye(4)
        T[2, 3] = args.root_height
        return links_of(model, {**dict.fromkeys(model.movable, 0.0), **positions}, T)
    model_of_arm: RobotModel | None = None
    if robot.arm:
        model_of_arm = load_robot_model(find_urdf(robot.arm.urdf), package_folder)
    return bodies_of(robot, model_of_arm, positions)


def _positions(pairs: Sequence[str]) -> dict[str, float]:
    try:
        return {name: float(value) for name, _, value in (pair.partition("=") for pair in pairs)}
    except ValueError:
        raise InputError(f"--joints {' '.join(pairs)}: must be NAME=RAD, with a number") from None


def show(found: Coverage) -> None:
    """Latched markers in the robot's base frame, until the node is stopped."""
    rospy.init_node("coverage")
    frame = rospy.get_param("~base_frame", "base_footprint")
    publisher = rospy.Publisher("coverage", MarkerArray, queue_size=1, latch=True)
    publisher.publish(MarkerArray(to_markers(found, frame)))
    print(f"{rospy.resolve_name('coverage')}: markers in {frame}; Ctrl-C ends it")
    rospy.spin()


def to_markers(found: Coverage, frame: str) -> list[Marker]:
    """A layer of cubes for each band, at the middle of its height; a namespace each."""
    header, markers = Header(frame_id=frame), []
    for (name, (low, high)), count in zip(BANDS.items(), found.count):
        marker = to_marker(header, name, 0, Marker.CUBE_LIST, to_colour((1.0, 1.0, 1.0), 1.0))
        marker.lifetime = rospy.Duration(0)
        marker.scale = Vector3(found.resolution, found.resolution, 0.02)
        outside = ~found.inside
        marker.points = to_points(found.middles[outside], 0.5 * (low + high))
        colours = [_colour(n) for n in range(len(COLOURS))]
        last = len(COLOURS) - 1
        marker.colors = [colours[n] for n in np.minimum(count[outside], last).tolist()]
        markers.append(marker)
    return markers


def _colour(number: int) -> ColorRGBA:
    text = COLOURS[number].lstrip("#")
    red, green, blue = (int(text[i : i + 2], 16) / 255.0 for i in (0, 2, 4))
    return to_colour((red, green, blue), 0.5)


def main(arguments: Sequence[str], config: Path) -> int:
    """Run the command line; `config` is the package's folder of that name."""
    args = parse(arguments)
    try:
        robot, found = examined(args, config)
    except SafePassageError as error:
        print(f"coverage: {error}", file=sys.stderr)
        return 1
    figures = summary(found)
    print(as_markdown(robot.name, figures))
    if args.out:
        args.out.mkdir(parents=True, exist_ok=True)
        (args.out / "coverage.json").write_text(json.dumps(figures, indent=1) + "\n")
        draw(robot, found, args.out / "coverage.png")
        print(f"\n{args.out}: coverage.json, coverage.png")
    if args.rviz:
        show(found)
    return 0
