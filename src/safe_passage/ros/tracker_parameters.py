"""Private parameters of node `obstacle_tracker`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Mapping

from safe_passage.core.errors import ParameterError
from safe_passage.core.parameters import check_range, check_text
from safe_passage.core.reading import build, build_list
from safe_passage.monitoring.parameters import SourceParameters, TrackerParameters
from safe_passage.monitoring.persons import PersonLabelParameters

LIVE = (  # may be changed while it runs; not sensors, robot, frames, grid, which need a restart
    "footprint_padding", "min_points", "composites", "splits", "free_space", "composite_overlap",
    "split_overlap", "body_size", "fragment_age", "gate", "cells_weight", "points_weight",
    "height_weight", "height_scale", "no_common_sensor", "seniority", "max_distance", "agility",
    "moving_agility", "pace_agility", "position_noise", "stride_noise", "extent_scale",
    "initial_speed", "odometry_drift",
    "alignment", "alignment_size", "alignment_reach", "alignment_noise", "alignment_overlap",
    "moving_speed", "moving_significance", "moving_distance", "moving_time",
    "max_unobserved", "confirm_cycles", "rate", "debug_rate", "path_duration", "sector_radius",
    "person_labels/label_gate", "person_labels/person_size", "person_labels/person_threshold",
    "person_labels/person_certainty", "person_labels/moving_half_life",
    "person_labels/standing_half_life", "person_labels/left_half_life",
    "person_labels/walking_speed", "person_labels/walker_probability", "person_labels/denial",
    "person_labels/waiting_time", "person_labels/birth_reach",
    "person_labels/birth_time", "person_labels/confirmation_time",
)  # fmt: skip


@dataclass(frozen=True)
class PersonSourceParameters:
    """One person detector, and where it would have seen somebody."""

    topic: str = "persons"  # relative; PersonArray
    field_of_view: float = 0.0  # [rad] full width, 0: not known, so seeing nobody says nothing
    range_min: float = 1.0  # [m] nearer persons do not fit in the picture
    range_max: float = 5.0  # [m] farther ones may be missed
    max_age: float = 1.0  # [s] older detections are dropped; detectors are slower than lidars

    def __post_init__(self) -> None:
        check_text("topic", self.topic)
        check_range("field_of_view", self.field_of_view, 0.0, 6.284, "rad")
        check_range("range_min", self.range_min, 0.0, 100.0, "m")
        check_range("range_max", self.range_max, self.range_min, 1000.0, "m")
        check_range("max_age", self.max_age, 0.0, 10.0, "s")


@dataclass(frozen=True)
class TrackerNodeParameters(TrackerParameters):
    """The tracker's, and the node's own."""

    odom_frame: str = "odom"  # in which the robot's motion is known
    person_sources: tuple[PersonSourceParameters, ...] = ()  # whose persons label the tracks
    person_labels: PersonLabelParameters = field(default_factory=PersonLabelParameters)
    base_frame: str = "base_footprint"  # of the robot, on the floor; tracks are in it
    rate: float = 40.0  # [Hz] of cycles, at most; one follows on new measurements
    max_age: float = 0.5  # [s] older messages are dropped
    max_future: float = 0.1  # [s] messages stamped farther ahead are dropped
    transform_tolerance: float = 0.2  # [s] a message waits so long for tf at its stamp
    input_timeout: float = 1.0  # [s] silence reported in /diagnostics
    debug_rate: float = 10.0  # [Hz] of grid, cells and markers, at most
    path_duration: float = 60.0  # [s] of a moving obstacle's way that the markers show
    sector_radius: float = 4.0  # [m] up to which the markers show a sensor's field of view

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.sources:
            raise ParameterError("sources is empty: nothing would be tracked")
        topics = [source.topic for source in self.person_sources]
        if len(set(topics)) != len(topics):
            raise ParameterError(f"person_sources {', '.join(topics)}: must have different topics")
        check_text("odom_frame", self.odom_frame)
        check_text("base_frame", self.base_frame)
        check_range("rate", self.rate, 0.1, 1000.0, "Hz")
        check_range("max_age", self.max_age, 0.0, 10.0, "s")
        check_range("max_future", self.max_future, 0.0, 10.0, "s")
        check_range("transform_tolerance", self.transform_tolerance, 0.0, 10.0, "s")
        check_range("input_timeout", self.input_timeout, 0.01, 60.0, "s")
        check_range("debug_rate", self.debug_rate, 0.1, 1000.0, "Hz")
        check_range("path_duration", self.path_duration, 0.0, 3600.0, "s")
        check_range("sector_radius", self.sector_radius, 0.1, 1000.0, "m")


def make_tracker_parameters(values: Mapping[str, Any], where: str) -> TrackerNodeParameters:
    """Parameters from the contents of the private namespace `where`.

    Raises:
        ParameterError: names the parameter that is unknown or wrong, with its source.
    """
    sources = build_list(SourceParameters, values.get("sources"), f"{where}/sources")
    persons = build_list(
        PersonSourceParameters, values.get("person_sources"), f"{where}/person_sources"
    )
    labels = build(
        PersonLabelParameters, values.get("person_labels") or {}, f"{where}/person_labels"
    )
    built = {"sources": sources, "person_sources": persons, "person_labels": labels}
    return build(TrackerNodeParameters, {**values, **built}, where)
