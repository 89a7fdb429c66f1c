"""The nodes of the fault campaign, the most important first."""

from __future__ import annotations

from bench.fault_assembler import ScanAssemblerSubject, TfAssemblerSubject
from bench.fault_calibrator import CameraCalibratorSubject
from bench.fault_costmap import LocalCostmapSubject
from bench.fault_detectors import DepthDetectorSubject, LegDetectorSubject, PersonDetectorSubject
from bench.fault_merger import SafetyAreaMergerSubject
from bench.fault_monitor import SeparationMonitorSubject
from bench.fault_segmentation import SegmentationGoalSubject, SegmentationServerSubject
from bench.fault_self_filter import DepthSelfFilterSubject
from bench.fault_subject import Subject
from bench.fault_tracker import ObstacleTrackerSubject

SUBJECTS: dict[str, type[Subject]] = {
    subject.name: subject
    for subject in (
        SeparationMonitorSubject,
        SafetyAreaMergerSubject,
        ObstacleTrackerSubject,
        LocalCostmapSubject,
        PersonDetectorSubject,
        DepthDetectorSubject,
        DepthSelfFilterSubject,
        ScanAssemblerSubject,
        TfAssemblerSubject,
        SegmentationServerSubject,
        SegmentationGoalSubject,
        LegDetectorSubject,
        CameraCalibratorSubject,
    )
}
