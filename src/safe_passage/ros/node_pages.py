"""The tables of parameters in docs/nodes, made from the code: `python3 -m ... --write`.

Without --write it says which pages are out of date, and exits with 1 if any is.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import sys
from pathlib import Path
from typing import Any, Callable, Iterable, Tuple

from safe_passage.core.described import REQUIRED, Description, described
from safe_passage.costmap.parameters import (
    CostmapParameters,
    InflationLayerParameters,
    ObstacleLayerParameters,
    SourceParameters,
)
from safe_passage.monitoring.parameters import SourceParameters as Sensor
from safe_passage.ros import costmap_node, depth_self_filter_node, separation_parameters
from safe_passage.ros import tracker_parameters as tracker
from safe_passage.ros.calibrator_parameters import CalibratorNodeParameters
from safe_passage.ros.cpp_parameters import read_cpp
from safe_passage.ros.leg_detector_node import LegDetectorNodeParameters
from safe_passage.ros.scan_assembler_node import AssemblerNodeParameters
from safe_passage.ros.segmentation_parameters import ServerParameters
from safe_passage.ros.warehouse_sim_node import WarehouseSimParameters
from safe_passage.scan_segmentation.parameters import RobotConfiguration, SegmentationParameters

ROOT = Path(__file__).resolve().parents[3]
BEGIN = "<!-- parameters, made from the code: python3 -m safe_passage.ros.node_pages --write -->"
END = "<!-- end of parameters -->"
HEAD = "| parameter | default | range | unit | live | |\n|---|---|---|---|---|---|"
NONE: frozenset = frozenset()

Table = Tuple[Iterable[Description], Iterable[str]]  # parameters; names of those that are live


def _costmap() -> Table:
    """The robot's outline stands beside the costmap's own, layers below their names."""
    own = [
        dataclasses.replace(one, name=one.name.replace("footprint/", "", 1))
        for one in described(CostmapParameters)
        if one.name != "layers"
    ]
    layer, source, inflation = "OBSTACLE_LAYER/", "OBSTACLE_LAYER/SOURCE/", "INFLATION_LAYER/"
    parts = [(layer, ObstacleLayerParameters), (source, SourceParameters)]
    for prefix, cls in [*parts, (inflation, InflationLayerParameters)]:
        found = described(cls, prefix)
        own += [one for one in found if "[]" not in one.name and one.name != f"{prefix}name"]
    live = {
        *costmap_node.LIVE,
        *(layer + name for name in costmap_node.LIVE_MARKING),
        *(source + name for name in costmap_node.LIVE_SOURCE),
        *(inflation + name for name in costmap_node.LIVE_INFLATION),
    }
    return own, live


def _segmentation() -> Table:
    parameters = (
        *described(RobotConfiguration, "robots/NAME/"),
        *described(SegmentationParameters, "parameters/"),
        *described(ServerParameters, "server/"),
    )
    return parameters, NONE


def cpp_table(node: str) -> Table:
    """Of a C++ node."""
    include = ROOT / "include/safe_passage/ros"
    sources = {
        "person_detector": [ROOT / "src/ros/detector_parameters.cpp"],
        "safety_area_merger": [include / "safety_area_parameters.h"],
    }[node]
    return read_cpp(sources, ROOT / f"config/{node}.yaml")


TABLES: dict[str, Callable[[], Table]] = {
    "person_detector": lambda: cpp_table("person_detector"),
    "safety_area_merger": lambda: cpp_table("safety_area_merger"),
    "obstacle_tracker": lambda: (
        described(tracker.TrackerNodeParameters, sources=(Sensor("front"),)),
        tracker.LIVE,
    ),
    "separation_monitor": lambda: (
        described(separation_parameters.SeparationNodeParameters, robot_radius=0.3),
        separation_parameters.LIVE,
    ),
    "depth_self_filter": lambda: (
        described(depth_self_filter_node.SelfFilterNodeParameters),
        depth_self_filter_node.LIVE,
    ),
    "camera_calibrator": lambda: (described(CalibratorNodeParameters), NONE),
    "scan_assembler": lambda: (described(AssemblerNodeParameters), NONE),
    "scan_segmentation_server": _segmentation,
    "local_costmap": _costmap,
    "leg_detector": lambda: (described(LegDetectorNodeParameters), NONE),
    "warehouse_sim": lambda: (described(WarehouseSimParameters, world="FILE", robot="FILE"), NONE),
}


def table(parameters: Iterable[Description], live: Iterable[str]) -> str:
    """As Markdown."""
    tuned = set(live)
    return "\n".join([HEAD, *(_row(one, one.name in tuned) for one in parameters)])


def _row(one: Description, live: bool) -> str:
    cells = [
        f"`{one.name}`",
        _shown(one.default),
        _range(one),
        one.unit,
        "yes" if live else "",
        one.text.replace("|", "\\|"),
    ]
    return f"| {' | '.join(cells)} |"


def _shown(value: Any) -> str:
    if value is REQUIRED:
        return "none"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, (tuple, list)):
        return f"`[{', '.join(map(_shown, value))}]`"
    if isinstance(value, str):
        return f"`{value}`" if value else "empty"
    return str(value) if value != {} else "empty"


def _range(one: Description) -> str:
    if one.choices:
        return ", ".join(map(_shown, one.choices))
    if one.least is None or one.most is None:
        return ""
    return f"{_bound(one.least)} to {_bound(one.most)}"


def _bound(value: Any) -> str:
    if isinstance(value, str):
        return f"`{value}`"
    return "inf" if math.isinf(value) else f"{value:g}"


def renewed(page: str, node: str) -> str:
    """The page with the node's table between the marks; what stands outside them stays."""
    before, begin, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise ValueError(f"docs/nodes/{node}.md has no {BEGIN} ... {END}")
    return f"{before}{BEGIN}\n{table(*TABLES[node]())}\n{END}{after}"


def main() -> None:
    """Write or check all pages."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="write the tables")
    write, old = parser.parse_args().write, []
    for node in TABLES:
        path = ROOT / "docs/nodes" / f"{node}.md"
        page = path.read_text()
        new = renewed(page, node)
        if new != page and write:
            path.write_text(new)
        elif new != page:
            old.append(str(path.relative_to(ROOT)))
    if old:
        sys.exit(f"{', '.join(old)}: other parameters in the code; {parser.prog} --write")


if __name__ == "__main__":
    main()
