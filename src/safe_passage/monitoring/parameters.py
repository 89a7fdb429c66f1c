"""Parameters of the obstacle tracker: one flat set for the pipeline, one for each source."""

from __future__ import annotations

from dataclasses import dataclass

from safe_passage.core.errors import ParameterError
from safe_passage.core.parameters import check_choice, check_flag, check_range, check_text

LASER, CLOUD = "LaserScan", "PointCloud2"


@dataclass(frozen=True)
class SourceParameters:
    """One sensor, and what of its measurements is an obstacle (paper 000, 3.2 and 3.3)."""

    name: str  # of the sensor, as the tracks' counts of points are named
    type: str = LASER  # LaserScan | PointCloud2
    topic: str = ""  # relative; the name when empty
    range_min: float = 0.0  # [m] nearer measurements are the robot's own or noise
    range_max: float = 30.0  # [m] farther ones are ignored
    crop_margin: float = 0.0  # [rad] cut off at both ends of a scan, where it meets the robot
    veil_angle: float = (
        0.14  # [rad] steps in range under less than this to the beam are jumps; 0: off
    )
    veil_points: int = 2  # in a row that may float between a near and a far surface
    glancing_gap: float = 0.5  # [m] between beams on a straight surface that is closed; 0: off
    aggregate: int = 6  # measurements that are put together, corrected by ego-motion
    min_height: float = 0.05  # [m] over base_frame's ground; lower points of a cloud are floor
    max_height: float = 2.0  # [m] higher points of a cloud are the ceiling
    timeout: float = 0.5  # [s] after which a silent sensor's last measurement counts no more

    def __post_init__(self) -> None:
        check_text("name of a source", self.name)
        prefix = f"{self.name}/"
        check_choice(prefix + "type", self.type, (LASER, CLOUD))
        check_text(prefix + "topic", self.topic, may_be_empty=True)
        check_range(prefix + "range_min", self.range_min, 0.0, 100.0, "m")
        check_range(prefix + "range_max", self.range_max, self.range_min, 1000.0, "m")
        check_range(prefix + "crop_margin", self.crop_margin, 0.0, 3.0, "rad")
        check_range(prefix + "veil_angle", self.veil_angle, 0.0, 1.5, "rad")
        check_range(prefix + "veil_points", self.veil_points, 1, 20, "points")
        check_range(prefix + "glancing_gap", self.glancing_gap, 0.0, 5.0, "m")
        check_range(prefix + "aggregate", self.aggregate, 1, 100, "measurements")
        check_range(prefix + "min_height", self.min_height, -10.0, 10.0, "m")
        check_range(prefix + "max_height", self.max_height, self.min_height, 100.0, "m")
        check_range(prefix + "timeout", self.timeout, 0.01, 60.0, "s")
        if not self.topic:
            object.__setattr__(self, "topic", self.name)

    @property
    def three_dimensional(self) -> bool:
        """Whether it tells heights."""
        return self.type == CLOUD


@dataclass(frozen=True)
class TrackerParameters:
    """The pipeline. Frame: base, x forward, y left, origin on the floor under the robot."""

    sources: tuple[SourceParameters, ...] = ()
    footprint: tuple[tuple[float, float], ...] = ()  # [m] of the robot; points inside are its own
    footprint_padding: float = 0.03  # [m]

    resolution: float = 0.12  # [m] a grid cell
    radius: float = 12.0  # [m] half the side of the grid around the robot
    min_points: int = 2  # of a cluster

    composites: bool = True  # add unions of clusters (4.1)
    splits: bool = True  # add parts of clusters (4.1)
    free_space: bool = True  # know what has come by where scanners' beams passed before
    composite_overlap: float = 0.3  # share of a cluster's cells that a track covers
    split_overlap: float = 0.5  # share of a track's cells that a cluster covers
    body_size: float = 1.0  # [m] diagonal of a cluster that may be one person's legs
    fragment_age: float = 1.0  # [s] a younger track inside such a cluster of another is a leg of it

    gate: float = 9.2  # squared Mahalanobis distance, 99 % of a 2D normal distribution
    cells_weight: float = 2.0  # of the difference in occupied cells
    points_weight: float = 1.0  # of the difference in points, by sensor
    height_weight: float = 1.0  # of the difference in height
    height_scale: float = 0.3  # [m] difference that counts 1
    no_common_sensor: float = 3.0  # added where track and hypothesis share no sensor
    seniority: float = 4.0  # added to a track that would take its cluster from an older one's leg
    max_distance: float = 16.0  # of an association

    agility: float = (
        0.6  # [m^2/s^3] speed changes by the root of it in a second: noise of the model
    )
    moving_agility: float = 1.5  # [m^2/s^3] the same of what is known to move
    pace_agility: float = 0.15  # [m^2/s^3] the same of a walker along his way
    position_noise: float = 0.12  # [m] standard deviation of a compact object's centroid
    stride_noise: float = 0.2  # [m] more of a walker's along his way: legs swing
    extent_scale: float = 0.33  # [m] standard deviation of an object whose centroid is as uncertain
    initial_speed: float = 0.7  # [m/s] standard deviation of a new track's velocity
    odometry_drift: float = 0.02  # [m/m] and [rad/rad] of ego-motion

    alignment: bool = True  # correct apparent motion by shape alignment (4.3)
    alignment_size: float = 2.0  # [m] a smaller moving object may be a walker, whose shape changes
    alignment_reach: float = 0.36  # [m] largest displacement tried
    alignment_noise: float = 0.17  # [m] of a displacement of which a cell loses one cell of overlap
    alignment_overlap: float = 0.8  # share of cells that must lie on each other

    moving_speed: float = 0.3  # [m/s] slower tracks are stationary (5)
    moving_significance: float = 1.0  # squared Mahalanobis distance of the velocity from 0
    moving_distance: float = 0.4  # [m] a track must have left its place by
    moving_time: float = 0.5  # [s] without a break before a track counts as moving; it stays so

    max_unobserved: float = 2.4  # [s] after which an unobserved track ends
    confirm_cycles: int = 3  # observations before a track is published

    def __post_init__(self) -> None:
        names = [source.name for source in self.sources]
        if len(set(names)) != len(names):
            raise ParameterError(f"sources {', '.join(names)}: must have different names")
        if self.footprint and len(self.footprint) < 3:
            raise ParameterError(f"footprint {self.footprint}: must have 3 points [x, y] or more")
        check_range("footprint_padding", self.footprint_padding, 0.0, 2.0, "m")
        check_range("resolution", self.resolution, 0.01, 1.0, "m")
        check_range("radius", self.radius, 10 * self.resolution, 2000 * self.resolution, "m")
        check_range("min_points", self.min_points, 1, 1000, "points")
        for flag in ("composites", "splits", "free_space", "alignment"):
            check_flag(flag, getattr(self, flag))
        for share in ("composite_overlap", "split_overlap", "alignment_overlap"):
            check_range(share, getattr(self, share), 0.01, 1.0, "")
        for weight in (
            "cells_weight",
            "points_weight",
            "height_weight",
            "no_common_sensor",
            "seniority",
        ):
            check_range(weight, getattr(self, weight), 0.0, 1000.0, "")
        check_range("body_size", self.body_size, 0.0, 10.0, "m")
        check_range("fragment_age", self.fragment_age, 0.0, 60.0, "s")
        check_range("gate", self.gate, 0.1, 1000.0, "")
        check_range("max_distance", self.max_distance, 0.1, 1e4, "")
        check_range("height_scale", self.height_scale, 0.01, 10.0, "m")
        check_range("agility", self.agility, 0.001, 100.0, "m^2/s^3")
        check_range("moving_agility", self.moving_agility, 0.001, 100.0, "m^2/s^3")
        check_range("pace_agility", self.pace_agility, 0.001, 100.0, "m^2/s^3")
        check_range("stride_noise", self.stride_noise, 0.0, 10.0, "m")
        check_range("position_noise", self.position_noise, 0.001, 10.0, "m")
        check_range("extent_scale", self.extent_scale, 0.01, 1000.0, "m")
        check_range("initial_speed", self.initial_speed, 0.01, 50.0, "m/s")
        check_range("odometry_drift", self.odometry_drift, 0.0, 1.0, "m/m")
        check_range("alignment_size", self.alignment_size, 0.0, 100.0, "m")
        check_range("alignment_reach", self.alignment_reach, 0.0, 64 * self.resolution, "m")
        check_range("alignment_noise", self.alignment_noise, 0.001, 10.0, "m")
        check_range("moving_speed", self.moving_speed, 0.0, 50.0, "m/s")
        check_range("moving_significance", self.moving_significance, 0.0, 1e4, "")
        check_range("moving_distance", self.moving_distance, 0.0, 10.0, "m")
        check_range("moving_time", self.moving_time, 0.0, 60.0, "s")
        check_range("max_unobserved", self.max_unobserved, 0.0, 600.0, "s")
        check_range("confirm_cycles", self.confirm_cycles, 1, 1000, "cycles")
