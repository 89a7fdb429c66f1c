"""Parameters of the navigator."""

from __future__ import annotations

from dataclasses import dataclass

from safe_passage.core.errors import ParameterError
from safe_passage.core.parameters import check_range


@dataclass(frozen=True)
class NavigatorParameters:
    """Defaults: a Summit XL at walking pace."""

    footprint: tuple[tuple[float, float], ...] = (
        (0.36, 0.31),
        (-0.36, 0.31),
        (-0.36, -0.31),
        (0.36, -0.31),
    )  # [m]
    footprint_padding: float = 0.01  # [m]
    max_speed: float = 0.8  # [m/s]
    max_reverse_speed: float = 0.3  # [m/s]
    max_turn_rate: float = 0.8  # [rad/s]
    acceleration: float = 0.6  # [m/s^2] that it plans with; the base should be able to do more
    turn_acceleration: float = 1.2  # [rad/s^2]
    horizon: float = 2.0  # [s] that a velocity must be free of obstacles
    approach_distance: float = 0.8  # [m] before the goal it turns to the goal's heading
    xy_tolerance: float = 0.05  # [m] of the goal
    yaw_tolerance: float = 0.05  # [rad] of the goal
    area_cost: float = 40.0  # a metre through what only the costmap shows costs so many more
    patience: float = 60.0  # [s] blocked for longer, it gives up

    def __post_init__(self) -> None:
        if len(self.footprint) < 3 or any(len(point) != 2 for point in self.footprint):
            raise ParameterError("footprint: three or more points [x, y] in m")
        check_range("footprint_padding", self.footprint_padding, 0.0, 1.0, "m")
        check_range("max_speed", self.max_speed, 0.05, 5.0, "m/s")
        check_range("max_reverse_speed", self.max_reverse_speed, 0.0, 5.0, "m/s")
        check_range("max_turn_rate", self.max_turn_rate, 0.05, 5.0, "rad/s")
        check_range("acceleration", self.acceleration, 0.05, 10.0, "m/s^2")
        check_range("turn_acceleration", self.turn_acceleration, 0.05, 20.0, "rad/s^2")
        check_range("horizon", self.horizon, 0.5, 10.0, "s")
        check_range("approach_distance", self.approach_distance, 0.0, 5.0, "m")
        check_range("xy_tolerance", self.xy_tolerance, 0.005, 1.0, "m")
        check_range("yaw_tolerance", self.yaw_tolerance, 0.005, 3.15, "rad")
        check_range("area_cost", self.area_cost, 0.0, 1000.0, "")
        check_range("patience", self.patience, 0.1, 86400.0, "s")
