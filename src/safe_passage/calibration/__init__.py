"""A depth camera's pose on its robot, from what it sees of the arm (paper 000, 2.2 and 2.3)."""

from safe_passage.calibration.accumulation import temporal_median
from safe_passage.calibration.parameters import CalibrationParameters
from safe_passage.calibration.pipeline import ArmCalibrator, ArmView, Calibration, Verdict

__all__ = [
    "ArmCalibrator",
    "ArmView",
    "Calibration",
    "CalibrationParameters",
    "Verdict",
    "temporal_median",
]
