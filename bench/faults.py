"""Fault campaign: every input of every node through every fault, on a private master."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from bench.metric import metric
from bench.ros_master import private_master, program, running

NODES = [  # the most important first
    "separation_monitor",
    "safety_area_merger",
    "obstacle_tracker",
    "local_costmap",
    "person_detector",
    "person_detector_depth",
    "depth_self_filter",
    "scan_assembler",
    "scan_assembler_tf",
    "scan_segmentation_server",
    "scan_segmentation_goal",
    "leg_detector",
    "camera_calibrator",
]
QUICK = NODES[:2]


def run(quick: bool) -> list[dict]:
    """fault_cases, fault_failures, a row a fault, and one for each case that failed."""
    rows = [row for node in (QUICK if quick else NODES) for row in campaign(node, quick)]
    print(table(rows), flush=True)
    failed = [row for row in rows if row["problem"]]
    cases, failures = (Counter(row["fault"] for row in some) for some in (rows, failed))
    return [
        metric("fault_cases", len(rows), ""),
        metric("fault_failures", len(failed), "", "= 0"),
        *(
            metric(f"fault_{f}".replace(" ", "_"), failures[f], f"of {n}", "= 0")
            for f, n in cases.items()
        ),
        *(metric("failed: {node} {input} {fault}".format(**row), 1, "", "= 0") for row in failed),
    ]


def campaign(node: str, quick: bool) -> list[dict]:
    """The rows of one node."""
    with tempfile.TemporaryDirectory() as folder, private_master() as env:
        env.update(ROS_NAMESPACE="robot1", ROS_LOG_DIR=folder)
        file = Path(folder) / "rows"
        command = [sys.executable, "-m", "bench.fault_campaign", node, str(file)]
        with running([program("rosout", "rosout")], env):
            done = subprocess.run(command + ["--quick"] * quick, env=env, check=False)
        rows = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
        if done.returncode:
            problem = f"the campaign ended with {done.returncode}"
            rows.append({"node": node, "input": "campaign", "fault": "all", "problem": problem})
        return rows


def table(rows: list[dict]) -> str:
    """Node and input x fault: ok, FAIL, or - where an input cannot have the fault."""
    faults = list(dict.fromkeys(row["fault"] for row in rows))
    inputs = list(dict.fromkeys((row["node"], row["input"]) for row in rows))
    said = {(row["node"], row["input"], row["fault"]): row["problem"] for row in rows}
    width = max(len(" ".join(names)) for names in inputs)
    lines = [f"{'':<{width}}  " + "  ".join(faults)]
    for names in inputs:
        problems = [said.get((*names, fault)) for fault in faults]
        marks = ["-" if p is None else "FAIL" if p else "ok" for p in problems]
        cells = "  ".join(f"{mark:<{len(fault)}}" for mark, fault in zip(marks, faults))
        lines.append(f"{' '.join(names):<{width}}  {cells}")
    failed = [row for row in rows if row["problem"]]
    lines += ["{node} {input} {fault}: {problem}".format(**row) for row in failed]
    return "\n".join(lines)
