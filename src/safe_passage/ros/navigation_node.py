"""Becomes move_base where the navigation stack is installed; says so where it is not."""

from __future__ import annotations

import os
import sys

import rospkg
import rospy
from roslib.packages import find_node

from safe_passage.ros.costmap_node import CostmapNode

NEEDED = ("move_base", "costmap_2d", "teb_local_planner", "global_planner")
COSTMAP = "~local_costmap/"  # where move_base keeps its local costmap too


def missing_packages() -> list[str]:
    """Those of the navigation stack that are not installed."""
    installed = rospkg.RosPack().list()
    return [name for name in NEEDED if name not in installed]


def main() -> None:
    missing = missing_packages()
    programs = [] if missing else find_node("move_base", "move_base")
    if programs:
        os.execv(programs[0], [programs[0], *sys.argv[1:]])
    rospy.init_node("move_base")
    rospy.logwarn(
        f"move_base is not started: {', '.join(missing) or 'its program'} not installed. "
        f"The local costmap runs alone, on {rospy.resolve_name(COSTMAP)}/costmap, with the same "
        "parameters; nothing plans and nothing drives."
    )
    CostmapNode(COSTMAP).spin()
