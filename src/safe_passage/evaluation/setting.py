"""Where evaluations happen."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from safe_passage.core.errors import InputError
from safe_passage.simulation.robots import Robot, load_robot
from safe_passage.simulation.worlds import World, load_world


@dataclass(frozen=True)
class Setting:
    """Files of the world, of the robot and of its local costmap."""

    world: Path
    robot: Path
    costmap: Path

    @classmethod
    def of(cls, config: Path) -> Setting:
        """The warehouse, in a package's folder `config`."""
        return cls(
            config / "worlds" / "warehouse.yaml",
            config / "robots" / "summit_xl.yaml",
            config / "local_costmap.yaml",
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
