"""The separation monitor: slow down and stop because of where people will be (paper 000, 5)."""

from safe_passage.separation.failsafe import Inputs, Reason, Supervisor
from safe_passage.separation.parameters import SeparationParameters
from safe_passage.separation.pipeline import Assessment, Level, Outlook, SeparationMonitor
from safe_passage.separation.prediction import Obstacles, carried_on, no_obstacles
from safe_passage.separation.robot_motion import Part, RobotState

__all__ = [
    "Assessment",
    "Inputs",
    "Level",
    "Obstacles",
    "Outlook",
    "Part",
    "Reason",
    "RobotState",
    "SeparationMonitor",
    "SeparationParameters",
    "Supervisor",
    "carried_on",
    "no_obstacles",
]
