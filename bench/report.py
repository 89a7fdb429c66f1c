"""Results as Markdown, for docs/benchmarks.md: `python3 -m bench.report FILE.json`."""

from __future__ import annotations

import json
import sys
from pathlib import Path


def markdown(result: dict) -> str:
    """A table and the line that says where and when it was measured."""
    lines = [
        f"Commit {result['commit']}, {result['date']}, {result['machine']}.",
        "",
        "| metric | value | unit | bar | holds |",
        "|---|---|---|---|---|",
    ]
    for row in result["metrics"]:
        value = "not measured" if row["value"] is None else f"{row['value']:.4g}"
        holds = {True: "yes", False: "**no**", None: ""}[row["holds"]]
        lines.append(f"| {row['name']} | {value} | {row['unit']} | {row['bar']} | {holds} |")
    return "\n".join(lines)


if __name__ == "__main__":
    for file in sys.argv[1:]:
        print(markdown(json.loads(Path(file).read_text())))
