"""Scans from messages, persons to messages."""

import math

import pytest
from safe_passage.leg_detection.persons import Leg, LegPerson
from safe_passage.leg_detection.pipeline import LegDetection
from safe_passage.msg import Person
from safe_passage.ros.diagnostics import Outcome
from safe_passage.ros.leg_conversions import from_message, to_markers, to_persons
from safe_passage.ros.sensor_conversions import UnusableMessageError
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header
from visualization_msgs.msg import Marker

HEADER = Header(frame_id="laser")
LEGS = Leg((2.0, 0.1), 0.7), Leg((2.0, -0.1), 0.9)
SEEN = LegDetection([*LEGS], [LegPerson((2.0, 0.0), 0.9, LEGS)])


def message(**changes):
    fields = {"angle_min": -1.0, "angle_increment": 0.1, "range_max": 9.0, "ranges": [1.0, 2.0]}
    return LaserScan(**{**fields, **changes})


@pytest.mark.parametrize(
    ("changes", "outcome"),
    [
        ({"ranges": []}, Outcome.EMPTY),
        ({"ranges": [math.nan] * 3}, Outcome.NOT_FINITE),
        ({"angle_increment": 0.0}, Outcome.BAD_FIELDS),
        ({"angle_min": math.nan}, Outcome.BAD_FIELDS),
        ({"range_max": 0.0}, Outcome.BAD_FIELDS),
        ({"range_min": math.nan}, Outcome.BAD_FIELDS),
    ],
)
def test_unusable_scans_are_refused_with_a_reason(changes, outcome):
    with pytest.raises(UnusableMessageError) as refusal:
        from_message(message(**changes))
    assert refusal.value.outcome is outcome


def test_a_scan_of_no_returns_is_usable():
    assert not from_message(message(ranges=[math.inf, math.nan])).returns().any()


def test_a_person_stands_on_the_ground_below_the_scan():
    (person,) = to_persons(SEEN, HEADER, laser_height=0.3).persons
    assert (person.position.x, person.position.y, person.position.z) == (2.0, 0.0, -0.3)
    assert person.method == Person.METHOD_LEGS
    assert person.confidence == 0.9
    assert math.isnan(person.velocity.x)
    assert math.isnan(person.height)
    assert (person.id, person.roi.width) == (0, 0)


def test_markers_replace_the_last_ones():
    markers = to_markers(SEEN, HEADER).markers
    assert markers[0].action == Marker.DELETEALL
    assert [marker.ns for marker in markers[1:]] == ["persons", "legs", "legs"]
    assert len({(marker.ns, marker.id) for marker in markers}) == 4
    assert all(marker.header.frame_id == "laser" for marker in markers)
    assert all(marker.lifetime.to_sec() > 0 for marker in markers[1:])
