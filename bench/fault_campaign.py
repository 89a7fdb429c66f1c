"""One node through all faults: `python3 -m bench.fault_campaign NODE FILE [--quick]`.

Needs a master of its own (bench.ros_master); bench.faults starts it.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Callable, Iterator

import rospy

from bench.fault_graph import Graph, NodeProcess, Output, Told
from bench.fault_rest import at_rest, cpu_time
from bench.fault_subject import SLACK, Input, Sent, Stated, Subject
from bench.fault_transforms import Transform, faults_of, has_nan

RECENT = 1.0  # [s] simulated: outputs that were under way when a fault began
PATIENCE = 30.0  # [s] of wall time for anything that must come
TOLD_WITHIN = 8.0  # [s] of wall time, as /diagnostics comes
FORWARD, BACK = 60.0, -30.0  # [s] that the clock jumps
QUICK = ("silent", "tf gap", "NaN", "wrong frame", "clock jump back", "killed")
UNHARMED = ("out of order", "duplicated")
ROUND = 0.001  # [s] between two looks whether all is answered
MEMORY = 2**30  # [byte] that no message may cost

Row = dict  # node, input, fault, problem


class Campaign:
    """Drives a subject through its cases."""

    def __init__(self, subject: Subject, logs: Path) -> None:
        self._subject, self._graph = subject, Graph()
        self._name = subject.node or subject.name
        self._told = Told(f"robot1/{self._name}", self._graph.news)
        self._publishers = {i.name: self._advertise(i) for i in subject.inputs}
        self._steps, self._sent = 0, []
        subject.prepare()
        self._graph.listen(subject.outputs)
        self._node = NodeProcess(
            subject.launch, subject.arguments, self._name, subject.parameters, logs
        )

    def stop(self) -> None:
        """End the node."""
        self._node.stop()

    def run(self, quick: bool, only: str, row: Callable[[Row], None]) -> None:
        """All cases whose name has `only` in it; `row` is called with each."""
        for of, fault, case in self._cases():
            if only in f"{of} {fault}" and (not quick or fault in QUICK):
                row(self._row(of, fault, case))

    def _cases(self) -> Iterator[tuple[str, str, Callable[[], str]]]:
        for one in self._subject.inputs:
            faults = {**faults_of(one.make(self._graph.now)), **one.special}
            for name, transform in faults.items():
                if name in one.without:
                    continue
                yield one.name, name, partial(self._input_case, one, name, transform)
            yield one.name, "restarted", partial(self._restart_case, one)
        yield "clock", "clock jump forward", partial(self._clock_case, FORWARD)
        yield "clock", "clock jump back", partial(self._clock_case, BACK)
        yield "node", "killed", self._kill_case

    def _row(self, of: str, fault: str, case: Callable[[], str]) -> Row:
        began = time.monotonic()
        problem = self._until_well(PATIENCE, "before the fault")
        problem = problem or case()
        if self._node.died():
            problem = problem or self._node.died()
            self._node.start()
        took = time.monotonic() - began
        return {
            "node": self._subject.name,
            "input": of,
            "fault": fault,
            "problem": problem,
            "wall_s": round(took, 1),
        }

    def _input_case(self, one: Input, name: str, transform: Transform) -> str:
        stated = self._stated(one, name)
        if stated and stated.told and not self._report_well():
            return f"not reported well before the fault: {self._told}"
        began, drops = self._graph.now.to_sec(), self._told.drops()
        memory = self._node.memory()
        with self._graph.news:
            start, warnings = len(self._graph.outputs), len(self._graph.warnings)
        self._sent.clear()
        from_then = began + (one.timeout + SLACK if stated else 0.0)
        end, patience = from_then + self._subject.judged, time.monotonic() + TOLD_WITHIN
        number = 0
        while self._graph.now.to_sec() < end or (
            stated
            and stated.told
            and not self._is_told(drops, warnings)
            and time.monotonic() < patience
        ):
            self._step({one.name: (transform, number)})
            number += 1
            if self._node.died():
                return self._node.died()
        told = self._is_told(drops, warnings)
        seen = self._seen(start)
        window = [o for o in seen if o.at >= from_then and not began - RECENT < o.stamp < from_then]
        problem = self._subject.wrong(seen, list(self._sent)) or self._not_finite(seen)
        if not problem and stated:
            problem = stated.check(window)
            if not problem and stated.told and not told:
                problem = "not told"
        if not problem and self._node.memory() - memory > MEMORY:
            problem = f"took {(self._node.memory() - memory) / 2**20:.0f} MiB"
        late = stated.late if stated else 0.0
        problem = problem or self._until_well(self._subject.recovery + late, "after the fault")
        # what a fault leaves behind may be wrong after it, too
        return problem or self._subject.wrong(self._seen(start), list(self._sent))

    def _report_well(self) -> bool:
        """What was told of the last fault is told no more; else nobody knew of which this is."""
        patience = time.monotonic() + TOLD_WITHIN
        while self._told.worst() > 0 and time.monotonic() < patience:
            self._step()
        return self._told.worst() <= 0

    def _stated(self, one: Input, name: str) -> Stated | None:
        """What must be seen; None: nothing but what is always so, and health at the end."""
        if name in one.stated:
            return one.stated[name]
        if name in UNHARMED:
            return Stated(self._subject.healthy, told=False)
        if name in ("slow", "huge"):
            return None
        return Stated(one.lost, one.told)

    def _is_told(self, drops: int, warnings: int) -> bool:
        with self._graph.news:
            logged = [name for name in self._graph.warnings[warnings:] if self._name in name]
        return bool(logged) or self._told.drops() > drops or self._told.worst() > 0

    def _restart_case(self, one: Input) -> str:
        self._publishers.pop(one.name).unregister()
        self._step({one.name: (lambda m, n: [], 0)})
        self._publishers[one.name] = self._advertise(one)
        patience = time.monotonic() + PATIENCE
        while not self._publishers[one.name].get_num_connections():
            self._step()
            if time.monotonic() > patience:
                return "the node does not connect again"
        with self._graph.news:
            start = len(self._graph.outputs)
        self._sent.clear()  # what was sent to nobody nobody has lost
        lost_by = self._graph.now.to_sec() + one.timeout + SLACK  # by now it would show
        while self._graph.now.to_sec() < lost_by:
            self._step()
        problem = self._until_well(self._subject.recovery, "after the restart")
        seen = self._seen(start)
        return problem or self._subject.wrong(seen, list(self._sent)) or self._not_finite(seen)

    def _clock_case(self, seconds: float) -> str:
        with self._graph.news:
            start, warnings = len(self._graph.outputs), len(self._graph.warnings)
        self._graph.advance(seconds)
        self._subject.begin(self._graph.now)
        problem = self._until_well(math.inf, "after the jump")
        with self._graph.news:
            warned = self._graph.warnings[warnings:]
        if seconds < 0.0 and not any(self._name in name for name in warned):
            problem = problem or "not told"
        return problem or self._not_finite(self._seen(start))

    def _kill_case(self) -> str:
        self._node.kill()
        with self._graph.news:
            start = len(self._graph.outputs)
        for _ in range(10):
            self._step()
        if any(o.at > self._graph.now.to_sec() - 5 * self._subject.tick for o in self._seen(start)):
            return "something comes out of a node that is dead"
        self._node.start()
        self._subject.begin(self._graph.now)
        problem = self._until_well(math.inf, "after the kill")
        return problem or self._not_finite(self._seen(start))

    def _until_well(self, limit: float, when: str) -> str:
        """All inputs are well: it must be well again by itself within `limit` [s] simulated."""
        with self._graph.news:
            start = len(self._graph.outputs)
        began, patience = self._graph.now.to_sec(), time.monotonic() + PATIENCE
        problem = "nothing came"
        enough = began + (limit if math.isfinite(limit) else 0.0)  # a slow machine gets as much
        while self._graph.now.to_sec() < enough or time.monotonic() < patience:
            self._step()
            recent = self._graph.now.to_sec() - 4 * self._subject.tick
            seen = [o for o in self._seen(start) if began < o.stamp and o.at >= recent]
            problem = self._subject.healthy(seen)
            took = self._graph.now.to_sec() - began
            if not problem:
                return f"not well before {took:.1f} s {when}" if took > limit + SLACK else ""
            if self._node.died():
                return self._node.died()
        return f"not well {when}: {problem}; {self._told}"

    def _step(self, faults: dict[str, tuple[Transform, int]] | None = None) -> None:
        """All inputs speak, some of them with a fault; then the node answers."""
        work = cpu_time(self._node.process.pid)
        now = self._graph.advance(self._subject.tick)
        self._steps += 1
        for one in self._subject.inputs:
            if self._steps % one.every:
                continue
            message = one.make(now)
            transform, number = (faults or {}).get(one.name, (lambda m, _: [m], 0))
            for sent in transform(message, number // one.every):
                self._sent.append(Sent(one.name, now.to_sec(), sent))
                self._publishers[one.name].publish(sent)
        time.sleep(self._subject.pause)
        self._settle(work)

    def _settle(self, work: float) -> None:
        """Until all that was sent is read and answered, or the node has worked long enough.

        Its work, not the wall's time: others that keep it from the processor must not make what
        it was given old. `work`: [s] that it had done when the step began.
        """
        own, pid = os.getpid(), self._node.process.pid
        patience = time.monotonic() + PATIENCE
        while not (at_rest(own) and at_rest(pid) and at_rest(own)):
            if cpu_time(pid) - work > self._subject.work or time.monotonic() > patience:
                return
            time.sleep(ROUND)

    def _advertise(self, one: Input) -> rospy.Publisher:
        return rospy.Publisher(one.topic, one.kind, queue_size=100, tcp_nodelay=True)

    def _seen(self, start: int) -> list[Output]:
        with self._graph.news:
            return self._graph.outputs[start:]

    def _not_finite(self, seen: list[Output]) -> str:
        for output in seen:
            field = has_nan(output.message, self._subject.without_number)
            if field:
                return f"{output.topic}: {field} is not finite"
            header = getattr(output.message, "header", None)
            if header and header.frame_id not in self._subject.frames:
                return f"{output.topic}: frame {header.frame_id!r}"
        return ""


def main() -> int:
    """Run one node's campaign; rows go to FILE, one JSON object a line."""
    from bench.fault_nodes import SUBJECTS

    parser = argparse.ArgumentParser()
    parser.add_argument("node", choices=SUBJECTS)
    parser.add_argument("file", type=Path)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", default="", help="inputs and faults whose name has this")
    args = parser.parse_args()
    rospy.init_node("faults", disable_rostime=True, disable_signals=True)
    rospy.set_param("/use_sim_time", True)
    with tempfile.TemporaryDirectory() as logs, args.file.open("w") as file:

        def write(row: Row) -> None:
            file.write(json.dumps(row) + "\n")
            file.flush()
            mark = f"FAIL {row['problem']}" if row["problem"] else "ok"
            names = "{node:<24} {input:<14} {fault:<20}".format(**row)
            print(f"{names} {row['wall_s']:5.1f} s  {mark}", flush=True)

        campaign = Campaign(SUBJECTS[args.node](), Path(logs))
        try:
            campaign.run(args.quick, args.only, write)
        finally:
            campaign.stop()
            rospy.signal_shutdown("done")
    return 0


if __name__ == "__main__":
    sys.exit(main())
