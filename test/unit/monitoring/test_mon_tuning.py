"""Other parameters while a tracker runs: they count, and what it remembers stays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from safe_passage.core.errors import ParameterError
from safe_passage.monitoring.aggregation import Measurement
from safe_passage.monitoring.parameters import SourceParameters as Sensor
from safe_passage.monitoring.parameters import TrackerParameters
from safe_passage.monitoring.persons import PersonLabelParameters, PersonLabels
from safe_passage.monitoring.pipeline import ObstacleTracker


def walker(x):
    """Points of a leg at (x, 1)."""
    angle = np.linspace(0.0, 2 * np.pi, 20)
    ring = np.stack([x + 0.1 * np.cos(angle), 1.0 + 0.1 * np.sin(angle)], axis=1)
    return np.column_stack((ring, np.full(len(ring), 0.2)))


class TestTracker:
    parameters = TrackerParameters(sources=(Sensor("scan", aggregate=1),), radius=5.0)

    def run(self, tracker, start, cycles=20):
        for k in range(start, start + cycles):
            points = walker(-2.0 + 0.08 * k)
            snapshot = tracker.update(
                0.1 * k, (0.0, 0.0, 0.0), [Measurement("scan", 0.1 * k, (0.0, 0.0, 0.0), points)]
            )
        return snapshot

    def test_tracks_survive_and_the_new_threshold_counts(self):
        tracker = ObstacleTracker(self.parameters)
        before = self.run(tracker, 1)
        tracker.tune(replace(self.parameters, confirm_cycles=1000))
        after = self.run(tracker, 21, 1)
        assert after.tracks.id.tolist() == before.tracks.id.tolist()
        assert before.confirmed.all() and not after.confirmed.any()
        assert np.abs(after.tracks.velocity - before.tracks.velocity).max() < 0.1
        tracker.tune(self.parameters)
        assert self.run(tracker, 22, 1).confirmed.all()

    @pytest.mark.parametrize(
        "other",
        [{"resolution": 0.2}, {"radius": 6.0}, {"sources": (Sensor("other"),)}],
    )
    def test_another_setup_is_refused_and_the_old_one_stays(self, other):
        tracker = ObstacleTracker(self.parameters)
        with pytest.raises(ParameterError, match=next(iter(other))):
            tracker.tune(replace(self.parameters, **other, confirm_cycles=1000))
        assert self.run(tracker, 1).confirmed.all()

    def test_labels_survive(self):
        tracker, labels = ObstacleTracker(self.parameters), PersonLabels(PersonLabelParameters())
        snapshot = self.run(tracker, 1)
        labels.update(snapshot, [])
        before = labels.__dict__.copy()
        labels.tune(PersonLabelParameters(label_gate=1.0))
        for name in ("_labels", "_parents", "_known", "_looked", "_last"):
            assert labels.__dict__[name] is before[name]
