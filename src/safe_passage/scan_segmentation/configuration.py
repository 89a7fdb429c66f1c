"""Named robots and parameters, as config/scan_segmentation.yaml has them."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Mapping

from safe_passage.core.errors import ParameterError, shown
from safe_passage.core.reading import build, read_yaml
from safe_passage.scan_segmentation.parameters import RobotConfiguration, SegmentationParameters

KEYS = ("robots", "parameters", "server")  # the last is the node's own


def read_configuration(
    file: Path,
) -> tuple[dict[str, RobotConfiguration], SegmentationParameters]:
    """Named robots and the parameters of a yaml file."""
    try:
        return configuration(read_yaml(file))
    except ParameterError as error:
        raise ParameterError(f"{file}: {error}") from None


def configuration(
    values: Mapping[str, Any], where: str = ""
) -> tuple[dict[str, RobotConfiguration], SegmentationParameters]:
    """The same of the yaml's mapping.

    Args:
        where: the namespace to name in errors, with a slash at its end.
    """
    for key in values:
        if key not in KEYS:
            raise ParameterError(
                f"parameter {where}{key} is not known; known are: {', '.join(KEYS)}"
            )
    entries = values.get("robots")
    if not isinstance(entries, dict) or not entries:
        raise ParameterError(f"parameter {where}robots is {shown(entries)}: needs robots, by name")
    robots = {
        str(name): build(RobotConfiguration, entry, f"{where}robots/{name}")
        for name, entry in entries.items()
    }
    parameters = values.get("parameters") or {}
    return robots, build(SegmentationParameters, parameters, f"{where}parameters")
