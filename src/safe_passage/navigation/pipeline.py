"""The navigator: goal, map, costmap and pose in, velocity out."""

from __future__ import annotations

import enum
import math

import numpy as np

from safe_passage.core.geometry import Pose, compose, inverse, placed
from safe_passage.core.grid import GridMap
from safe_passage.costmap.footprint import inscribed_radius
from safe_passage.navigation.global_planner import GlobalPlanner
from safe_passage.navigation.local_planner import LocalPlanner, Velocity
from safe_passage.navigation.memory import ObstacleMemory
from safe_passage.navigation.parameters import NavigatorParameters

PLAN_PERIOD = 1.0  # [s] people move: plan anew
NEAR_ENOUGH = 0.2  # [m] of the place where it turns to the goal's heading
MARGIN = 0.05  # [m] beyond the inscribed radius that the way keeps
NEAR_CELLS, FAR_CELLS = 10, 20  # [0.1 m] of the way that it faces: on its way, at the start
ASIDE, FACED = 0.6, 0.15  # [rad] off the way: turns on the spot from here, to here
STUCK = 3.0  # [s] at one place for longer, it goes where there is more room, once a period
ROOM_TIME, ROOM_PERIOD = 2.5, 8.0  # [s]
STEP, TURN = 0.05, 0.2  # [m], [rad] that are a move
TURN_GAIN = 1.5  # [1/s]


class State(enum.Enum):
    """What the robot is doing about its goal."""

    IDLE = "no goal"
    DRIVING = "driving"
    TURNING = "turning to the goal's heading"
    DOCKING = "driving the last stretch straight"
    WAITING = "waiting: the way is blocked"
    SUCCEEDED = "goal reached"
    ABORTED = "given up"


class Navigator:
    """Drives to a goal pose: to a place before it, turns, and goes the last stretch straight.

    Args:
        parameters: of robot and behaviour.
        static: the map.
    """

    def __init__(self, parameters: NavigatorParameters, static: GridMap) -> None:
        self.parameters = parameters
        self._static = static
        radius = inscribed_radius(np.array(parameters.footprint)) + MARGIN
        self.planner = GlobalPlanner(static, radius, parameters.area_cost)
        self._local = LocalPlanner(parameters)
        self._memory = ObstacleMemory(self.planner.static)
        self.state, self.goal = State.IDLE, (0.0, 0.0, 0.0)
        self._via, self._phase = self.goal, State.DRIVING
        self._planned, self._progress = -math.inf, _Progress()
        self._facing = self._looked = False

    def set_goal(self, goal: Pose) -> None:
        """Go to `goal`, frame map. ValueError when it is not finite."""
        if not all(map(math.isfinite, goal)):
            raise ValueError(f"goal {goal}: must be finite")
        self.goal, self.state, self._phase = goal, State.DRIVING, State.DRIVING
        self._via, self._looked = self._approach(goal), False
        self._planned, self._progress = -math.inf, _Progress()

    def cancel(self) -> None:
        """Forget the goal."""
        self.state = State.IDLE

    @property
    def active(self) -> bool:
        return self.state not in (State.IDLE, State.SUCCEEDED, State.ABORTED)

    def step(
        self, time: float, pose: Pose, now: Velocity, seen: GridMap, T_map_seen: Pose
    ) -> Velocity:
        """The velocity to drive from `time` [s] on.

        pose: robot in map; now: what it drives; seen: the costmap's lethal cells, in their own
        frame, which lies at T_map_seen in map.
        """
        if not self.active:
            return Velocity()
        p = self.parameters
        if time - self._planned >= PLAN_PERIOD or time < self._planned:
            now_seen = placed(seen.centres(), T_map_seen)
            self.planner.plan(self._via, self._memory.update(time, pose, now_seen))
            self._planned = time
        view = _View(pose, seen, compose(inverse(T_map_seen), pose), self._static, self.planner)
        wanted = {
            State.DRIVING: self._drive,
            State.TURNING: self._turn,
            State.DOCKING: self._dock,
        }[self._phase](pose, now, view)
        if not self.active:
            return Velocity()
        self.state = self._phase if wanted else State.WAITING
        if self._progress.lost_for(time, pose, float(view.cost(np.zeros((1, 2)))[0])) > p.patience:
            self.state = State.ABORTED
            return Velocity()
        if self._progress.must_make_room(time):
            return self._local.make_room(view.is_free) or Velocity()
        return wanted or Velocity()

    def _approach(self, goal: Pose) -> Pose:
        """Where it turns to the goal's heading: before the goal, if the map is free up to it."""
        back = self.parameters.approach_distance
        steps = [compose(goal, (-share * back, 0.0, 0.0)) for share in np.linspace(0.05, 1.0, 9)]
        corners = np.array(self.parameters.footprint)
        free = not self._static.at(placed(corners, np.array(steps)), outside=True).any()
        return steps[-1] if free and back > 0.0 else goal

    def _drive(self, pose: Pose, now: Velocity, view: _View) -> Velocity | None:
        if math.hypot(pose[0] - self._via[0], pose[1] - self._via[1]) < NEAR_ENOUGH:
            self._phase = State.TURNING
            return self._turn(pose, now, view)
        return self._face_the_way(pose, view) or self._local.choose(now, view.is_free, view.cost)

    def _face_the_way(self, pose: Pose, view: _View) -> Velocity | None:
        """Turn on the spot towards a way that leads aside: its camera must see where it drives."""
        way = self.planner.way(pose)[: NEAR_CELLS if self._looked else FAR_CELLS]
        if len(way) < NEAR_CELLS:
            self._facing = False
            return None
        dx, dy = way[-1] - pose[:2]
        error = math.remainder(math.atan2(dy, dx) - pose[2], 2.0 * math.pi)
        self._facing = abs(error) > (FACED if self._facing or not self._looked else ASIDE)
        turn = self._turn_rate(error)
        if not self._facing or not self._local.can_turn(turn, view.is_free):
            self._looked = True
            return None
        return Velocity(0.0, turn)

    def _turn(self, pose: Pose, now: Velocity, view: _View) -> Velocity | None:
        error = math.remainder(self._heading_to_goal(pose) - pose[2], 2.0 * math.pi)
        if abs(error) < self.parameters.yaw_tolerance and abs(now.turn) < 0.2:
            self._phase = State.DOCKING
            return self._dock(pose, now, view)
        turn = self._turn_rate(error)
        return Velocity(0.0, turn) if self._local.can_turn(turn, view.is_free) else None

    def _dock(self, pose: Pose, now: Velocity, view: _View) -> Velocity | None:
        p = self.parameters
        along, across, error = compose(inverse(pose), self.goal)
        along = math.cos(error) * along + math.sin(error) * across  # on the goal's own axis
        left = compose(inverse(self.goal), pose)[1]
        if along < 0.01:
            return self._finish(error, view)
        speed = min(math.sqrt(2.0 * 0.5 * p.acceleration * along), 0.4)
        steer = error - math.atan(2.0 * left)
        turn = self._turn_rate(steer)
        if self._local.free_way(speed, turn, 0.4, view.is_free):
            return Velocity(speed, turn)
        slow = 0.08  # [m/s] what is left may be less than a step at speed
        if self._local.free_way(slow, turn, 0.2, view.is_free):
            return Velocity(slow, turn)
        if along < p.xy_tolerance:
            return self._finish(error, view)
        return None

    def _finish(self, error: float, view: _View) -> Velocity | None:
        """At the goal's place: turn what is left, as far as there is room."""
        turn = self._turn_rate(error)
        done = abs(error) < self.parameters.yaw_tolerance
        if done or not self._local.can_turn(turn, view.is_free):
            self.state = State.SUCCEEDED
        return Velocity(0.0, turn)

    def _heading_to_goal(self, pose: Pose) -> float:
        """Towards the goal when it lies ahead of the turning place, else the goal's own."""
        dx, dy = self.goal[0] - pose[0], self.goal[1] - pose[1]
        far = self._via != self.goal and math.hypot(dx, dy) > 2.0 * NEAR_ENOUGH
        return math.atan2(dy, dx) if far else self.goal[2]

    def _turn_rate(self, error: float) -> float:
        rate = TURN_GAIN * error
        least = 0.08  # [rad/s] below it nothing moves
        rate = math.copysign(max(abs(rate), least), error)
        return float(np.clip(rate, -self.parameters.max_turn_rate, self.parameters.max_turn_rate))


class _Progress:
    """Tells dithering and waiting from getting on."""

    def __init__(self) -> None:
        self._place: Pose = (math.inf, 0.0, 0.0)
        self._arrived = self._gained = 0.0  # [s] at this place; when the cost last fell
        self._least = math.inf  # [m]
        self._room_end = self._room_next = -math.inf  # [s]

    def lost_for(self, time: float, pose: Pose, cost: float) -> float:
        """[s] since the robot last got nearer to its goal."""
        apart = math.hypot(pose[0] - self._place[0], pose[1] - self._place[1])
        turned = abs(math.remainder(pose[2] - self._place[2], 2.0 * math.pi))
        if apart > STEP or turned > TURN:
            self._place, self._arrived = pose, time
        if cost < self._least - STEP:
            self._least, self._gained = cost, time
        return time - self._gained

    def must_make_room(self, time: float) -> bool:
        """Whether it is stuck, or still on its way to more room because it was."""
        if time - self._arrived > STUCK and time >= self._room_next:
            self._room_end = time + ROOM_TIME
            self._room_next = time + ROOM_PERIOD
        return time < self._room_end


class _View:
    """Map, costmap and navigation function at points of the robot's frame."""

    def __init__(
        self, pose: Pose, seen: GridMap, pose_seen: Pose, static: GridMap, planner: GlobalPlanner
    ) -> None:
        self._pose, self._seen, self._pose_seen = pose, seen, pose_seen
        self._static, self._planner = static, planner

    def is_free(self, points: np.ndarray) -> np.ndarray:
        flat = points.reshape(-1, 2)
        taken = self._seen.at(placed(flat, self._pose_seen), outside=False)
        taken |= self._static.at(placed(flat, self._pose), outside=True)
        return ~taken.reshape(points.shape[:-1])

    def cost(self, points: np.ndarray) -> np.ndarray:
        flat = points.reshape(-1, 2)
        return self._planner.cost(placed(flat, self._pose)).reshape(points.shape[:-1])
