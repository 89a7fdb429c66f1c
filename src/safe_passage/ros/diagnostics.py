"""What every Python node reports; twin of include/safe_passage/ros/diagnostics.h."""

from __future__ import annotations

import enum
import threading
import time
from collections import Counter, defaultdict

import diagnostic_updater
import rospy
from diagnostic_msgs.msg import DiagnosticStatus

from safe_passage.core.parameters import check_range


class Outcome(enum.Enum):
    """What became of an incoming message; everything but OK is a drop with a reason."""

    OK = "OK"
    STALE = "STALE"
    FUTURE = "FUTURE"
    OUT_OF_ORDER = "OUT_OF_ORDER"
    CROWDED_OUT = "CROWDED_OUT"  # newer ones came before the node had time for it
    NO_TF = "NO_TF"
    NO_MODEL = "NO_MODEL"  # of the robot
    NO_JOINTS = "NO_JOINTS"  # their positions at the stamp
    NO_CAMERA = "NO_CAMERA"  # camera_info of this image
    EMPTY = "EMPTY"
    BAD_FIELDS = "BAD_FIELDS"
    NOT_FINITE = "NOT_FINITE"
    NO_TURN = "NO_TURN"  # the rotating scanner stands
    BROKEN_SWEEP = "BROKEN_SWEEP"  # its lines do not go on where the last ended


CLOCKS = (Outcome.STALE, Outcome.FUTURE)  # by how much tells which clock is wrong


class NodeDiagnostics:
    """Counts messages by outcome; reports rate, latency, silent inputs once a second.

    Args:
        timeout: [s] an input silent, or without one usable message, for longer is an error.
    """

    def __init__(self, timeout: float) -> None:
        self._timeout = timeout
        self._lock = threading.Lock()
        self._outcomes: dict[str, Counter[Outcome]] = defaultdict(Counter)
        self._expected: set[str] = set()
        self._faulty: set[str] = set()
        self._last: dict[str, tuple[float, Outcome, str]] = {}
        self._last_ok: dict[str, float] = {}
        self._started = self._reported = time.monotonic()
        self._outputs, self._worst_latency = 0, 0.0
        self._updater = diagnostic_updater.Updater()
        self._updater.setHardwareID("none")
        self._updater.add("inputs", self._report)
        self._period = rospy.get_param("~diagnostic_period", 1.0)
        check_range("diagnostic_period", self._period, 0.05, 60.0, "s")
        # Wall time: a paused simulation must not silence the diagnostics.
        thread = threading.Thread(target=self._run, name="diagnostics", daemon=True)
        thread.start()

    def expect(self, name: str) -> None:
        """Report `name` as an input when it is waited for or silent."""
        with self._lock:
            self._outcomes[name] += Counter()
            self._expected.add(name)

    def count(self, name: str, outcome: Outcome, detail: str = "") -> None:
        """Count one message of input `name`; anything but OK is logged, throttled."""
        with self._lock:
            self._outcomes[name][outcome] += 1
            now = time.monotonic()
            self._last[name] = now, outcome, detail
            if outcome is Outcome.OK:
                self._last_ok[name] = now
        if outcome is not Outcome.OK:
            rospy.logwarn_throttle(5.0, f"{name}: {outcome.value} {detail}")

    def latency(self, seconds: float) -> None:
        """Note one output and its time [s] since its input arrived."""
        with self._lock:
            self._outputs += 1
            self._worst_latency = max(self._worst_latency, seconds)

    def _fault(self, name: str, now: float) -> str:
        """What is wrong with an input; empty: nothing. Those nobody expects may be silent."""
        oldest = now - self._timeout
        if self._last_ok.get(name, self._started) >= oldest:
            return ""
        last, outcome, detail = self._last.get(name, (self._started, None, ""))
        if outcome and last >= oldest:
            by = f", {detail}" if outcome in CLOCKS and detail else ""
            return f"{name}: only dropped messages, last reason {outcome.value}{by}"
        if name not in self._expected or last >= oldest:
            return ""
        return f"silent: {name}" if outcome else f"waiting for: {name}"

    def _log_change(self, name: str, fault: str) -> None:
        """Say once when an input fails, and when it is back."""
        if fault and name not in self._faulty:
            rospy.logwarn(fault)
            self._faulty.add(name)
        elif not fault and name in self._faulty:
            rospy.loginfo(f"{name} is back")
            self._faulty.remove(name)

    def _run(self) -> None:
        stop = threading.Event()
        rospy.on_shutdown(stop.set)
        while not stop.wait(self._period):
            self._updater.force_update()

    def _report(
        self, status: diagnostic_updater.DiagnosticStatusWrapper
    ) -> diagnostic_updater.DiagnosticStatusWrapper:
        now = time.monotonic()
        status.summary(DiagnosticStatus.OK, "all inputs alive")
        with self._lock:
            for name, outcomes in self._outcomes.items():
                fault = self._fault(name, now)
                if fault:
                    status.mergeSummary(DiagnosticStatus.ERROR, fault)
                self._log_change(name, fault)
                for outcome, number in outcomes.items():
                    status.add(f"{name} {outcome.value}", str(number))
            period = max(now - self._reported, 1e-3)
            status.add("output rate [Hz]", f"{self._outputs / period:.2f}")
            status.add("worst latency [ms]", f"{self._worst_latency * 1e3:.2f}")
            self._outputs, self._worst_latency, self._reported = 0, 0.0, now
        return status
