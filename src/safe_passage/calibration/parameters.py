"""Parameters of the calibration."""

from __future__ import annotations

from dataclasses import dataclass

from safe_passage.core.errors import ParameterError
from safe_passage.core.parameters import check_choice, check_flag, check_range

METHODS = ("GICP", "ICP", "PLANE_ICP")  # as small_gicp calls them


@dataclass(frozen=True)
class CalibrationParameters:
    """Of the registration of depth images to a robot's model."""

    method: str = "GICP"
    visual: bool = True  # the links' visual geometry, not the collision's
    range_max: float = 4.0  # [m] of depth that is used
    least_share: float = 0.5  # of the images in which a pixel must have a depth

    edge: int = 2  # [px] of sensor and model that is not used beside a depth edge
    edge_jump: float = 0.04  # [m] between neighbours that is an edge

    start_search: bool = True  # look around the guess first
    start_distances: tuple[float, ...] = (0.3, 0.2, 0.1, 0.1)  # [m] of partners while looking
    start_agreement: float = 0.04  # [m] by which sensor and model may differ in a pixel
    distances: tuple[float, ...] = (0.15, 0.1, 0.06)  # [m] of partners, coarse to fine
    last_distance: float = 0.03  # [m] of partners, until nothing changes any more
    coarse_voxel: float = 0.02  # [m] to which clouds are thinned at distances over fine_below
    fine_voxel: float = 0.006  # [m] the same at the others
    fine_below: float = 0.07  # [m]
    neighbours: int = 20  # points that a point's covariance comes from
    iterations: int = 30  # of one registration, at most
    rounds: int = 15  # of the last distance, at most
    settled_translation: float = 0.0005  # [m] between two rounds of a result that has settled
    settled_rotation: float = 0.0005  # [rad] the same

    inlier_distance: float = 0.02  # [m] of a model's point that has been seen
    least_inliers: float = 0.6  # share of the model's visible points that have been seen
    most_rms: float = 0.015  # [m]
    least_points: int = 500  # seen on the arm
    least_observability: float = 0.01  # eigenvalue, 1/6 were all directions alike
    most_translation: float = 0.001  # [m] standard deviation of the camera's place
    most_rotation: float = 0.0012  # [rad] the same of its rotation

    def __post_init__(self) -> None:
        check_choice("method", self.method, METHODS)
        check_flag("visual", self.visual)
        check_flag("start_search", self.start_search)
        check_range("range_max", self.range_max, 0.1, 100.0, "m")
        check_range("least_share", self.least_share, 0.0, 1.0, "")
        if not self.distances:
            raise ParameterError("distances is empty, must hold one at least")
        for distance in (*self.start_distances, *self.distances, self.last_distance):
            check_range("distances", distance, 0.001, 5.0, "m")
        check_range("edge", self.edge, 0, 50, "px")
        check_range("edge_jump", self.edge_jump, 0.001, 1.0, "m")
        check_range("coarse_voxel", self.coarse_voxel, 0.001, 0.2, "m")
        check_range("fine_voxel", self.fine_voxel, 0.001, 0.2, "m")
        check_range("start_agreement", self.start_agreement, 0.001, 1.0, "m")
        check_range("fine_below", self.fine_below, 0.0, 5.0, "m")
        check_range("neighbours", self.neighbours, 5, 100, "points")
        check_range("iterations", self.iterations, 1, 1000, "")
        check_range("rounds", self.rounds, 1, 1000, "")
        check_range("settled_translation", self.settled_translation, 1e-6, 0.1, "m")
        check_range("settled_rotation", self.settled_rotation, 1e-6, 0.1, "rad")
        check_range("inlier_distance", self.inlier_distance, 0.001, 1.0, "m")
        check_range("least_inliers", self.least_inliers, 0.0, 1.0, "")
        check_range("most_rms", self.most_rms, 0.001, 1.0, "m")
        check_range("least_points", self.least_points, 10, 1_000_000, "points")
        check_range("least_observability", self.least_observability, 0.0, 0.17, "")
        check_range("most_translation", self.most_translation, 1e-5, 1.0, "m")
        check_range("most_rotation", self.most_rotation, 1e-5, 1.0, "rad")
