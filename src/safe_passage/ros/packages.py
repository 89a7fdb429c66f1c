"""Where ROS packages are."""

from __future__ import annotations

from pathlib import Path

import rospkg


def package_folder(name: str) -> Path:
    """A package's folder; KeyError: rospack does not know it."""
    try:
        return Path(rospkg.RosPack().get_path(name))
    except rospkg.ResourceNotFound:
        raise KeyError(name) from None
