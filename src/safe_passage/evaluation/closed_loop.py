"""One closed-loop run: simulator, human safety chain and navigator (paper 002, Fig. 9)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Mapping

import numpy as np

from safe_passage.core.geometry import Pose, compose, inverse, placed
from safe_passage.evaluation.human_safety_chain import HumanSafetyChain
from safe_passage.evaluation.person_tracker import PersonTracker
from safe_passage.evaluation.scenarios import PALLET_LENGTH, Scenario
from safe_passage.evaluation.setting import TrackerSetting
from safe_passage.navigation import Navigator, NavigatorParameters, State
from safe_passage.navigation.local_planner import Velocity
from safe_passage.simulation.drive import Twist
from safe_passage.simulation.robots import CameraModel, Robot
from safe_passage.simulation.simulator import CameraFrame, Simulator
from safe_passage.simulation.truth import persons_in_view
from safe_passage.simulation.walkers import PersonState
from safe_passage.simulation.worlds import World

CONTROL_STEPS = 4  # simulator steps between two cycles of sensing, mapping and driving: 10 Hz
MOVING = 0.05  # [m/s] slower, the robot stands or turns on the spot
AT_PERSON = 0.5  # [m] from its place, a detection or an area is the person's
# What `RunResult.track` holds of each cycle: [s], [m], [rad], frame map; distance [m] from the
# robot's outline to the person's middle; share of the person that the camera sees, NaN without
# camera; whether the person was detected now; detections of nobody; whether it has a safety area
TRACK = (
    *("time", "x", "y", "yaw", "person_x", "person_y"),
    *("distance", "visible", "seen", "false", "remembered"),
)


@dataclass(frozen=True)
class RunResult:
    """What happened, from the simulator's truth."""

    kind: str
    method: str  # hog, yolo, none
    state: State
    seconds: float  # [s] until the goal or the end
    min_distance: float  # [m] from the robot's outline to a person's middle
    min_distance_moving: float  # [m] the same while the robot drove, for- or backwards
    pallet_gap: float  # [m] between the robot's front and the pallet in the end
    bumps: int  # steps that ended at an obstacle
    track: np.ndarray  # (N, 11), see TRACK

    @property
    def reached(self) -> bool:
        return self.state is State.SUCCEEDED

    def column(self, name: str) -> np.ndarray:
        """One of TRACK, (N,)."""
        return self.track[:, TRACK.index(name)]


def run_scenario(
    world: World,
    robot: Robot,
    scenario: Scenario,
    method: str,
    costmap: Mapping[str, Any],
    navigator: NavigatorParameters,
    hold_time: float,
    seed: int,
    most_seconds: float = 120.0,
    detect_every: int = 1,
    tracker: TrackerSetting | None = None,
) -> RunResult:
    """Run `scenario` to its end.

    Args:
        method: hog, yolo, or none for no safety areas.
        hold_time: [s] that a person is remembered after the last detection.
        most_seconds: [s] of simulated time.
        detect_every: cycles, of which there are ten a second, the camera is looked at.
        tracker: of the persons whom the camera no longer sees; None: none runs.
    """
    simulator = Simulator(world, robot, seed, scenario.people, scenario.start)
    persons = PersonTracker(*tracker) if tracker else None
    chain = HumanSafetyChain(method, costmap, hold_time, robot.footprint, persons)
    driver = Navigator(navigator, simulator.map)
    driver.set_goal(scenario.goal)
    lidar, camera = robot.lidars[0], robot.cameras[0]
    track: list[tuple] = []
    bumps = 0
    found, visible = np.empty((0, 2)), math.nan
    nearest = nearest_moving = math.inf
    try:
        while driver.active and simulator.time < most_seconds:
            time, base = simulator.time, simulator.base
            if method != "none" and len(track) % detect_every == 0:
                frame = simulator.frame(camera)
                found = chain.see(frame.depth, frame.bgr, camera, base.odometry, time)
                visible = visible_share(simulator, frame, camera)
            scan = simulator.scan(lidar).ranges
            chain.hear(scan, lidar, base.odometry, time)
            ranges = chain.merge(scan, lidar, base.odometry, time)
            obstacles = chain.update(ranges, lidar, base.odometry, time)
            T_map_odom = compose(base.pose, inverse(base.odometry))
            now = Velocity(base.twist.forward, base.twist.turn)
            wanted = driver.step(time, base.pose, now, obstacles, T_map_odom)
            simulator.command(Twist(wanted.forward, 0.0, wanted.turn))
            person = simulator.people()[0]
            seen = _at(person, placed(found, T_map_odom))
            kept = _at(person, placed(chain.remembered, T_map_odom)).any()
            distance = simulator.distance_to_people()
            judged = (distance, visible, seen.any(), (~seen).sum(), kept)
            track.append((time, *base.pose, person.x, person.y, *judged))
            for step in range(CONTROL_STEPS):
                simulator.step()
                if tracker and step < CONTROL_STEPS - 1:  # else nobody asks
                    between = simulator.scan(lidar).ranges
                    chain.hear(between, lidar, base.odometry, simulator.time)
                bumps += base.bumped
                distance = simulator.distance_to_people()
                nearest = min(nearest, distance)
                if abs(base.twist.forward) > MOVING:
                    nearest_moving = min(nearest_moving, distance)
        gap = pallet_gap(simulator.base.pose, navigator, scenario.pallet)
    finally:
        simulator.close()
    return RunResult(
        scenario.kind,
        method,
        driver.state,
        simulator.time,
        nearest,
        nearest_moving,
        gap,
        bumps,
        np.array(track, float).reshape(-1, len(TRACK)),
    )


def _at(person: PersonState, places: np.ndarray) -> np.ndarray:
    """Which of `places` (N, 2) [m], frame map, are the person's: (N,) bool."""
    return np.hypot(*(places - (person.x, person.y)).T) <= AT_PERSON


def visible_share(simulator: Simulator, frame: CameraFrame, camera: CameraModel) -> float:
    """Of the first person, from the truth; 0 when it is not in the picture."""
    bodies, states = tuple(simulator.bodies), simulator.people()
    truth = persons_in_view(frame.exact, frame.T_map_camera, camera, bodies, states)
    return next((person.visible for person in truth if person.id == 0), 0.0)


def pallet_gap(pose: Pose, navigator: NavigatorParameters, pallet: Pose) -> float:
    """[m] from the pallet's face to the nearest of the robot's front corners."""
    corners = np.array(navigator.footprint)
    front = corners[corners[:, 0] == corners[:, 0].max()]
    at = [compose(inverse(pallet), compose(pose, (x, y, 0.0)))[0] for x, y in front]
    return -0.5 * PALLET_LENGTH - max(at)
