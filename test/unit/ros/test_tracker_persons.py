"""Persons of detectors as looks, tracked persons as messages."""

import math
from dataclasses import replace

import numpy as np
import pytest
import rospy
from geometry_msgs.msg import Point
from safe_passage.monitoring.person_looks import Look
from safe_passage.monitoring.persons import PersonLabelParameters, PersonLabels
from safe_passage.msg import Person, PersonArray
from safe_passage.ros.conversions import to_transform
from safe_passage.ros.diagnostics import Outcome
from safe_passage.ros.tracker_parameters import PersonSourceParameters
from safe_passage.ros.tracker_persons import PersonInputs, probability_of, to_person_array, view_of
from safe_passage.simulation.robots import transform
from std_msgs.msg import Header
from tracker_snapshots import PARAMETERS, POSE, POST, index_of, make_snapshot, post_is_person

HEADER = Header(frame_id="odom")
OPTICAL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
AT_POST = (POSE[0] - POST[1], POSE[1] + POST[0])  # odom
WATCHED = replace(PARAMETERS, person_sources=(PersonSourceParameters(field_of_view=1.0),))


@pytest.mark.parametrize(
    ("method", "confidence", "probability"),
    [
        (Person.METHOD_YOLO, 0.8, 0.8),
        (Person.METHOD_YOLO, 7.0, 1.0),
        (Person.METHOD_YOLO, math.nan, 0.5),
        (Person.METHOD_NONE, 0.9, 0.5),
        (Person.METHOD_LEGS, -1.0, 0.0),
        (Person.METHOD_HOG, 0.0, 0.5),
        (Person.METHOD_HOG, 1e6, 1.0),
        (Person.METHOD_HOG, -math.inf, 0.5),
    ],
)
def test_every_methods_confidence_becomes_a_probability(method, confidence, probability):
    person = Person(method=method, confidence=confidence)
    assert probability_of(person) == pytest.approx(probability, abs=1e-6)


def test_a_surer_margin_is_a_greater_probability():
    margins = [Person(method=Person.METHOD_HOG, confidence=m) for m in (-0.3, 0.0, 0.5, 2.0)]
    said = [probability_of(person) for person in margins]
    assert said == sorted(said)
    assert said[-1] > 0.95


@pytest.mark.parametrize("optical", [True, False])
def test_a_camera_looks_along_its_axis(optical):
    """Turned by 1 rad to the left and down by 0.4, in a body's or an optical frame."""
    T = transform((1.0, 2.0, 1.2), (1.0, 0.4))
    if optical:
        T[:3, :3] = T[:3, :3] @ OPTICAL
    view = view_of(T, PersonSourceParameters(field_of_view=1.2, range_min=0.7, range_max=6.0))
    assert view.origin == pytest.approx((1.0, 2.0))
    assert view.heading == pytest.approx(1.0)
    assert (view.width, view.near, view.far) == (1.2, 0.7, 6.0)


def test_where_a_detector_looks_may_be_unknown():
    assert view_of(np.eye(4), PersonSourceParameters()) is None


class Counter:
    """Stands for the diagnostics."""

    def __init__(self):
        self.counted = []

    def expect(self, name):
        raise AssertionError("a detector may be silent")

    def count(self, name, outcome, detail=""):
        self.counted.append(outcome)


class Transforms:
    """Stands for tf: every frame is a metre above odom."""

    def lookup_transform(self, target, source, stamp):
        return to_transform(Header(frame_id=target), source, np.array([1.0, 0.0, 1.0]), OPTICAL)


@pytest.fixture
def inputs(monkeypatch):
    """What takes messages in, how one comes, and what was counted."""
    told = {}
    monkeypatch.setattr(rospy, "Subscriber", lambda topic, kind, on, **_: told.update({topic: on}))
    monkeypatch.setattr(rospy.Time, "now", lambda: rospy.Time(10))
    monkeypatch.setattr(rospy, "resolve_name", lambda name: "/" + name)
    counter = Counter()
    inputs = PersonInputs(WATCHED, Transforms(), counter)
    return inputs, told["persons"], counter.counted


def array(*persons, stamp=9.8):
    header = Header(frame_id="camera", stamp=rospy.Time.from_sec(stamp))
    return PersonArray(header=header, persons=list(persons))


def person(x=0.0, z=3.0, **values):
    return Person(position=Point(x, 1.0, z), confidence=0.8, method=Person.METHOD_YOLO, **values)


def test_persons_come_in_the_odometrys_frame(inputs):
    taking, tell, counted = inputs
    tell(array(person(x=0.5)))
    (look,) = taking.take(rospy.Time(10))
    assert look.position == pytest.approx(np.array([[4.0, -0.5]]))
    assert look.probability == pytest.approx([0.8])
    assert look.stamp == pytest.approx(9.8)
    assert look.view is not None
    assert counted == [Outcome.OK]
    assert taking.take(rospy.Time(10)) == []


def test_an_empty_array_says_that_nobody_is_there(inputs):
    taking, tell, _ = inputs
    tell(array())
    (look,) = taking.take(rospy.Time(10))
    assert look.position.shape == (0, 2)
    assert look.view is not None


def test_of_an_array_with_nan_the_others_count_and_nobody_else_is_denied(inputs):
    taking, tell, counted = inputs
    tell(array(person(x=math.nan), person()))
    (look,) = taking.take(rospy.Time(10))
    assert len(look.position) == 1
    assert look.view is None
    assert counted == [Outcome.NOT_FINITE, Outcome.OK]


@pytest.mark.parametrize(
    ("message", "outcome"),
    [
        (array(person(x=math.inf)), Outcome.NOT_FINITE),
        (array(person(), stamp=8.5), Outcome.STALE),
        (array(person(), stamp=10.5), Outcome.FUTURE),
        (PersonArray(header=Header(stamp=rospy.Time(10)), persons=[person()]), Outcome.BAD_FIELDS),
    ],
)
def test_unusable_arrays_are_counted(inputs, message, outcome):
    taking, tell, counted = inputs
    tell(message)
    assert taking.take(rospy.Time(10)) == []
    assert counted == [outcome]


def test_who_has_waited_too_long_for_a_cycle_is_counted(inputs):
    taking, tell, counted = inputs
    tell(array(person()))
    assert taking.take(rospy.Time(12)) == []
    assert Outcome.STALE in counted


def test_the_trackers_own_persons_are_no_evidence(inputs):
    taking, tell, _ = inputs
    own = person()
    own.method = Person.METHOD_TRACK
    tell(array(own))
    (look,) = taking.take(rospy.Time(10))
    assert len(look.position) == 0
    assert look.view is None


def test_a_person_whom_nobody_sees_now_is_told_by_its_track():
    snapshot = make_snapshot(speed=1.0)
    (told,) = to_person_array(snapshot, post_is_person(snapshot), HEADER).persons
    i = index_of(snapshot, POST)
    assert told.id == snapshot.tracks.id[i]
    assert told.method == Person.METHOD_TRACK
    assert told.confidence == pytest.approx(0.9)
    assert (told.position.x, told.position.y, told.position.z) == (
        pytest.approx(AT_POST[0], abs=0.15), pytest.approx(AT_POST[1], abs=0.15), 0.0,
    )  # fmt: skip
    assert (told.velocity.x, told.velocity.y) == pytest.approx((0.0, 1.0), abs=0.4)
    assert told.velocity.y > 0.4
    assert told.box_pose.orientation.w == 1.0


def test_of_whom_a_camera_sees_its_own_words_are_told():
    said = Person(method=Person.METHOD_HOG, confidence=1.5, height=1.8)
    snapshot = make_snapshot()
    (told,) = to_person_array(snapshot, post_is_person(snapshot, (said,)), HEADER).persons
    assert (told.method, told.confidence) == (Person.METHOD_HOG, 1.5)
    assert told.height == pytest.approx(1.8)
    assert told.id == snapshot.tracks.id[index_of(snapshot, POST)]


def test_a_detection_without_a_track_is_passed_on():
    snapshot = make_snapshot()
    look = Look(snapshot.stamp, np.array([[1.0, 2.0]]), np.array([0.6]))
    persons = PersonLabels(PersonLabelParameters()).update(snapshot, [look])
    (told,) = to_person_array(snapshot, persons, HEADER).persons
    assert (told.id, told.position.x, told.position.y) == (0, 1.0, 2.0)
    assert math.isnan(told.velocity.x)
    assert told.confidence == pytest.approx(0.6)
