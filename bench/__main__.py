"""Runs one benchmark, prints its table, writes JSON: `tools/bench NAME [--json FILE] [--quick]`."""

from __future__ import annotations

import argparse
import datetime
import importlib
import json
import os
import platform
import subprocess
import sys
from pathlib import Path

FULL = [  # what `all` runs
    "human_safety",
    "tables",
    "tracker",
    "separation",
    "segmentation",
    "self_filter",
    "calibration",
    "faults",
]
NAMES = [*FULL, "leg_tables", "detector", "merger", "costmap", "soak"]


def machine() -> str:
    """Processor, cores, memory, system."""
    cpu = next(
        (
            line.split(":", 1)[1].strip()
            for line in Path("/proc/cpuinfo").read_text().splitlines()
            if line.startswith("model name")
        ),
        platform.machine(),
    )
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    return f"{cpu}, {os.cpu_count()} cores, {memory:.0f} GiB, {platform.system()}"


def commit() -> str:
    """The checkout's commit, with a plus sign where the tree differs from it."""
    run = subprocess.run(
        ["git", "describe", "--always", "--dirty=+"], capture_output=True, text=True, check=False
    )
    return run.stdout.strip() or "unknown"


def table(metrics: list[dict]) -> str:
    """Aligned text, one line a metric."""
    width = max(len(metric["name"]) for metric in metrics)
    lines = []
    for metric in metrics:
        value = metric["value"]
        shown = "not measured" if value is None else f"{value:.4g}"
        mark = {True: "holds", False: "FAILS", None: ""}[metric["holds"]]
        lines.append(
            f"{metric['name']:<{width}}  {shown:>12} {metric['unit']:<8} {metric['bar']:>9}  {mark}"
        )
    return "\n".join(lines)


def main() -> int:
    """Parse the command line and run."""
    parser = argparse.ArgumentParser(prog="tools/bench")
    parser.add_argument("name", choices=[*NAMES, "all"])
    parser.add_argument("--json", type=Path, help="write the results here")
    parser.add_argument("--quick", action="store_true", help="every metric, on less work")
    args = parser.parse_args()
    measured, metrics = commit(), []  # the tree may have changed by the end
    for name in FULL if args.name == "all" else [args.name]:
        metrics += importlib.import_module(f"bench.{name}").run(args.quick)
    print(table(metrics))
    result = {
        "benchmark": args.name + (" (quick)" if args.quick else ""),
        "commit": measured,
        "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d"),
        "machine": machine(),
        "metrics": metrics,
    }
    if args.json:
        args.json.write_text(json.dumps(result, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
