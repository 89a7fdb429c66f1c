"""The protective separation distance of ISO/TS 15066, 5.5.4 (now in ISO 10218-2:2025).

    S_p = S_h + S_r + S_s + C + Z_d + Z_r

    S_h  way of the person until the robot stands: v_h (T_r + T_s)
    S_r  way of the robot before it brakes: v_r T_r
    S_s  way of the robot while it brakes: v_r T_s / 2, T_s = v_r / deceleration
    C    intrusion distance: how far a part of the body may be nearer than what the sensors show
    Z_d  uncertainty of the person's place, as the tracker's covariance says it
    Z_r  uncertainty of the robot's place

v_h and v_r are the speeds towards each other, as the standard allows where they are measured; where
the person's is not known, v_h is `human_speed`.
"""

from __future__ import annotations

import numpy as np

from safe_passage.separation.parameters import SeparationParameters


def stopping_time(speed: float, turn: float, p: SeparationParameters) -> float:
    """T_s [s] from a speed [m/s] and a turn [rad/s]."""
    return max(speed / p.deceleration, turn / p.angular_deceleration)


def protective_distance(
    human: float, robot: float, braking: float, growth: float, p: SeparationParameters
) -> float:
    """S_p [m].

    Args:
        human, robot: [m/s] v_h and v_r; away from each other counts as 0.
        braking: [s] T_s.
        growth: [m] Z_d.
    """
    human, robot = max(human, 0.0), max(robot, 0.0)
    S_h = human * (p.reaction_time + braking)
    S_r = robot * p.reaction_time
    S_s = 0.5 * robot * braking
    return S_h + S_r + S_s + p.min_distance + growth + p.robot_uncertainty


def towards(velocity: np.ndarray, apart: np.ndarray) -> float:
    """[m/s] of `velocity` (2,) along `apart` (2,)."""
    length = float(np.hypot(*apart))
    return float(velocity @ apart) / length if length > 0.0 else float(np.hypot(*velocity))
