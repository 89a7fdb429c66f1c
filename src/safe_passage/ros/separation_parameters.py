"""Private parameters of node `separation_monitor`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping

from safe_passage.core.parameters import check_flag, check_range, check_text
from safe_passage.core.reading import build, build_list
from safe_passage.separation import SeparationParameters

LIVE = (  # may be changed while it runs; not the robot's shape, frames, or what is waited for
    "footprint_padding", "stationary_obstacles", "horizon", "stop_horizon", "agility", "sigmas",
    "max_growth", "body_radius", "human_speed", "max_speed_deviation", "worst_case",
    "reaction_time", "deceleration", "acceleration", "angular_deceleration", "min_distance",
    "robot_uncertainty", "release_margin", "release_time", "rise_rate", "escape_speed",
    "escape_turn", "cautious_speed", "tolerance", "clearance", "advantage", "path_tolerance",
    "path_angle", "path_orientations", "tracks_timeout", "odometry_timeout", "command_timeout",
    "path_timeout", "settle_time", "stop_repeat", "debug_rate",
)  # fmt: skip


@dataclass(frozen=True)
class ArmFrame:
    """A frame on the arm; from one to the next reaches a capsule, as seen from above."""

    frame: str  # of tf
    radius: float = 0.1  # [m] of the arm there

    def __post_init__(self) -> None:
        check_text("frame", self.frame)
        check_range("radius", self.radius, 0.0, 2.0, "m")


@dataclass(frozen=True)
class SeparationNodeParameters(SeparationParameters):
    """The monitor's, and the node's own."""

    odom_frame: str = "odom"  # in which the robot's motion is known
    base_frame: str = "base_footprint"  # of the robot, on the floor
    arm_frames: tuple[ArmFrame, ...] = ()  # from the shoulder to the hand; none: no arm
    optional_sensors: tuple[str, ...] = ()  # of the tracks, that may be silent; all others stop it
    path_orientations: bool = False  # the path's poses have the robot's heading, as TEB's do
    control_rate: float = 20.0  # [Hz] of cycles at least; tracks and commands make more of them
    stop_repeat: float = 1.0  # [s] of commanding 0 once commands have ceased; then silence
    input_timeout: float = 1.0  # [s] silence reported in /diagnostics
    debug_rate: float = 10.0  # [Hz] of markers, at most

    def __post_init__(self) -> None:
        super().__post_init__()
        check_text("odom_frame", self.odom_frame)
        check_text("base_frame", self.base_frame)
        check_flag("path_orientations", self.path_orientations)
        check_range("control_rate", self.control_rate, 1.0, 1000.0, "Hz")
        check_range("stop_repeat", self.stop_repeat, 0.0, 3600.0, "s")
        check_range("input_timeout", self.input_timeout, 0.01, 60.0, "s")
        check_range("debug_rate", self.debug_rate, 0.1, 1000.0, "Hz")


def make_separation_parameters(values: Mapping[str, Any], where: str) -> SeparationNodeParameters:
    """Parameters from the contents of the private namespace `where`.

    Raises:
        ParameterError: names the parameter that is unknown or wrong.
    """
    arm = build_list(ArmFrame, values.get("arm_frames"), f"{where}/arm_frames")
    return build(SeparationNodeParameters, {**values, "arm_frames": arm}, where)
