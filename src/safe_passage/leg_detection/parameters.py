"""Parameters of the leg detector."""

from __future__ import annotations

from dataclasses import dataclass

from safe_passage.core.parameters import check_flag, check_range


@dataclass(frozen=True)
class LegDetectorParameters:
    """What is not the model's: how segments are cut is trained with it, and kept in its file."""

    leg_threshold: float = 0.5  # probability from which on a segment is a leg; 0.5: the model's own
    max_leg_distance: float = 0.8  # [m] between the legs of a person who walks
    lone_legs: bool = True  # a leg without a second one is a person too: the other may be hidden

    def __post_init__(self) -> None:
        check_range("leg_threshold", self.leg_threshold, 0.0, 1.0, "")
        check_range("max_leg_distance", self.max_leg_distance, 0.0, 3.0, "m")
        check_flag("lone_legs", self.lone_legs)
