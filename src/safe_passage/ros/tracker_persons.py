"""Persons for the tracker: what detectors say comes in, who is tracked goes out."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import Header

from safe_passage.core.geometry import rotation
from safe_passage.monitoring.person_looks import Look, View
from safe_passage.monitoring.persons import Persons, Unattached
from safe_passage.monitoring.pipeline import Snapshot
from safe_passage.msg import Person, PersonArray
from safe_passage.ros.conversions import from_transform
from safe_passage.ros.diagnostics import NodeDiagnostics, Outcome
from safe_passage.ros.sensor_conversions import UnusableMessageError
from safe_passage.ros.sensor_input import InputLimits, Received, SensorInput
from safe_passage.ros.tracker_parameters import PersonSourceParameters, TrackerNodeParameters

MARGIN_SLOPE = 2.5  # of the logistic function that makes a probability of a HOG margin
LEVEL = 0.7  # a camera's optical axis is nearer to the floor's plane than to its normal
WIDTH = 0.5  # [m] of the box around a person whom the lidars alone see
UPRIGHT = Quaternion(0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Seen:
    """The usable persons of a message."""

    persons: tuple[Person, ...]
    complete: bool  # no other was in it: where nobody is, nobody was seen


class PersonInputs:
    """The person detectors. They are a help: that they are silent is not reported here."""

    def __init__(
        self,
        parameters: TrackerNodeParameters,
        tf_buffer: tf2_ros.Buffer,
        diagnostics: NodeDiagnostics,
    ) -> None:
        self._sources = [
            _Source(source, parameters, tf_buffer, diagnostics)
            for source in parameters.person_sources
        ]

    def take(self, now: rospy.Time) -> list[Look]:
        """Everything new that tf can place by now."""
        return [look for source in self._sources for look in source.take(now)]

    def restart(self) -> None:
        """Forget what waits and what came last."""
        for source in self._sources:
            source.input.restart()


class _Source:
    """One detector."""

    def __init__(
        self,
        source: PersonSourceParameters,
        parameters: TrackerNodeParameters,
        tf_buffer: tf2_ros.Buffer,
        diagnostics: NodeDiagnostics,
    ) -> None:
        self._source, self._odom, self._tf = source, parameters.odom_frame, tf_buffer
        self._diagnostics = diagnostics
        self._topic = rospy.resolve_name(source.topic)
        limits = InputLimits(
            source.max_age, parameters.max_future, parameters.transform_tolerance + source.max_age
        )
        self.input = SensorInput(
            source.topic, PersonArray, limits, diagnostics, self._read, self._look, expected=False
        )

    def take(self, now: rospy.Time) -> list[Look]:
        """Without those that have waited too long for a cycle."""
        looks = [look for look, _ in self.input.take(now)]
        fresh = [look for look in looks if now.to_sec() - look.stamp <= self._source.max_age]
        for _ in range(len(looks) - len(fresh)):
            self._diagnostics.count(self._topic, Outcome.STALE, "has waited for a cycle")
        return fresh

    def _read(self, message: PersonArray) -> Seen:
        finite = [p for p in message.persons if math.isfinite(_sum(p.position))]
        if message.persons and not finite:
            raise UnusableMessageError(Outcome.NOT_FINITE, "no person has a place")
        if len(finite) < len(message.persons):
            self._diagnostics.count(self._topic, Outcome.NOT_FINITE, "a person without a place")
        # What a tracker carries on is no news, least of all what this one does.
        seen = tuple(p for p in finite if p.method != Person.METHOD_TRACK)
        return Seen(seen, len(seen) == len(message.persons))

    def _look(self, received: Received) -> Look:
        message = self._tf.lookup_transform(self._odom, received.frame, received.stamp)
        T, seen = from_transform(message), received.content
        places = [T[:2, :3] @ _array(p.position) + T[:2, 3] for p in seen.persons]
        return Look(
            received.stamp.to_sec(),
            np.array(places).reshape(-1, 2),
            np.array([probability_of(person) for person in seen.persons], float),
            view_of(T, self._source) if seen.complete else None,
            seen.persons,
        )


def probability_of(person: Person) -> float:
    """[0, 1] of what the detector says on its own scale; 0.5: it says nothing."""
    if not math.isfinite(person.confidence) or person.method == Person.METHOD_NONE:
        return 0.5
    if person.method == Person.METHOD_HOG:
        margin = min(max(person.confidence, -10.0), 10.0)
        return 1.0 / (1.0 + math.exp(-MARGIN_SLOPE * margin))
    return min(max(person.confidence, 0.0), 1.0)


def view_of(T: np.ndarray, source: PersonSourceParameters) -> View | None:
    """What a detector at T (4, 4), frame of the odometry, sees of the floor; None: not known.

    It looks along z, as optical frames do (REP 103), or along x where z is upright.
    """
    if source.field_of_view == 0.0:
        return None
    axis = T[:3, 2] if abs(T[2, 2]) < LEVEL else T[:3, 0]
    origin = (float(T[0, 3]), float(T[1, 3]))
    heading = math.atan2(axis[1], axis[0])
    return View(origin, heading, source.field_of_view, source.range_min, source.range_max)


def to_person_array(snapshot: Snapshot, persons: Persons, header: Header) -> PersonArray:
    """Tracked persons and new detections without a track; the header's frame is the odometry's."""
    array = PersonArray(header=header)
    tracks = snapshot.tracks
    velocity = tracks.velocity @ rotation(snapshot.pose[2]).T
    for i, places in persons.places.items():
        for k, at in enumerate(places.tolist()):
            number = int(tracks.id[i]) if k == 0 else 0  # an id is one person's
            person = _tracked(number, at, velocity[i].tolist(), tracks.height[i].tolist())
            person.confidence, person.method = persons.probability[i], Person.METHOD_TRACK
            if persons.said[i] is not None:
                _confirm(person, persons.said[i])
            array.persons.append(person)
    return array if not persons.unattached else _with_unattached(array, persons.unattached)


def _tracked(number: int, at: list[float], velocity: list[float], heights: list[float]) -> Person:
    low, high = heights
    known = math.isfinite(high)
    size = Vector3(WIDTH, WIDTH, high - low if known else 0.0)  # else: what a plane sees
    middle = Point(*at, 0.5 * (low + high) if known else 0.0)
    return Person(
        id=number,
        position=Point(*at, 0.0),
        velocity=Vector3(*velocity, 0.0),
        box_pose=Pose(middle, UPRIGHT),
        box_size=size,
        height=high,
    )


def _with_unattached(array: PersonArray, unattached: tuple[Unattached, ...]) -> PersonArray:
    """Standing where they were, for nobody knows better."""
    nan = math.nan
    for one in unattached:
        person = _tracked(0, list(one.position), [nan, nan], [nan, nan])
        person.velocity.z = nan
        person.confidence, person.method = one.probability, Person.METHOD_NONE
        if one.said is not None:
            _confirm(person, one.said)
        array.persons.append(person)
    return array


def _confirm(person: Person, said: Person) -> None:
    """A camera sees the person: what it says of it."""
    person.confidence, person.method, person.height = said.confidence, said.method, said.height
    person.roi = said.roi


def _array(point: Point) -> np.ndarray:
    return np.array([point.x, point.y, point.z])


def _sum(point: Point) -> float:
    return point.x + point.y + point.z
