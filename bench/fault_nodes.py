"""The nodes of the fault campaign, the most important first."""

from __future__ import annotations

from bench.fault_merger import SafetyAreaMergerSubject
from bench.fault_monitor import SeparationMonitorSubject
from bench.fault_subject import Subject

SUBJECTS: dict[str, type[Subject]] = {
    subject.name: subject for subject in (SeparationMonitorSubject, SafetyAreaMergerSubject)
}
