"""Node obstacle_tracker without ROS: scans and a camera's persons in, persons for the areas out."""

from __future__ import annotations

from typing import Sequence

import safe_passage._safety_area as safety
from safe_passage.core.geometry import Pose
from safe_passage.monitoring.aggregation import Measurement
from safe_passage.monitoring.parameters import TrackerParameters
from safe_passage.monitoring.person_looks import Look, places_of
from safe_passage.monitoring.persons import PersonLabelParameters, PersonLabels, Persons
from safe_passage.monitoring.pipeline import ObstacleTracker, Snapshot


class PersonTracker:
    """Tracks everything and tells who is a person."""

    def __init__(self, parameters: TrackerParameters, labels: PersonLabelParameters) -> None:
        self._tracker, self._labels = ObstacleTracker(parameters), PersonLabels(labels)
        self.source = parameters.sources[0]

    def update(
        self, stamp: float, pose: Pose, measurements: Sequence[Measurement], looks: Sequence[Look]
    ) -> list[safety.Person]:
        """One cycle.

        Args:
            stamp: [s] now.
            pose: of base in the odometry's frame.
            measurements, looks: since the last cycle.

        Returns:
            The persons on tracks and those on none, as the node tells them; frame odometry.
        """
        snapshot = self._tracker.update(stamp, pose, measurements)
        return _told(snapshot, self._labels.update(snapshot, looks))


def _told(snapshot: Snapshot, persons: Persons) -> list[safety.Person]:
    velocity = places_of(snapshot).velocity
    told = [
        safety.Person(
            snapshot.stamp,
            [*at, 0.0],
            [*velocity[i].tolist(), 0.0],
            int(snapshot.tracks.id[i]) if k == 0 else 0,
            "odom",
        )
        for i, places in persons.places.items()
        for k, at in enumerate(places.tolist())
    ]
    return told + [
        safety.Person(snapshot.stamp, [*one.position, 0.0], source="odom")
        for one in persons.unattached
    ]
