"""Moving obstacles for TEB and for the social layers, with stand-ins for their messages."""

import math
import sys
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

import pytest
import rospy
from geometry_msgs.msg import Point, Polygon, Quaternion, TwistWithCovariance
from safe_passage.ros.tracker_bridges import make_bridges
from std_msgs.msg import Header
from tracker_snapshots import (
    POSE,
    POST,
    index_of,
    make_snapshot,
    nobody,
    post_is_person,
    with_moving_post,
)

HEADER = Header(frame_id="odom")


@dataclass
class ObstacleMsg:
    """The fields of costmap_converter/ObstacleMsg."""

    header: Header = field(default_factory=Header)
    polygon: Polygon = field(default_factory=Polygon)
    radius: float = 0.0
    id: int = 0
    orientation: Quaternion = field(default_factory=Quaternion)
    velocities: TwistWithCovariance = field(default_factory=TwistWithCovariance)


@dataclass
class ObstacleArrayMsg:
    """The fields of costmap_converter/ObstacleArrayMsg."""

    header: Header
    obstacles: list = field(default_factory=list)


@dataclass
class Person:
    """The fields of people_msgs/Person."""

    name: str = ""
    position: Any = field(default_factory=Point)
    velocity: Any = field(default_factory=Point)
    reliability: float = 0.0
    tagnames: list = field(default_factory=list)
    tags: list = field(default_factory=list)


@dataclass
class People:
    """The fields of people_msgs/People."""

    header: Header
    people: list = field(default_factory=list)


@pytest.fixture
def packages(monkeypatch):
    """Pretends that packages with these messages are installed."""
    topics = []
    monkeypatch.setattr(
        rospy, "Publisher", lambda topic, kind, queue_size: topics.append(topic) or topic
    )

    def install(name, *messages):
        module = ModuleType(name + ".msg")
        for message in messages:
            setattr(module, message.__name__, message)
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
        monkeypatch.setitem(sys.modules, name + ".msg", module)
        return topics

    return install


@pytest.fixture(scope="module")
def snapshot():
    return with_moving_post(make_snapshot(speed=1.0))


def test_without_the_packages_there_is_no_bridge(packages):
    assert make_bridges() == []


def test_teb_gets_what_moves_with_its_velocity_in_odom(packages, snapshot):
    topics = packages("costmap_converter", ObstacleMsg, ObstacleArrayMsg)
    (bridge,) = make_bridges()
    assert topics == ["~obstacles"]
    array = bridge.make(snapshot, nobody(snapshot), HEADER)
    assert array.header.frame_id == "odom"
    (obstacle,) = array.obstacles  # the wall stands: it is in TEB's costmap
    i = index_of(snapshot, POST)
    assert obstacle.id == snapshot.tracks.id[i]
    forward, left = snapshot.tracks.velocity[i]
    linear = obstacle.velocities.twist.linear
    assert (linear.x, linear.y) == pytest.approx((-left, forward))  # base looks along odom's y
    assert linear.y > 0.4
    corners = [(p.x, p.y) for p in obstacle.polygon.points]
    assert len(corners) >= 4
    middle = [sum(c) / len(corners) for c in zip(*corners)]
    assert middle == pytest.approx((POSE[0] - POST[1], POSE[1] + POST[0]), abs=0.2)
    assert obstacle.orientation.w == 1.0


def test_people_are_what_moves(packages, snapshot):
    topics = packages("people_msgs", People, Person)
    (bridge,) = make_bridges()
    assert topics == ["people"]
    message = bridge.make(snapshot, nobody(snapshot), HEADER)
    (person,) = message.people
    assert person.name == str(snapshot.tracks.id[index_of(snapshot, POST)])
    at = (person.position.x, person.position.y)
    assert at == pytest.approx((POSE[0] - POST[1], POSE[1] + POST[0]), abs=0.15)
    assert person.velocity.y > 0.4
    assert math.isfinite(person.reliability)


def test_nothing_moves_nobody_is_told(packages):
    packages("people_msgs", People, Person)
    (bridge,) = make_bridges()
    snapshot = make_snapshot()
    assert bridge.make(snapshot, nobody(snapshot), HEADER).people == []


def test_a_person_who_stands_is_told_too(packages):
    packages("people_msgs", People, Person)
    (bridge,) = make_bridges()
    snapshot = make_snapshot()
    (person,) = bridge.make(snapshot, post_is_person(snapshot), HEADER).people
    assert person.name == str(snapshot.tracks.id[index_of(snapshot, POST)])
