"""A robot's file in config/robots: what it is, and its nodes' parameters over those of config/."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Mapping, Sequence

from safe_passage.core.errors import ParameterError, SafePassageError, shown
from safe_passage.core.reading import read_yaml
from safe_passage.simulation.robots import Robot, load_robot

# The nodes that bringup.launch starts. A node's own yaml describes some other robot: what is named
# here must be said of every robot anew.
NODES: dict[str, tuple[str, ...]] = {
    "obstacle_tracker": ("footprint", "sources"),
    "separation_monitor": ("footprint", "reaction_time", "deceleration"),
    "depth_self_filter": (),
    "person_detector": (),
    "safety_area_merger": (),
    "safety_area_merger_rear": (),
    "local_costmap": ("footprint",),
    "move_base": (),
    "scan_assembler": (),
    "scan_segmentation_server": ("robots",),
}

SENSORS = {  # node -> the sensors of the key robot, without which it has nothing to do
    "person_detector": "cameras",
    "depth_self_filter": "cameras",
    "safety_area_merger": "lidars",
    "scan_assembler": "scanners",
}


@dataclass(frozen=True)
class RobotFile:
    """Its contents."""

    robot: Robot
    overlays: Mapping[str, Mapping[str, Any]]  # node -> parameters

    def lacks(self, nodes: Sequence[str]) -> list[str]:
        """NODE/KEY of what these nodes must be told of the robot and are not."""
        return [
            f"{node}/{key}"
            for node in nodes
            for key in NODES[node]
            if key not in self.overlays.get(node, ())
        ]

    def idle(self, nodes: Sequence[str]) -> list[str]:
        """Those of the nodes for which the robot has no sensor."""
        return [
            node for node in nodes if node in SENSORS and not getattr(self.robot, SENSORS[node])
        ]


def load_robot_file(path: Path) -> RobotFile:
    """Read it.

    Raises:
        InputError: the file cannot be read. ParameterError: names the key at fault.
    """
    robot = load_robot(path)
    overlays = {key: value for key, value in read_yaml(path).items() if key != "robot"}
    for key, overlay in overlays.items():
        if key not in NODES:
            known = ", ".join(("robot", *NODES))
            raise ParameterError(f"{path}: {key} is no node of bringup.launch; known are: {known}")
        if not isinstance(overlay, Mapping) or not overlay:
            raise ParameterError(
                f"{path}: {key} is {shown(overlay)}, must be a mapping of parameters"
            )
    return RobotFile(robot, overlays)


def main(arguments: Sequence[str]) -> int:
    """check_robot FILE [NODE:=true|false ...]: whether bringup.launch can start these nodes of it.

    Returns:
        Exit status: 0 all well, 1 not, with the reason on stderr, 2 used in another way.
    """
    switches = [argument.partition(":=") for argument in arguments[1:]]
    if not arguments or any(node not in NODES or not value for node, _, value in switches):
        nodes = ", ".join(NODES)
        print(f"usage: check_robot FILE [NODE:=true|false ...]; nodes: {nodes}", file=sys.stderr)
        return 2
    started = [node for node, _, value in switches if value.lower() in ("true", "1")]
    try:
        found = load_robot_file(Path(arguments[0]).expanduser())
        missing = found.lacks(started)
        if missing:
            reason = "must be said: the defaults are another robot's"
            raise ParameterError(f"{arguments[0]}: {', '.join(missing)} {reason}")
    except SafePassageError as error:
        print(f"check_robot: {error}", file=sys.stderr)
        return 1
    for node in found.idle(started):
        said = f"no {SENSORS[node]} in its key robot: {node}:=false leaves that node out"
        print(f"check_robot: {arguments[0]}: {said}", file=sys.stderr)
    print(f"{found.robot.name}: all well; parameters of {', '.join(found.overlays) or 'no node'}")
    return 0
