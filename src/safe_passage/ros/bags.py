"""Recorded messages, from bags."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path

import rosbag

from safe_passage.core.errors import InputError
from safe_passage.leg_detection.scan import Scan
from safe_passage.ros.leg_conversions import from_message
from safe_passage.ros.sensor_conversions import UnusableMessageError

SCAN = "sensor_msgs/LaserScan"


def read_bag(path: Path, kinds: tuple[str, ...]) -> tuple[dict[str, str], dict[str, list]]:
    """Topic -> type, topic -> messages in order, of the topics of these types.

    Raises:
        InputError: no bag.
    """
    try:
        with rosbag.Bag(str(path)) as bag:
            types = bag.get_type_and_topic_info().topics
            topics = {name: topic.msg_type for name, topic in types.items()}
            topics = {name: kind for name, kind in topics.items() if kind in kinds}
            messages = defaultdict(list)
            for name, message, _ in bag.read_messages(topics=list(topics)) if topics else ():
                messages[name].append(message)
    except Exception as error:  # rosbag passes on whatever its parts raise of a damaged file
        raise InputError(f"{path}: {error or type(error).__name__}") from None
    return topics, messages


def to_scan(message: object, path: Path) -> Scan:
    """A scan of the bag `path`; raises InputError."""
    try:
        return from_message(message)
    except UnusableMessageError as error:
        raise InputError(f"{path}: a scan with {error}") from None
