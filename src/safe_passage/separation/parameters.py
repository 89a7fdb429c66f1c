"""Parameters of the separation monitor: one flat set for the pipeline."""

from __future__ import annotations

from dataclasses import dataclass

from safe_passage.core.errors import ParameterError
from safe_passage.core.parameters import check_flag, check_range


@dataclass(frozen=True)
class SeparationParameters:
    """Frame: base, x forward, y left, origin on the floor under the robot."""

    footprint: tuple[tuple[float, float], ...] = ()  # [m] outline of the platform
    robot_radius: float = 0.0  # [m] of a round platform, in place of a footprint
    footprint_padding: float = 0.02  # [m] all around

    stationary_obstacles: bool = False  # keep away from what has never moved, too
    horizon: float = 3.0  # [s] that is looked ahead
    stop_horizon: float = 6.0  # [s] for which a place to stop at must stay clear
    step: float = 0.1  # [s] between two moments looked at

    agility: float = 0.1  # [m^2/s^3] noise of the prediction: speed changes by its root in a second
    sigmas: float = 1.0  # standard deviations by which a predicted shape is enlarged (Z_d)
    max_growth: float = 0.1  # [m] of a shape; of what is farther ahead more will be known in time
    body_radius: float = 0.3  # [m] of who walks: a foot that is farther ahead does not stay there
    human_speed: float = 1.6  # [m/s] towards the robot, of whom no speed is known
    max_speed_deviation: float = 1.2  # [m/s] a velocity that is less certain counts as not known
    worst_case: bool = False  # true: everybody may come at human_speed at any moment

    reaction_time: float = 0.3  # [s] from a measurement until the robot obeys (T_r)
    deceleration: float = 0.6  # [m/s^2] of the platform, at least
    acceleration: float = 0.5  # [m/s^2] of the platform, at least
    angular_deceleration: float = 1.0  # [rad/s^2] of a turn that begins or ends, at least
    min_distance: float = 0.3  # [m] kept from shapes: reach of an arm the sensors miss (C)
    robot_uncertainty: float = 0.03  # [m] of where the robot is and will be (Z_r)

    release_margin: float = 0.1  # [m] more than min_distance before the robot gets faster again
    release_time: float = 1.0  # [s] for which that must hold
    rise_rate: float = 1.0  # [1/s] by which the scale rises, at most
    escape_speed: float = 0.3  # [m/s] when it leaves what is nearer than min_distance
    escape_turn: float = 0.5  # [rad/s] the same of a turn
    cautious_speed: float = 0.2  # [m/s] where not a shape but only its growth would be too near
    tolerance: float = 0.05  # [m] by which a way out may come nearer on its way
    clearance: float = 0.07  # [m] of plain shapes where it drives on in somebody's way
    advantage: float = 0.1  # [m] more room by which driving on beats stopping in somebody's way

    path_tolerance: float = 0.5  # [m] a robot farther from its planned path has left it
    path_angle: float = 0.8  # [rad] a command that points so far off the path does not follow it

    tracks_timeout: float = 0.5  # [s] older tracks stop the robot
    odometry_timeout: float = 0.5  # [s] the same of odometry and tf
    command_timeout: float = 0.5  # [s] an older command is not repeated
    path_timeout: float = 3.0  # [s] an older path counts no more: the command is followed instead
    max_future: float = 0.1  # [s] messages stamped farther ahead are not believed
    settle_time: float = 1.5  # [s] a tracker needs after its start to know who moves

    def __post_init__(self) -> None:
        if self.footprint and len(self.footprint) < 3:
            raise ParameterError(f"footprint {self.footprint}: must have 3 points [x, y] or more")
        check_range("robot_radius", self.robot_radius, 0.0, 10.0, "m")
        if bool(self.footprint) == bool(self.robot_radius):
            raise ParameterError("footprint: give either it or robot_radius, one of the two")
        check_range("footprint_padding", self.footprint_padding, 0.0, 2.0, "m")
        check_flag("stationary_obstacles", self.stationary_obstacles)
        check_flag("worst_case", self.worst_case)
        check_range("step", self.step, 0.01, 1.0, "s")
        check_range("horizon", self.horizon, 2 * self.step, 20.0, "s")
        check_range("stop_horizon", self.stop_horizon, self.horizon, 60.0, "s")
        check_range("agility", self.agility, 0.0, 100.0, "m^2/s^3")
        check_range("sigmas", self.sigmas, 0.0, 10.0, "")
        check_range("max_growth", self.max_growth, 0.0, 10.0, "m")
        check_range("body_radius", self.body_radius, 0.05, 10.0, "m")
        check_range("human_speed", self.human_speed, 0.0, 10.0, "m/s")
        check_range("max_speed_deviation", self.max_speed_deviation, 0.01, 100.0, "m/s")
        check_range("reaction_time", self.reaction_time, 0.0, 5.0, "s")
        check_range("deceleration", self.deceleration, 0.01, 50.0, "m/s^2")
        check_range("acceleration", self.acceleration, 0.01, 50.0, "m/s^2")
        check_range("angular_deceleration", self.angular_deceleration, 0.01, 100.0, "rad/s^2")
        check_range("min_distance", self.min_distance, 0.0, 10.0, "m")
        check_range("robot_uncertainty", self.robot_uncertainty, 0.0, 5.0, "m")
        check_range("release_margin", self.release_margin, 0.0, 5.0, "m")
        check_range("release_time", self.release_time, 0.0, 60.0, "s")
        check_range("rise_rate", self.rise_rate, 0.01, 1000.0, "1/s")
        check_range("escape_speed", self.escape_speed, 0.01, 5.0, "m/s")
        check_range("cautious_speed", self.cautious_speed, 0.0, 5.0, "m/s")
        check_range("escape_turn", self.escape_turn, 0.01, 10.0, "rad/s")
        check_range("tolerance", self.tolerance, 0.0, 1.0, "m")
        check_range("clearance", self.clearance, 0.0, 5.0, "m")
        check_range("advantage", self.advantage, 0.0, 5.0, "m")
        check_range("path_tolerance", self.path_tolerance, 0.0, 10.0, "m")
        check_range("path_angle", self.path_angle, 0.0, 3.2, "rad")
        for timeout in ("tracks_timeout", "odometry_timeout", "command_timeout", "path_timeout"):
            check_range(timeout, getattr(self, timeout), 0.01, 60.0, "s")
        check_range("max_future", self.max_future, 0.0, 10.0, "s")
        check_range("settle_time", self.settle_time, 0.0, 60.0, "s")

    @property
    def kept(self) -> float:
        """[m] between the robot and a shape that is enlarged by its uncertainty: C + Z_r."""
        return self.min_distance + self.robot_uncertainty
