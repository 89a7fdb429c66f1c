"""Parameters of the node scan_segmentation_server."""

from __future__ import annotations

from dataclasses import dataclass

from safe_passage.core.errors import InputError, ParameterError
from safe_passage.core.parameters import check_range, check_text
from safe_passage.ros.scan_conversions import unit


@dataclass(frozen=True)
class ServerParameters:
    """The node's own; the others are those of segment_scan."""

    robot: str = ""  # configuration to begin with; empty: the first one
    level_frame: str = "odom"  # tf frame whose z is up; empty: `up` counts
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)  # in the cloud's frame, against gravity
    axis: tuple[float, ...] = ()  # of the rotation, of clouds without beta; empty: is estimated
    max_age: float = 600.0  # [s] an older cloud is not the latest any more
    max_future: float = 0.5  # [s] clouds stamped farther ahead are dropped
    transform_tolerance: float = 0.5  # [s] a cloud waits so long for tf
    input_timeout: float = 60.0  # [s] with nothing but dropped clouds: an error in /diagnostics

    def __post_init__(self) -> None:
        check_text("robot", self.robot, may_be_empty=True)
        check_text("level_frame", self.level_frame, may_be_empty=True)
        for name in ("up", "axis") if self.axis else ("up",):
            try:
                unit(getattr(self, name))
            except InputError as error:
                raise ParameterError(f"{name} is {error}") from None
        check_range("max_age", self.max_age, 0.1, 86_400.0, "s")
        check_range("max_future", self.max_future, 0.0, 10.0, "s")
        check_range("transform_tolerance", self.transform_tolerance, 0.0, 10.0, "s")
        check_range("input_timeout", self.input_timeout, 0.01, 3600.0, "s")
