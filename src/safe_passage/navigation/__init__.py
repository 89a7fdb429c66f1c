"""A simple navigator for machines without move_base: global way, local velocity, last metre."""

from safe_passage.navigation.parameters import NavigatorParameters
from safe_passage.navigation.pipeline import Navigator, State

__all__ = ["Navigator", "NavigatorParameters", "State"]
