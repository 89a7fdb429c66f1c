"""Between the leg detector's own types and messages."""

from __future__ import annotations

import math

import numpy as np
import rospy
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from sensor_msgs.msg import LaserScan
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from safe_passage.core.errors import InputError
from safe_passage.leg_detection.persons import LegPerson
from safe_passage.leg_detection.pipeline import LegDetection
from safe_passage.leg_detection.scan import Scan
from safe_passage.msg import Person, PersonArray
from safe_passage.ros.diagnostics import Outcome
from safe_passage.ros.sensor_conversions import UnusableMessageError

PERSON_WIDTH = 0.5  # [m] of the box around a person
LEG_WIDTH = 0.14  # [m] of a leg's marker
YELLOW, RED = ColorRGBA(1.0, 0.9, 0.1, 0.5), ColorRGBA(1.0, 0.2, 0.2, 1.0)
UPRIGHT = Quaternion(0.0, 0.0, 0.0, 1.0)


def from_message(message: LaserScan) -> Scan:
    """The scan; raises UnusableMessageError."""
    if not message.ranges:
        raise UnusableMessageError(Outcome.EMPTY, "no beams")
    ranges = np.array(message.ranges)
    if np.isnan(ranges).all():
        raise UnusableMessageError(Outcome.NOT_FINITE, "every range is NaN")
    try:
        return Scan(
            ranges,
            message.angle_min,
            message.angle_increment,
            message.range_min,
            message.range_max,
            message.header.stamp.to_sec(),
        )
    except InputError as error:
        raise UnusableMessageError(Outcome.BAD_FIELDS, str(error)) from None


def to_persons(detection: LegDetection, header: Header, laser_height: float) -> PersonArray:
    """Persons in the scan's frame; what legs do not tell (height, velocity) is NaN.

    laser_height: [m] of the scan plane over the ground.
    """
    persons = [_to_person(person, laser_height) for person in detection.persons]
    return PersonArray(header=header, persons=persons)


def _to_person(person: LegPerson, laser_height: float) -> Person:
    x, y = person.position
    return Person(
        position=Point(x, y, -laser_height),
        velocity=Vector3(math.nan, math.nan, math.nan),
        box_pose=Pose(Point(x, y, 0.0), UPRIGHT),
        box_size=Vector3(PERSON_WIDTH, PERSON_WIDTH, 0.0),  # what a plane sees
        height=math.nan,
        confidence=person.probability,
        method=Person.METHOD_LEGS,
    )


def to_markers(detection: LegDetection, header: Header) -> MarkerArray:
    """Legs red, persons yellow; the last message's are deleted."""
    markers = [Marker(header=header, action=Marker.DELETEALL)]
    for i, person in enumerate(detection.persons):
        markers.append(_disc(header, "persons", i, person.position, PERSON_WIDTH, YELLOW))
    for i, leg in enumerate(detection.legs):
        markers.append(_disc(header, "legs", i, leg.position, LEG_WIDTH, RED))
    return MarkerArray(markers)


def _disc(
    header: Header, ns: str, number: int, at: tuple[float, float], width: float, colour: ColorRGBA
) -> Marker:
    return Marker(
        header=header,
        ns=ns,
        id=number,
        type=Marker.CYLINDER,
        pose=Pose(Point(*at, 0.0), UPRIGHT),
        scale=Vector3(width, width, 0.05),
        color=colour,
        lifetime=rospy.Duration(1),  # a detector that stops must not leave persons standing
    )
