"""Faults that the campaign leaves out, and why: `python3 -m bench.fault_left_out`, as a table."""

from __future__ import annotations

from collections import defaultdict

import rospy

import bench.fault_graph  # noqa: F401  makes the worlds known
from bench.fault_nodes import SUBJECTS
from bench.fault_transforms import OF_MESSAGES, impossible


def left_out() -> dict[tuple[str, str], list[str]]:
    """By reason and fault: the inputs, as "node input"."""
    found: dict[tuple[str, str], list[str]] = defaultdict(list)
    for name, subject in SUBJECTS.items():
        for one in subject().inputs:
            reasons = {**impossible(one.make(rospy.Time(1))), **one.without}
            for fault in set(reasons) - set(one.special):
                found[reasons[fault], fault].append(f"{name} {one.name}")
    return found


def table() -> str:
    """Markdown: a row a reason and set of inputs."""
    rows: dict[tuple[str, str], list[str]] = defaultdict(list)
    found = left_out()
    for fault in OF_MESSAGES:
        for (why, of), inputs in sorted(found.items()):
            if of == fault:
                rows[why, _as_text(inputs)].append(fault)
    lines = ["| faults | of | why |", "|---|---|---|"]
    lines += [f"| {', '.join(faults)} | {of} | {why} |" for (why, of), faults in rows.items()]
    return "\n".join(lines)


def _as_text(inputs: list[str]) -> str:
    """Nodes by input: what all nodes have under a name is said once."""
    nodes: dict[str, list[str]] = defaultdict(list)
    for one in inputs:
        node, name = one.split(" ", 1)
        nodes[name].append(node)
    return "; ".join(
        f"{name} (all)" if name == "tf" else f"{name} of {', '.join(of)}"
        for name, of in nodes.items()
    )


if __name__ == "__main__":
    print(table())
