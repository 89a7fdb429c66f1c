"""A scan of a 2D laser scanner, as plain values."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from safe_passage.core.errors import InputError


@dataclass(frozen=True)
class Scan:
    """One sweep, in the scanner's frame.

    Raises:
        InputError: the angles are not finite, the beams have no distance, or the ranges no order.
    """

    ranges: np.ndarray  # (N,) [m]; NaN, inf, below range_min, not below range_max: no return
    angle_min: float  # [rad] of the first beam
    angle_increment: float  # [rad] from beam to beam; negative: the scanner turns clockwise
    range_min: float = 0.0  # [m]
    range_max: float = math.inf  # [m]
    stamp: float = 0.0  # [s] on any clock that the scans share

    def __post_init__(self) -> None:
        if np.ndim(self.ranges) != 1:
            raise InputError(f"ranges have {np.ndim(self.ranges)} dimensions, must have one")
        if not math.isfinite(self.angle_min) or not math.isfinite(self.angle_increment):
            raise InputError(
                f"angle_min {self.angle_min}, angle_increment {self.angle_increment}: not finite"
            )
        if self.angle_increment == 0.0:
            raise InputError("angle_increment is 0: every beam has the same direction")
        if not self.range_max > self.range_min >= 0.0:
            raise InputError(f"range limits [{self.range_min}, {self.range_max}] m are no interval")

    def angles(self) -> np.ndarray:
        """Direction (N,) [rad] of each beam, counter-clockwise from the scanner's x axis."""
        return self.angle_min + self.angle_increment * np.arange(len(self.ranges))

    def returns(self) -> np.ndarray:
        """Which beams (N,) bool met something: exactly 0 is no return, whatever range_min says."""
        with np.errstate(invalid="ignore"):
            return (
                (self.ranges >= self.range_min) & (self.ranges < self.range_max) & (self.ranges > 0)
            )

    @property
    def all_round(self) -> bool:
        """Whether the last beam is the first one's neighbour."""
        step = abs(self.angle_increment)
        return (len(self.ranges) - 1) * step >= 2.0 * math.pi - 1.5 * step

    def same_beams(self, other: Scan) -> bool:
        """Whether both scans have the same beams, so that beam i is beam i."""
        return (
            len(self.ranges) == len(other.ranges)
            and self.angle_min == other.angle_min
            and self.angle_increment == other.angle_increment
        )
