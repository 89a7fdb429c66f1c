"""Node simulation_report: sends the simulated robot to pallets and says how it went."""

from __future__ import annotations

import argparse
import math
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path

import actionlib
import numpy as np
import rospy
from actionlib_msgs.msg import GoalStatus
from move_base_msgs.msg import MoveBaseAction, MoveBaseFeedback, MoveBaseGoal

from safe_passage.core.errors import InputError
from safe_passage.core.geometry import Pose, compose, outline, placed
from safe_passage.msg import PersonArray
from safe_passage.ros.chain_report_node import ChainReport
from safe_passage.ros.conversions import planar_pose
from safe_passage.ros.simulation_conversions import to_quaternion
from safe_passage.simulation.worlds import load_world

SAFE_DISTANCE = 1.2  # [m] proxemics, paper 002, section 2.3
GAP = 0.10  # [m] wanted between robot and pallet
HALF_PALLET = 0.6  # [m]
POLL = rospy.Duration.from_sec(0.5)


@dataclass
class Trip:
    """One goal and what became of it."""

    pallet: Pose
    goal: Pose
    status: str = ""
    seconds: float = 0.0  # [s] of the simulation
    gap: float = math.nan  # [m] in the end
    nearest: float = math.inf  # [m] from the robot's outline to a person's middle


class SimulationReport:
    """Drives the trips and collects.

    Args:
        footprint: (N, 2) [m] of the robot.
    """

    def __init__(self, footprint: np.ndarray) -> None:
        self._footprint, self._outline = footprint, outline(footprint, 0.05)
        self._lock = threading.Lock()
        self._pose: Pose | None = None
        self._trip: Trip | None = None
        self._client = actionlib.SimpleActionClient("move_base", MoveBaseAction)
        rospy.Subscriber("warehouse_sim/persons", PersonArray, self._on_people, queue_size=5)

    def wait(self, seconds: float) -> None:
        """Until the navigator is there; InputError when it is not."""
        if not self._client.wait_for_server(rospy.Duration.from_sec(seconds)):
            raise InputError(f"no navigator on {rospy.resolve_name('move_base')}")

    def drive(self, trip: Trip, patience: float) -> None:
        """To the trip's goal; gives up after `patience` [s] of the simulation."""
        goal = MoveBaseGoal()
        goal.target_pose.header.frame_id = "map"
        goal.target_pose.header.stamp = start = rospy.Time.now()
        goal.target_pose.pose.position.x, goal.target_pose.pose.position.y = trip.goal[:2]
        goal.target_pose.pose.orientation = to_quaternion(trip.goal[2])
        with self._lock:
            self._trip = trip
        self._client.send_goal(goal, feedback_cb=self._on_feedback)
        while not self._client.wait_for_result(POLL):
            trip.seconds = (rospy.Time.now() - start).to_sec()
            self._show(trip)
            if trip.seconds > patience or rospy.is_shutdown():
                self._client.cancel_goal()
                break
        with self._lock:
            self._trip = None
            pose = self._pose
        trip.seconds = (rospy.Time.now() - start).to_sec()
        reached = self._client.get_state() == GoalStatus.SUCCEEDED
        trip.status = "reached" if reached else self._client.get_goal_status_text() or "given up"
        if pose:
            trip.gap = self._gap(pose, trip.pallet)
        print(f"\n    {trip.status} after {trip.seconds:.0f} s", file=sys.stderr, flush=True)

    def _on_feedback(self, feedback: MoveBaseFeedback) -> None:
        pose = feedback.base_position.pose
        with self._lock:
            self._pose = planar_pose(pose.position, pose.orientation)

    def _on_people(self, message: PersonArray) -> None:
        with self._lock:
            if self._trip is None or self._pose is None or not message.persons:
                return
            at = np.array([(p.position.x, p.position.y) for p in message.persons])
            apart = placed(self._outline, self._pose)[:, None] - at
            nearest = float(np.hypot(apart[..., 0], apart[..., 1]).min())
            self._trip.nearest = min(self._trip.nearest, nearest)

    def _gap(self, pose: Pose, pallet: Pose) -> float:
        """[m] from the pallet's face, which looks along its -x, to the robot."""
        corners = placed(self._footprint, pose) - np.array(pallet[:2])
        ahead = corners @ np.array([math.cos(pallet[2]), math.sin(pallet[2])])
        return float(-HALF_PALLET - ahead.max())

    def _show(self, trip: Trip) -> None:
        with self._lock:
            pose = self._pose
        if pose is None:
            return
        left = math.hypot(trip.goal[0] - pose[0], trip.goal[1] - pose[1])
        text = (
            f"    {trip.seconds:5.1f} s   {left:5.1f} m left   nearest person {trip.nearest:4.1f} m"
        )
        if sys.stderr.isatty():
            print("\r" + text, end="", file=sys.stderr, flush=True)
        elif int(trip.seconds) % 5 == 0:
            print(text, file=sys.stderr, flush=True)


def as_markdown(trips: list[Trip], chain: str, factor: float) -> str:
    """The report."""
    lines = [
        "## Trips",
        "",
        "| pallet at | goal | time [s] | gap to the pallet [m] | nearest person [m] |",
        "|---|---|---|---|---|",
    ]
    for trip in trips:
        near = f"{trip.nearest:.2f}" + ("" if trip.nearest >= SAFE_DISTANCE else " (under 1.2)")
        lines.append(
            f"| {trip.pallet[0]:.1f}, {trip.pallet[1]:.1f} | {trip.status} | {trip.seconds:.0f} | "
            f"{trip.gap:.2f} | {near} |"
        )
    lines += ["", f"## Topics, in simulated time ({factor:.2f} of real time)", "", chain, ""]
    return "\n".join(lines)


def plan_trips(world_file: str, near: list[tuple[float, float]], front: float) -> list[Trip]:
    """A trip to the pallet nearest to each of the places `near` (x, y) [m]."""
    pallets = load_world(Path(world_file)).pallets
    if not pallets:
        raise InputError(f"{world_file}: no pallet to drive to")
    trips = []
    for x, y in near:
        pallet = min(pallets, key=lambda p: math.hypot(p[0] - x, p[1] - y))
        trips.append(Trip(pallet, compose(pallet, (-HALF_PALLET - GAP - front, 0.0, 0.0))))
    return trips


def main() -> None:
    """Run the node; exit with 1 when a goal is not reached."""
    parser = argparse.ArgumentParser(prog="simulation_report", description=__doc__)
    parser.add_argument(
        "--near",
        type=_places,
        default="3.3,-4.2",
        metavar="X,Y;X,Y",
        help="[m] drive to the pallets nearest to these places, one after the other",
    )
    parser.add_argument("--patience", type=float, default=90.0, help="[s] for each of them")
    parser.add_argument("--report", help="write the report to this file too")
    args = parser.parse_args(rospy.myargv()[1:])
    rospy.init_node("simulation_report", anonymous=True)
    footprint = np.array(rospy.get_param("move_base/SimpleNavigator/footprint"))
    chain, report = ChainReport("move_base/local_costmap/costmap"), SimulationReport(footprint)
    trips = plan_trips(
        rospy.get_param("warehouse_sim/world"), args.near, float(footprint[:, 0].max())
    )
    silent = chain.wait_for_all(120.0)
    if silent:
        sys.exit("no message on: " + ", ".join(silent))
    report.wait(60.0)
    chain.start()
    started, wall = rospy.Time.now(), time.monotonic()
    for number, trip in enumerate(trips, 1):
        print(f"  trip {number} of {len(trips)}", file=sys.stderr, flush=True)
        report.drive(trip, args.patience)
    seconds = (rospy.Time.now() - started).to_sec()
    text = as_markdown(trips, chain.table(seconds), seconds / (time.monotonic() - wall))
    print(text)
    if args.report:
        Path(args.report).write_text(text)
    sys.exit(0 if all(trip.status == "reached" for trip in trips) else 1)


def _places(text: str) -> list[tuple[float, float]]:
    pairs = [place.split(",") for place in text.split(";")]
    return [(float(x), float(y)) for x, y in pairs]
