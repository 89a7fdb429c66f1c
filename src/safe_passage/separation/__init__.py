"""The separation monitor: slow down and stop because of where people will be (paper 000, 5)."""

from safe_passage.separation.parameters import SeparationParameters
from safe_passage.separation.pipeline import Assessment, Level, Reason, SeparationMonitor
from safe_passage.separation.prediction import Obstacles, no_obstacles
from safe_passage.separation.robot_motion import Part, RobotState

__all__ = [
    "Assessment",
    "Level",
    "Obstacles",
    "Part",
    "Reason",
    "RobotState",
    "SeparationMonitor",
    "SeparationParameters",
    "no_obstacles",
]
