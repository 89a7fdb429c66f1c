"""Becomes move_base where the navigation stack is installed, else the simple navigator."""

from __future__ import annotations

import os
import sys

import rospkg
import rospy
from roslib.packages import find_node

from safe_passage.ros.simple_navigator_node import SimpleNavigatorNode

NEEDED = ("move_base", "costmap_2d", "teb_local_planner", "global_planner")
COSTMAP = "~local_costmap/"  # where move_base keeps its own


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
        f"move_base is not started: {', '.join(missing) or 'its program'} not installed. A simple "
        f"navigator takes its action and topics; its local costmap is on "
        f"{rospy.resolve_name(COSTMAP)}/costmap, with the same parameters."
    )
    SimpleNavigatorNode(COSTMAP).spin()
