"""A node's private parameters into a dataclass."""

from __future__ import annotations

from typing import Any, TypeVar

import rospy

from safe_passage.core.parameters import from_mapping

T = TypeVar("T")

NOT_OURS = {"diagnostic_period"}  # belongs to diagnostic_updater


def private_values() -> dict[str, Any]:
    """All of `~` that is ours."""
    return {key: value for key, value in rospy.get_param("~", {}).items() if key not in NOT_OURS}


def read_parameters(cls: type[T]) -> T:
    """All of `~` as one `cls`; raises ParameterError naming an unknown or wrong parameter."""
    return from_mapping(cls, private_values(), rospy.get_name())
