"""Scan segmentation: a rotating scanner's cloud -> planes -> where the robot fits (paper 003)."""

from safe_passage.scan_segmentation.basic_map import Colour, ColourMap
from safe_passage.scan_segmentation.doors import Door
from safe_passage.scan_segmentation.parameters import RobotConfiguration, SegmentationParameters
from safe_passage.scan_segmentation.pipeline import Planes, ScanSegmenter, Segmentation
from safe_passage.scan_segmentation.scan import OrganisedScan, Reason, SegmentationError
from safe_passage.scan_segmentation.stairs import Stairs

__all__ = [
    "Colour",
    "ColourMap",
    "Door",
    "OrganisedScan",
    "Planes",
    "Reason",
    "RobotConfiguration",
    "ScanSegmenter",
    "Segmentation",
    "SegmentationError",
    "SegmentationParameters",
    "Stairs",
]
