"""Node chain_report: listens to the running human safety chain and says what it does."""

from __future__ import annotations

import argparse
import statistics
import sys
import threading
from dataclasses import dataclass, field

import numpy as np
import rospy
from map_msgs.msg import OccupancyGridUpdate
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import LaserScan

from safe_passage.msg import PersonArray

LETHAL = 100  # occupancy that costmaps publish for an obstacle


@dataclass
class Output:
    """What one topic has brought."""

    ages: list[float] = field(default_factory=list)  # [s] from stamp to arrival
    figures: list[float] = field(default_factory=list)  # the topic's own, see FIGURES


COSTMAP = "costmap"
FIGURES = {
    "persons": "persons seen",
    "scan": "beams with a return",
    "scan_human_aware": "beams shortened by safety areas",
    COSTMAP: "lethal cells in the map or its update",
}


class ChainReport:
    """Collects, shows progress, prints a table.

    Args:
        costmap: topic of whole maps; its updates are on the same name with _updates.
    """

    def __init__(self, costmap: str = "local_costmap/costmap") -> None:
        self._lock = threading.Condition()
        self._outputs = {name: Output() for name in FIGURES}
        self._stopped = threading.Event()
        rospy.on_shutdown(self._stopped.set)
        self._scans: dict[rospy.Time, dict[str, np.ndarray]] = {}  # by stamp, then by topic
        rospy.Subscriber("persons", PersonArray, self._on_persons)
        rospy.Subscriber("scan", LaserScan, self._on_scan)
        rospy.Subscriber("scan_human_aware", LaserScan, self._on_merged)
        rospy.Subscriber(costmap, OccupancyGrid, self._on_costmap)
        rospy.Subscriber(costmap + "_updates", OccupancyGridUpdate, self._on_costmap)

    def wait_for_all(self, timeout: float) -> list[str]:
        """Wait until every topic has spoken; returns those that have not after `timeout` [s]."""
        with self._lock:
            self._lock.wait_for(lambda: not self._silent(), timeout)
            return self._silent()

    def listen(self, seconds: float) -> str:
        """Collect for `seconds` with a progress bar; returns the table as Markdown."""
        self.start()
        steps = 40
        for step in range(steps + 1):
            _show_progress(step / steps, step * seconds / steps)
            if step < steps:
                self._stopped.wait(seconds / steps)
        return self.table(seconds)

    def start(self) -> None:
        """Forget what was collected so far."""
        with self._lock:
            for output in self._outputs.values():
                output.ages.clear()
                output.figures.clear()

    def table(self, seconds: float) -> str:
        """What `seconds` of collecting have brought, as Markdown."""
        with self._lock:
            return self._table(seconds)

    def _silent(self) -> list[str]:
        return [rospy.resolve_name(name) for name, out in self._outputs.items() if not out.ages]

    def _table(self, seconds: float) -> str:
        lines = [
            "| topic | Hz | age median / worst [ms] | what | median | most |",
            "|---|---|---|---|---|---|",
        ]
        for name, out in self._outputs.items():
            if not out.ages:
                lines.append(f"| {name} | silent | | | | |")
                continue
            ages = sorted(out.ages)
            lines.append(
                f"| {name} | {len(ages) / seconds:.1f} | {1e3 * statistics.median(ages):.1f} / "
                f"{1e3 * ages[-1]:.1f} | {FIGURES[name]} | {statistics.median(out.figures):.0f} | "
                f"{max(out.figures):.0f} |"
            )
        return "\n".join(lines)

    def _note(self, name: str, stamp: rospy.Time, figure: float) -> None:
        with self._lock:
            self._outputs[name].ages.append((rospy.Time.now() - stamp).to_sec())
            self._outputs[name].figures.append(figure)
            self._lock.notify_all()

    def _on_persons(self, message: PersonArray) -> None:
        self._note("persons", message.header.stamp, len(message.persons))

    def _on_scan(self, message: LaserScan) -> None:
        ranges = np.asarray(message.ranges)
        self._note("scan", message.header.stamp, np.isfinite(ranges).sum())
        self._pair(message.header.stamp, "scan", ranges)

    def _on_merged(self, message: LaserScan) -> None:
        self._pair(message.header.stamp, "scan_human_aware", np.asarray(message.ranges))

    def _pair(self, stamp: rospy.Time, name: str, ranges: np.ndarray) -> None:
        """Hold a scan against its merged twin, whichever of the two arrives first."""
        with self._lock:
            scans = self._scans.setdefault(stamp, {})
            scans[name] = ranges
            while len(self._scans) > 50:
                self._scans.pop(next(iter(self._scans)))
        if len(scans) == 2:
            real, merged = scans["scan"], scans["scan_human_aware"]
            shortened = np.isfinite(merged) & ~(merged == real)
            self._note("scan_human_aware", stamp, shortened.sum())

    def _on_costmap(self, message: OccupancyGrid | OccupancyGridUpdate) -> None:
        lethal = np.count_nonzero(np.asarray(message.data) == LETHAL)
        self._note(COSTMAP, message.header.stamp, lethal)


def _show_progress(share: float, seconds: float) -> None:
    """A bar that fills up on a terminal, a line a quarter elsewhere."""
    if sys.stderr.isatty():
        bar = "#" * round(40 * share)
        end = "\n" if share == 1.0 else ""
        print(f"\r  [{bar:.<40}] {seconds:4.0f} s", end=end, file=sys.stderr, flush=True)
    elif 4 * share == int(4 * share):
        print(f"  {seconds:4.0f} s", file=sys.stderr, flush=True)


def main() -> None:
    """Run the node; exit with 1 when a topic stays silent."""
    parser = argparse.ArgumentParser(prog="chain_report", description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0, help="how long to listen")
    parser.add_argument("--wait", type=float, default=60.0, help="[s] for every topic to speak")
    parser.add_argument("--report", help="write the table to this file too")
    args = parser.parse_args(rospy.myargv()[1:])
    rospy.init_node("chain_report", anonymous=True)
    report = ChainReport()
    silent = report.wait_for_all(args.wait)
    if silent:
        print("no message on: " + ", ".join(silent), file=sys.stderr)
        sys.exit(1)
    table = report.listen(args.seconds)
    print(table)
    if args.report:
        with open(args.report, "w") as file:
            file.write(table + "\n")
