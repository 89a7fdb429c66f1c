"""Stands in for move_base: its action and topics, our navigator, our local costmap."""

from __future__ import annotations

import threading

import actionlib
import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import PoseStamped, Twist
from move_base_msgs.msg import MoveBaseAction, MoveBaseActionGoal, MoveBaseFeedback, MoveBaseGoal
from nav_msgs.msg import OccupancyGrid, Odometry, Path

from safe_passage.core.errors import ParameterError, shown
from safe_passage.core.geometry import Pose, compose, inverse
from safe_passage.core.grid import GridMap
from safe_passage.core.parameters import from_mapping
from safe_passage.costmap import CostmapUpdate
from safe_passage.costmap.costs import LETHAL_OBSTACLE
from safe_passage.navigation import Navigator, NavigatorParameters, State
from safe_passage.navigation.global_planner import GlobalPlanner
from safe_passage.navigation.local_planner import Velocity
from safe_passage.ros.actions import forget_goals, survive_clock_jumps
from safe_passage.ros.clock import JumpDetector
from safe_passage.ros.conversions import planar_pose, to_header
from safe_passage.ros.costmap_node import CostmapNode
from safe_passage.ros.simulation_conversions import to_quaternion

PARAMETERS = "~SimpleNavigator"
MAP_OCCUPIED = 65  # from this occupancy on a cell of the map is an obstacle, as in map_server
STALE = 0.5  # [s] odometry older than this stops the robot


class SimpleNavigatorNode:
    """Drives after each update of the costmap; without update, pose or odometry it does not."""

    def __init__(self, costmap_namespace: str) -> None:
        values = rospy.get_param(PARAMETERS, {})
        self._parameters = from_mapping(
            NavigatorParameters, _as_tuples(values), rospy.resolve_name(PARAMETERS)
        )
        self._lock = threading.Lock()
        self._navigator: Navigator | None = None
        self._map_frame = "map"
        self._twist, self._twist_stamp = Velocity(), rospy.Time()
        self._command_pub = rospy.Publisher("cmd_vel", Twist, queue_size=1)
        self._plan_pub = rospy.Publisher("~plan", Path, queue_size=1)
        self._goal_pub = rospy.Publisher("~current_goal", PoseStamped, queue_size=1, latch=True)
        self._costmap = CostmapNode(costmap_namespace, self._on_costmap)
        self._server = actionlib.SimpleActionServer(
            rospy.get_name(), MoveBaseAction, auto_start=False
        )
        self._server.register_goal_callback(self._on_goal)
        self._server.register_preempt_callback(self._on_preempt)
        self._relay = rospy.Publisher(rospy.get_name() + "/goal", MoveBaseActionGoal, queue_size=1)
        rospy.Subscriber("map", OccupancyGrid, self._on_map, queue_size=1)
        rospy.Subscriber("odom", Odometry, self._on_odometry, queue_size=1)
        rospy.Subscriber("move_base_simple/goal", PoseStamped, self._on_simple_goal, queue_size=1)
        rospy.on_shutdown(self._stop)
        self._server.start()
        survive_clock_jumps(self._server)
        self._jumps = JumpDetector()
        rospy.loginfo(f"simple navigator waits for {rospy.resolve_name('map')} and for a goal")

    def spin(self) -> None:
        """The costmap's cycle is the navigator's too."""
        self._costmap.spin()

    def _on_map(self, message: OccupancyGrid) -> None:
        info = message.info
        cells = np.array(message.data, np.int8).reshape(info.height, info.width)
        origin = (info.origin.position.x, info.origin.position.y)
        unknown_or_full = (cells < 0) | (cells >= MAP_OCCUPIED)
        grid = GridMap(unknown_or_full, origin, info.resolution)
        with self._lock:
            goal = self._navigator.goal if self._navigator and self._navigator.active else None
            self._map_frame = message.header.frame_id
            self._navigator = Navigator(self._parameters, grid)
            if goal:
                self._navigator.set_goal(goal)

    def _on_odometry(self, message: Odometry) -> None:
        twist = message.twist.twist
        with self._lock:
            self._twist = Velocity(twist.linear.x, twist.angular.z)
            self._twist_stamp = message.header.stamp

    def _on_simple_goal(self, message: PoseStamped) -> None:
        """A goal without an answer, as from rviz: becomes one of the action's."""
        goal = MoveBaseActionGoal(goal=MoveBaseGoal(target_pose=message))
        goal.header.stamp = rospy.Time.now()
        goal.goal_id.stamp = goal.header.stamp
        goal.goal_id.id = f"{rospy.get_name()}-{goal.header.stamp}"
        self._relay.publish(goal)

    def _on_goal(self) -> None:
        goal = self._server.accept_new_goal().target_pose
        try:
            pose = self._in_map(goal)
            with self._lock:
                if self._navigator is None:
                    raise ValueError(f"no map on {rospy.resolve_name('map')} yet")
                self._navigator.set_goal(pose)
        except (ValueError, tf2_ros.TransformException) as error:
            rospy.logerr(f"goal refused: {error}")
            self._server.set_aborted(text=str(error))
            return
        self._goal_pub.publish(goal)

    def _in_map(self, goal: PoseStamped) -> Pose:
        """A goal is a place: its frame's newest transform will do."""
        frame, timeout = goal.header.frame_id, rospy.Duration.from_sec(0.5)
        found = self._costmap.tf.lookup_transform(self._map_frame, frame, rospy.Time(), timeout)
        T_map_frame = planar_pose(found.transform.translation, found.transform.rotation)
        return compose(T_map_frame, planar_pose(goal.pose.position, goal.pose.orientation))

    def _on_preempt(self) -> None:
        with self._lock:
            if self._navigator:
                self._navigator.cancel()
        self._stop()
        self._server.set_preempted()

    def _on_costmap(self, update: CostmapUpdate, pose: Pose, now: rospy.Time) -> None:
        """Drive on; no call of the action server is made under our lock, for it has its own."""
        if self._jumps.jumped_back(now):
            self._forget_goal()
        with self._lock:
            if self._navigator is None or not self._navigator.active:
                return
            in_map = self._pose_in_map(now)
            silent = (now - self._twist_stamp).to_sec() > STALE
            if in_map is not None and not silent:
                seen = GridMap(update.costs == LETHAL_OBSTACLE, update.origin, update.resolution)
                T_map_seen = compose(in_map, inverse(pose))
                velocity = self._navigator.step(now.to_sec(), in_map, self._twist, seen, T_map_seen)
                state, planner = self._navigator.state, self._navigator.planner
        if silent:
            rospy.logwarn_throttle(5.0, f"no odometry on {rospy.resolve_name('odom')}: stopped")
        if in_map is None or silent:
            self._stop()
            return
        self._drive(velocity)
        self._report(state, planner, in_map, now)

    def _forget_goal(self) -> None:
        """After a clock jump: the server would take every new goal for older than the last."""
        rospy.logwarn("the clock went back: the goal is given up")
        with self._lock:
            if self._navigator:
                self._navigator.cancel()
            self._twist_stamp = rospy.Time()
        self._stop()
        if self._server.is_active():
            self._server.set_aborted(text="the clock went back")
        forget_goals(self._server)

    def _pose_in_map(self, now: rospy.Time) -> Pose | None:
        base = self._costmap.base_frame
        try:
            found = self._costmap.tf.lookup_transform(self._map_frame, base, rospy.Time())
        except tf2_ros.TransformException as error:
            rospy.logwarn_throttle(5.0, f"robot not in {self._map_frame}: {error}; stopped")
            return None
        if (now - found.header.stamp).to_sec() > STALE:
            rospy.logwarn_throttle(5.0, f"tf {self._map_frame} -> {base} is old: stopped")
            return None
        return planar_pose(found.transform.translation, found.transform.rotation)

    def _drive(self, velocity: Velocity) -> None:
        message = Twist()
        message.linear.x, message.angular.z = velocity.forward, velocity.turn
        self._command_pub.publish(message)

    def _stop(self) -> None:
        self._command_pub.publish(Twist())

    def _report(self, state: State, planner: GlobalPlanner, pose: Pose, now: rospy.Time) -> None:
        """Feedback, the way, and the end."""
        self._server.publish_feedback(MoveBaseFeedback(_stamped(pose, self._map_frame, now)))
        if self._plan_pub.get_num_connections():
            path = Path(header=to_header(now, self._map_frame))
            path.poses = [_stamped((x, y, 0.0), self._map_frame, now) for x, y in planner.way(pose)]
            self._plan_pub.publish(path)
        if not self._server.is_active():
            return
        if state is State.SUCCEEDED:
            self._server.set_succeeded(text=state.value)
        elif state is State.ABORTED:
            self._server.set_aborted(text=f"{state.value}, {State.WAITING.value}")


def _stamped(pose: Pose, frame: str, stamp: rospy.Time) -> PoseStamped:
    message = PoseStamped(header=to_header(stamp, frame))
    message.pose.position.x, message.pose.position.y = pose[:2]
    message.pose.orientation = to_quaternion(pose[2])
    return message


def _as_tuples(values: dict) -> dict:
    """Lists of the parameter server as the dataclass has them."""
    footprint = values.get("footprint")
    if footprint is None:
        return values
    try:
        return {**values, "footprint": tuple((float(x), float(y)) for x, y in footprint)}
    except (TypeError, ValueError):
        raise ParameterError(
            f"parameter {rospy.resolve_name(PARAMETERS)}/footprint is {shown(footprint)}, "
            "must be a list of [x, y] in m"
        ) from None
