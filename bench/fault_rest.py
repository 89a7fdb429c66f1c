"""Whether a process is at rest: it has read what was sent to it, and no thread of it has work."""

from __future__ import annotations

import os
import threading
from pathlib import Path

TICKS = os.sysconf("SC_CLK_TCK")  # [1/s] of CPU time in /proc
SLEEPS = "S", "I"  # of a thread


def at_rest(pid: int) -> bool:
    """Of this process itself: all threads but the one that asks.

    What comes in through a local socket makes its reader runnable before the sender goes on, so
    that a process of which no thread is runnable has nothing unread. A thread that waits for
    Python's lock sleeps, but then another one has the lock and runs.
    """
    before = _threads(pid)
    return all(state in SLEEPS for state, _ in before) and before == _threads(pid)


def cpu_time(pid: int) -> float:
    """[s] that its threads have worked, however long others kept them from it; gone: 0."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / TICKS  # user and system


def _threads(pid: int) -> list[tuple[str, int]]:
    """State of each, and how often it has run; none of a process that is gone."""
    own = str(threading.get_native_id())
    found = []
    try:
        for task in os.listdir(f"/proc/{pid}/task"):
            if task != own:
                found.append(_thread(f"/proc/{pid}/task/{task}/status"))
    except OSError:
        return [("", 0)] if os.path.exists(f"/proc/{pid}") else []  # a thread has just ended
    return found


def _thread(path: str) -> tuple[str, int]:
    with open(path) as file:
        lines = dict(line.split(":", 1) for line in file)
    switches = (int(lines[f"{kind}_ctxt_switches"]) for kind in ("voluntary", "nonvoluntary"))
    return lines["State"].split()[0], sum(switches)
