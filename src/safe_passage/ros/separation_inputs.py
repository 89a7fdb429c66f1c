"""What the separation monitor takes in: the newest tracks, path, odometry, command, and tf."""

from __future__ import annotations

import math
import threading
import time
from dataclasses import dataclass
from typing import Any, Callable

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry, Path

from safe_passage.core.geometry import Pose
from safe_passage.msg import TrackedObstacleArray
from safe_passage.ros.diagnostics import NodeDiagnostics, Outcome
from safe_passage.ros.sensor_conversions import UnusableMessageError
from safe_passage.ros.separation_conversions import (
    ages_of,
    frame_pose,
    planar,
    silent_sensors,
    to_obstacles,
    to_path,
    to_velocity,
)
from safe_passage.ros.separation_parameters import SeparationNodeParameters
from safe_passage.separation import Inputs, Obstacles, Part, RobotState, Supervisor, carried_on
from safe_passage.separation.failsafe import SLACK
from safe_passage.separation.robot_motion import Velocity

STILL = (0.0, 0.0, 0.0)
WAKES = ("tracks", "cmd_vel_in")  # topics that make a cycle at once


@dataclass(frozen=True)
class Last:
    """The newest message of a topic."""

    stamp: rospy.Time
    frame: str
    content: Any


@dataclass(frozen=True)
class Tracked:
    """What a message of tracks says."""

    obstacles: Obstacles
    ages: np.ndarray  # (N,) [s] of the obstacles
    silent: list[str]  # sensors that should be alive


class SeparationInputs:
    """All topics and tf; threads of ROS put in, the node takes out."""

    def __init__(
        self,
        parameters: SeparationNodeParameters,
        diagnostics: NodeDiagnostics,
        supervisor: Supervisor,
    ) -> None:
        self._p, self._diagnostics, self._supervisor = parameters, diagnostics, supervisor
        self._news = threading.Condition()
        self._woken: float | None = None  # [s] monotonic, when the first news came
        self._tf = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._tf)
        self._last: dict[str, Last] = {}
        self._judged: Last | None = None
        self.detail = ""  # what is missing, for people
        kinds = (
            ("tracks", TrackedObstacleArray, self._read_tracks),
            ("odom", Odometry, self._read_odometry),
            ("plan", Path, lambda path: path),
            ("cmd_vel_in", Twist, planar),
        )
        self._topics = {name: rospy.resolve_name(name) for name, _, _ in kinds}
        for topic in self.awaited:
            diagnostics.expect(topic)
        self._subscribers = [
            rospy.Subscriber(
                name, kind, self._receive, (name, read), queue_size=1, tcp_nodelay=True
            )
            for name, kind, read in kinds
        ]
        rospy.on_shutdown(self._wake)

    def tune(self, parameters: SeparationNodeParameters) -> None:
        """Other parameters from now on; what has come in stays."""
        self._p = parameters

    @property
    def awaited(self) -> list[str]:
        """Resolved names of the topics without which the robot stands."""
        return [self._topics["tracks"], self._topics["odom"]]

    def wait(self, timeout: float) -> float:
        """Until tracks or a command have come, or `timeout` [s of wall time] is over.

        Returns when that came [s, monotonic].
        """
        with self._news:
            self._news.wait_for(lambda: self._woken is not None, timeout)
            woken, self._woken = self._woken, None
        return woken or time.monotonic()

    def restart(self) -> None:
        """Forget everything."""
        self._tf.clear()
        with self._news:
            self._last.clear()

    def command(self, now: rospy.Time) -> tuple[Velocity | None, float]:
        """The last command, None once it is too old, and its age [s]."""
        last = self._newest("cmd_vel_in")
        age = (now - last.stamp).to_sec() if last else float("inf")
        return (last.content if last and age <= self._p.command_timeout else None), age

    def inputs(self, now: rospy.Time) -> Inputs:
        """What there is, to be judged."""
        tracks, odometry = self._newest("tracks"), self._newest("odom")
        silent: list[str] = []
        if tracks is not None:
            silent = tracks.content.silent
            if tracks is not self._judged:
                ids, ages = tracks.content.obstacles.id, tracks.content.ages
                self._supervisor.saw_tracks(tracks.stamp.to_sec(), ids, ages)
                self._judged = tracks
        self.detail, placed = ", ".join(silent), True
        try:
            self._latest(now)
            self._arm(now)
        except tf2_ros.TransformException as error:
            placed, self.detail = False, str(error)
        return Inputs(
            now.to_sec(),
            tracks.stamp.to_sec() if tracks else None,
            odometry.stamp.to_sec() if odometry else None,
            placed,
            not silent,
        )

    def robot(self, now: rospy.Time) -> RobotState:
        """Its motion, its way if that is young and tf can place it, its arm."""
        odometry = self._newest("odom")
        parts, latest = self._arm(now), self._latest(now)
        return RobotState(odometry.content if odometry else STILL, self._way(now, latest), parts)

    def obstacles(self, now: rospy.Time) -> Obstacles:
        """As they are now, frame base; TransformException if tf does not know their frame."""
        last, latest, base = self._newest("tracks"), self._latest(now), self._p.base_frame
        assert last is not None, "asked before there are tracks"
        moved: Pose = STILL  # of base since then, as far as tf knows it
        if last.frame != base or latest > last.stamp:
            moved = self._between(last.frame, last.stamp, base, latest)
        age = (now - last.stamp).to_sec()
        return carried_on(last.content.obstacles, age, moved, self._p)

    def _way(self, now: rospy.Time, latest: rospy.Time):
        """(K, 2) [m] or, with headings, (K, 3) [m, rad] base, or None."""
        last = self._newest("plan")
        if last is None or (now - last.stamp).to_sec() > self._p.path_timeout:
            return None
        try:
            T_base_path = self._between(self._p.base_frame, latest, last.frame, last.stamp)
            return to_path(last.content, T_base_path, self._p.path_orientations)
        except tf2_ros.TransformException as error:
            self._diagnostics.count(self._topics["plan"], Outcome.NO_TF, str(error))
            return None

    def _between(self, frame: str, stamp: rospy.Time, other: str, other_stamp: rospy.Time) -> Pose:
        """Pose of frame `other` at its stamp in `frame` at its own; what stands still is odom."""
        fixed = self._p.odom_frame
        return frame_pose(self._tf.lookup_transform_full(frame, stamp, other, other_stamp, fixed))

    def _latest(self, now: rospy.Time) -> rospy.Time:
        """The newest time at which tf knows where the robot is."""
        odom, base = self._p.odom_frame, self._p.base_frame
        found = self._tf.lookup_transform(odom, base, rospy.Time()).header.stamp
        self._check_age(found, now, f"{odom} -> {base}")
        return now if found.is_zero() else found  # zero: a robot that is fixed

    def _check_age(self, stamp: rospy.Time, now: rospy.Time, frames: str) -> None:
        """Raise TransformException if the newest transform is too old.

        Or ahead: behind that, tf would keep it as the newest whatever comes, or comes no more.
        """
        age = (now - stamp).to_sec()
        if not stamp.is_zero() and not -self._p.max_future <= age <= self._p.odometry_timeout:
            raise tf2_ros.ExtrapolationException(f"{frames} is {age:.2f} s old")

    def _arm(self, now: rospy.Time) -> list[Part]:
        """Capsules from each of the arm's frames to the next, or a disc at the only one."""
        base, places = self._p.base_frame, []
        for joint in self._p.arm_frames:
            found = self._tf.lookup_transform(base, joint.frame, rospy.Time())
            self._check_age(found.header.stamp, now, f"{base} -> {joint.frame}")
            places.append((frame_pose(found)[:2], joint.radius))
        pairs = list(zip(places, places[1:])) or [(place, place) for place in places]
        return [Part(a, b, max(wide, narrow)) for (a, wide), (b, narrow) in pairs]

    def _newest(self, name: str) -> Last | None:
        with self._news:
            return self._last.get(name)

    def _receive(self, message: Any, how: tuple[str, Callable[[Any], Any]]) -> None:
        name, read = how
        now, header = rospy.Time.now(), getattr(message, "header", None)
        stamp = header.stamp if header and not header.stamp.is_zero() else now
        try:
            if header:
                self._check(name, header.frame_id, stamp, now)
            content = read(message)
        except UnusableMessageError as error:
            self._diagnostics.count(self._topics[name], error.outcome, str(error))
            return
        self._diagnostics.count(self._topics[name], Outcome.OK)
        with self._news:
            self._last[name] = Last(stamp, header.frame_id if header else "", content)
        if name in WAKES:
            self._wake()

    def _check(self, name: str, frame: str, stamp: rospy.Time, now: rospy.Time) -> None:
        """Raise UnusableMessageError: without frame, from the future, old, behind the last."""
        age, last = (now - stamp).to_sec(), self._newest(name)
        timeouts = {"tracks": self._p.tracks_timeout, "odom": self._p.odometry_timeout}
        if not frame:
            raise UnusableMessageError(Outcome.BAD_FIELDS, "no frame_id")
        if -age > self._p.max_future:
            raise UnusableMessageError(Outcome.FUTURE, f"{-age:.3f} s ahead")
        if age > timeouts.get(name, age):
            raise UnusableMessageError(Outcome.STALE, f"{age:.3f} s old")
        # far behind the last are a new tracker's, which the supervisor judges
        if last and 0.0 < (last.stamp - stamp).to_sec() < SLACK:
            raise UnusableMessageError(Outcome.OUT_OF_ORDER, "behind the last")

    def _read_tracks(self, array: TrackedObstacleArray) -> Tracked:
        silent = silent_sensors(array, self._p.optional_sensors)
        return Tracked(to_obstacles(array), ages_of(array), silent)

    def _read_odometry(self, odometry: Odometry) -> Velocity:
        """Of base, whatever frame of the robot it is told of; none told: of base."""
        forward, left, turn = to_velocity(odometry)
        base, child = self._p.base_frame, odometry.child_frame_id or self._p.base_frame
        if child == base:
            return forward, left, turn
        try:
            x, y, yaw = frame_pose(self._tf.lookup_transform(base, child, rospy.Time()))
        except tf2_ros.TransformException as error:
            raise UnusableMessageError(Outcome.NO_TF, f"of {child}: {error}") from error
        ahead = math.cos(yaw) * forward - math.sin(yaw) * left
        aside = math.sin(yaw) * forward + math.cos(yaw) * left
        return ahead + turn * y, aside - turn * x, turn

    def _wake(self) -> None:
        with self._news:
            self._woken = self._woken or time.monotonic()
            self._news.notify_all()
