"""Recorded scans and leg positions, from bags."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from safe_passage.core.errors import InputError
from safe_passage.leg_detection.training_data import LegRecording
from safe_passage.ros.bags import SCAN, read_bag, to_scan

LEGS = "geometry_msgs/PoseArray"


def read_positive(path: Path) -> LegRecording:
    """A bag of scans, each with its legs: one LaserScan topic and one PoseArray topic.

    The n-th PoseArray holds the legs of the n-th scan, in the scanner's frame; their stamps are not
    looked at, because recordings leave them empty.

    Raises:
        InputError: no bag, other topics, or not as many leg messages as scans.
    """
    topics, messages = read_bag(path, (SCAN, LEGS))
    scan_topics = [topic for topic, kind in topics.items() if kind == SCAN]
    leg_topics = [topic for topic, kind in topics.items() if kind == LEGS]
    if len(scan_topics) != 1 or len(leg_topics) != 1:
        raise InputError(
            f"{path}: needs one topic of {SCAN} and one of {LEGS}, has {sorted(topics) or 'none'}"
        )
    scans, arrays = messages[scan_topics[0]], messages[leg_topics[0]]
    if len(scans) != len(arrays):
        raise InputError(f"{path}: {len(scans)} scans, but leg positions of {len(arrays)}")
    legs = [
        np.array([(pose.position.x, pose.position.y) for pose in array.poses]).reshape(-1, 2)
        for array in arrays
    ]
    return LegRecording(path.stem, [to_scan(scan, path) for scan in scans], legs)


def read_negative(path: Path) -> list[LegRecording]:
    """A bag recorded where nobody was: one recording for each LaserScan topic.

    Raises:
        InputError: no bag, or no scans in it.
    """
    topics, messages = read_bag(path, (SCAN,))
    if not topics:
        raise InputError(f"{path}: no topic of {SCAN}")
    return [
        LegRecording(path.stem, [to_scan(scan, path) for scan in messages[topic]], None)
        for topic in sorted(topics)
    ]
