"""Where evaluations happen."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Tuple

import yaml

from safe_passage.core.errors import InputError
from safe_passage.core.reading import build, read_yaml
from safe_passage.evaluation.tracking_runs import tracker_of
from safe_passage.monitoring.parameters import TrackerParameters
from safe_passage.monitoring.persons import PersonLabelParameters
from safe_passage.simulation.robots import Robot, load_robot
from safe_passage.simulation.worlds import World, load_world

TrackerSetting = Tuple[TrackerParameters, PersonLabelParameters]


@dataclass(frozen=True)
class Setting:
    """Files of the world, of the robot, of its local costmap and of its obstacle tracker."""

    world: Path
    robot: Path
    costmap: Path
    tracker: Path

    @classmethod
    def of(cls, config: Path) -> Setting:
        """The warehouse, in a package's folder `config`."""
        return cls(
            config / "worlds" / "warehouse.yaml",
            config / "robots" / "summit_xl.yaml",
            config / "local_costmap.yaml",
            config / "obstacle_tracker.yaml",
        )

    def load(self) -> tuple[World, Robot]:
        """World and robot.

        Raises:
            InputError: a file cannot be read, or the robot lacks a lidar or a camera.
        """
        world, robot = load_world(self.world), load_robot(self.robot)
        if not robot.lidars or not robot.cameras:
            raise InputError(f"{self.robot}: an evaluation needs a lidar and a camera")
        return world, robot

    def load_costmap(self) -> dict[str, Any]:
        """Contents of the costmap's file."""
        try:
            return yaml.safe_load(self.costmap.read_text())
        except (OSError, yaml.YAMLError) as error:
            raise InputError(f"{self.costmap}: {error}") from None

    def load_tracker(self) -> TrackerSetting:
        """Of its first lidar alone, as bringup.launch lays the robot's file over the node's.

        Raises:
            InputError: a file cannot be read, or the tracker has no lidar.
        """
        values = {**read_yaml(self.tracker), **read_yaml(self.robot).get("obstacle_tracker", {})}
        everything = tracker_of(values, "obstacle_tracker")
        first = tuple(s for s in everything.sources if not s.three_dimensional)[:1]
        if not first:
            raise InputError(f"{self.robot}: an evaluation needs a LaserScan in obstacle_tracker")
        labels = values.get("person_labels") or {}
        return (
            replace(everything, sources=first),
            build(PersonLabelParameters, labels, "obstacle_tracker/person_labels"),
        )
