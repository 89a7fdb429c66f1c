"""Parameters of the segmentation, and of the robot that wants to pass."""

from __future__ import annotations

import math
from dataclasses import dataclass

from safe_passage.core.errors import ParameterError
from safe_passage.core.parameters import check_range


@dataclass(frozen=True)
class RobotConfiguration:
    """A box with the robot's centre in its middle. Defaults: the paper's LMF at its smallest."""

    length: float = 1.20  # [m]
    width: float = 0.85  # [m]
    height: float = 1.40  # [m]
    max_slope: float = 0.785  # [rad] that it drives on
    max_obstacle: float = 0.20  # [m] height of what it probably drives over
    margin: float = 0.0  # [m] kept to all sides and above

    def __post_init__(self) -> None:
        check_range("length", self.length, 0.05, 20.0, "m")
        check_range("width", self.width, 0.05, 20.0, "m")
        check_range("height", self.height, 0.05, 20.0, "m")
        check_range("max_slope", self.max_slope, 0.0, math.pi / 4, "rad")
        check_range("max_obstacle", self.max_obstacle, 0.0, self.height, "m")
        check_range("margin", self.margin, 0.0, 2.0, "m")

    @property
    def box(self) -> tuple[float, float]:
        """[m] half its length and half its width, with the margin."""
        return 0.5 * self.length + self.margin, 0.5 * self.width + self.margin

    @property
    def clearance(self) -> float:
        """[m] over the ground that it needs."""
        return self.height + self.margin


@dataclass(frozen=True)
class SegmentationParameters:
    """Of a scanner with about 10 mm of noise."""

    max_range: float = 20.0  # [m] beyond which nothing is looked at
    max_points: int = 2_000_000  # more are thinned out, line by line

    line_tolerance: float = 0.04  # [m] of a point from its segment: four times the noise
    line_points: int = 5  # a segment has at least
    line_length: float = 0.10  # [m] a segment has at least
    line_gap: float = 0.20  # [m] between neighbours on one segment
    line_gap_share: float = 0.08  # of the distance to the scanner, the same

    similar_distance: float = 0.25  # [m] between end points of similar segments of two lines
    similar_angle: float = 0.14  # [rad] between them
    first_fit: int = 6  # similar segments from which a plane equation is estimated
    refit_every: int = 25  # segments, and whenever their number has doubled
    plane_segments: int = 25  # of a plane; fewer in a scan of few lines, see `segments_for`
    plane_tolerance: float = 0.04  # [m] of segments and supporting points from their plane
    merge_angle: float = 0.05  # [rad] between planes that are one

    validation_cell: float = 0.2  # [m]
    validation_points: int = 2  # that make a cell bright
    validation_area: float = 0.4  # [m^2] connected, of a plane that exists
    ground_area: float = 1.0  # [m^2] of ground that is worth a result
    apart_area: float = 4.0  # [m^2] of ground that no seam joins to the largest

    ground_tolerance: float = 0.04  # [m] over and under the ground that is even
    rough_cell: float = 0.10  # [m]
    fine_cell: float = 0.01  # [m]
    mesh_gap: float = 0.30  # [m] between ground points with ground between them
    orientations: int = 36  # of the box over half a turn; those of walls are added

    def __post_init__(self) -> None:
        for name in ("line_points", "first_fit", "refit_every", "plane_segments", "orientations"):
            check_range(name, getattr(self, name), 3, 1000, "")
        check_range("max_points", self.max_points, 1000, 100_000_000, "")
        check_range("max_range", self.max_range, 1.0, 200.0, "m")
        for name in (
            "line_tolerance",
            "line_length",
            "line_gap",
            "similar_distance",
            "plane_tolerance",
            "validation_cell",
            "ground_tolerance",
            "mesh_gap",
        ):
            check_range(name, getattr(self, name), 0.001, 5.0, "m")
        check_range("line_gap_share", self.line_gap_share, 0.0, 1.0, "")
        check_range("similar_angle", self.similar_angle, 0.001, 1.5, "rad")
        check_range("merge_angle", self.merge_angle, 0.0, 0.5, "rad")
        check_range("validation_points", self.validation_points, 1, 1000, "")
        for name in ("validation_area", "ground_area", "apart_area"):
            check_range(name, getattr(self, name), 0.0, 1000.0, "m^2")
        check_range("fine_cell", self.fine_cell, 0.005, 0.2, "m")
        check_range("rough_cell", self.rough_cell, self.fine_cell, 1.0, "m")
        times = self.rough_cell / self.fine_cell
        if abs(times - round(times)) > 1e-6:
            raise ParameterError(f"rough_cell is {self.rough_cell}, no multiple of fine_cell")

    @property
    def fine_per_rough(self) -> int:
        """Fine cells along a rough one."""
        return round(self.rough_cell / self.fine_cell)

    def segments_for(self, lines: int) -> int:
        """Segments of a plane in a scan of `lines`: the paper's 25, a fifteenth of a sparse one."""
        return min(self.plane_segments, max(6, lines // 15))
