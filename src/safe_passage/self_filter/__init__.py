"""Takes the robot out of its own depth images (paper 000, 3.3)."""

from safe_passage.self_filter.parameters import SelfFilterParameters
from safe_passage.self_filter.pipeline import Filtered, SelfFilter

__all__ = ["Filtered", "SelfFilter", "SelfFilterParameters"]
