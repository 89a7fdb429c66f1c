"""Parameters of the node camera_calibrator."""

from __future__ import annotations

from dataclasses import dataclass

from safe_passage.calibration import CalibrationParameters
from safe_passage.core.errors import ParameterError
from safe_passage.core.parameters import check_range, check_text

MOST_POSES = 100
LONGEST = 86_400.0  # [s] for all poses


@dataclass(frozen=True)
class CalibratorNodeParameters(CalibrationParameters):
    """The calibration's, and the node's own."""

    description_parameter: str = "robot_description"  # parameter with the URDF, looked for upwards
    root_frame: str = ""  # tf frame of the URDF's root link; empty: its name
    child_frame: str = ""  # camera's body frame (x forward) of the result; empty: the images' own
    poses: int = 5  # views of a calibration
    least_poses: int = 3  # with which it is tried when the time is over
    timeout: float = 300.0  # [s] for all poses
    still_time: float = 0.3  # [s] for which the arm must have stood before an image
    still_angle: float = 0.002  # [rad or m] by which an arm that stands still moves at most
    new_pose: float = 0.15  # [rad or m] by which a joint differs at least from every pose taken
    images: int = 11  # of a pose, of which the median is taken
    before_frame: str = "calibration_before"  # tf frame in which "before" is drawn
    before_apart: float = 1.2  # [m] by which it is drawn beside the robot
    view_frame: str = "calibration_view"  # tf frame between the two, x towards the camera
    max_age: float = 0.5  # [s] older images are dropped
    max_future: float = 0.1  # [s] images stamped farther ahead are dropped
    transform_tolerance: float = 0.1  # [s] an image waits so long for joint states, a goal for tf
    input_timeout: float = 3.0  # [s] silence reported in /diagnostics; a goal waits so long for it

    def __post_init__(self) -> None:
        super().__post_init__()
        check_text("description_parameter", self.description_parameter)
        check_text("root_frame", self.root_frame, may_be_empty=True)
        check_text("child_frame", self.child_frame, may_be_empty=True)
        check_text("before_frame", self.before_frame)
        check_text("view_frame", self.view_frame)
        check_range("poses", self.poses, 1, MOST_POSES, "")
        check_range("least_poses", self.least_poses, 1, MOST_POSES, "")
        if self.least_poses > self.poses:
            raise ParameterError(f"least_poses is {self.least_poses}, poses only {self.poses}")
        check_range("timeout", self.timeout, 0.1, LONGEST, "s")
        check_range("still_time", self.still_time, 0.0, 5.0, "s")
        check_range("still_angle", self.still_angle, 1e-6, 0.1, "rad or m")
        check_range("new_pose", self.new_pose, 1e-3, 10.0, "rad or m")
        check_range("images", self.images, 1, 200, "")
        check_range("before_apart", self.before_apart, 0.0, 20.0, "m")
        check_range("max_age", self.max_age, 0.0, 10.0, "s")
        check_range("max_future", self.max_future, 0.0, 10.0, "s")
        check_range("transform_tolerance", self.transform_tolerance, 0.0, 10.0, "s")
        check_range("input_timeout", self.input_timeout, 0.01, 60.0, "s")
