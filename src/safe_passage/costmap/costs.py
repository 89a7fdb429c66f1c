"""The cost values of a cell, as costmap_2d defines them (uint8)."""

from __future__ import annotations

FREE_SPACE = 0
INSCRIBED_INFLATED_OBSTACLE = 253  # the robot's centre here means certain contact
LETHAL_OBSTACLE = 254
NO_INFORMATION = 255
