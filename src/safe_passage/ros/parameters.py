"""A node's private parameters into a dataclass."""

from __future__ import annotations

from typing import TypeVar

import rospy

from safe_passage.core.parameters import from_mapping

T = TypeVar("T")

NOT_OURS = {"diagnostic_period"}  # belongs to diagnostic_updater


def read_parameters(cls: type[T]) -> T:
    """All of `~` as one `cls`; raises ParameterError naming an unknown or wrong parameter."""
    values = rospy.get_param("~", {})
    mapping = {key: value for key, value in values.items() if key not in NOT_OURS}
    return from_mapping(cls, mapping, rospy.get_name())
