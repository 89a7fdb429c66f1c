"""What nobody reads is not made; pictures come no oftener than they may."""

from dataclasses import replace

import numpy as np
import pytest
import rospy
from safe_passage.ros import tracker_outputs
from safe_passage.ros.fields_of_view import FieldOfView
from safe_passage.ros.tracker_outputs import TrackerOutputs
from safe_passage.ros.tracker_parameters import PersonSourceParameters
from tracker_snapshots import (
    PARAMETERS,
    POSE,
    POST,
    make_snapshot,
    nobody,
    post_is_person,
    with_moving_post,
)
from visualization_msgs.msg import Marker

VIEW = FieldOfView("laser", np.zeros(2), np.linspace(-1.0, 1.0, 9), (0.1, 30.0))


class Publisher:
    """Keeps what is published; `read` says whether somebody listens."""

    def __init__(self, topic, kind, queue_size):
        self.topic, self.read, self.messages = topic, False, []
        Publisher.all[topic] = self

    def get_num_connections(self):
        return int(self.read)

    def publish(self, message):
        self.messages.append(message)


@pytest.fixture
def publishers(monkeypatch):
    Publisher.all = {}
    monkeypatch.setattr(rospy, "Publisher", Publisher)
    return Publisher.all


@pytest.fixture(scope="module")
def snapshot():
    return with_moving_post(make_snapshot(speed=1.0))


def publish(outputs, snapshot, seconds=5.0, persons=None):
    persons = persons or nobody(snapshot)
    outputs.publish(snapshot, persons, rospy.Time.from_sec(seconds), lambda: [VIEW])


def test_nothing_is_made_for_nobody(publishers, snapshot, monkeypatch):
    for maker in ("to_tracks", "to_occupancy", "to_cells"):
        monkeypatch.setattr(tracker_outputs, maker, None)
    outputs = TrackerOutputs(PARAMETERS)
    publish(outputs, snapshot)
    assert not any(p.messages for p in publishers.values())


@pytest.mark.parametrize("topic", ["tracks", "~grid", "~cells", "~markers"])
def test_a_reader_gets_its_topic_alone(publishers, snapshot, topic):
    outputs = TrackerOutputs(PARAMETERS)
    publishers[topic].read = True
    publish(outputs, snapshot)
    assert [p.topic for p in publishers.values() if p.messages] == [topic]


@pytest.mark.parametrize(("sources", "messages"), [((), 0), ((PersonSourceParameters(),), 1)])
def test_persons_are_told_where_somebody_looks_for_them(publishers, snapshot, sources, messages):
    outputs = TrackerOutputs(replace(PARAMETERS, person_sources=sources))
    publishers["tracked_persons"].read = True
    publish(outputs, snapshot)
    assert len(publishers["tracked_persons"].messages) == messages


def test_a_person_is_a_disc_in_the_picture(publishers, snapshot):
    outputs = TrackerOutputs(PARAMETERS)
    publishers["~markers"].read = True
    publish(outputs, snapshot, persons=post_is_person(snapshot))
    (message,) = publishers["~markers"].messages
    (disc,) = (m for m in message.markers if m.ns == "person")
    assert disc.header.frame_id == PARAMETERS.odom_frame
    at = (disc.pose.position.x, disc.pose.position.y)
    assert at == pytest.approx((POSE[0] - POST[1], POSE[1] + POST[0]), abs=0.15)


def test_pictures_come_no_oftener_than_debug_rate(publishers, snapshot):
    outputs = TrackerOutputs(PARAMETERS)
    publishers["~markers"].read = publishers["tracks"].read = True
    for i in range(9):
        publish(outputs, snapshot, 5.0 + 0.025 * i)
    assert len(publishers["tracks"].messages) == 9
    assert len(publishers["~markers"].messages) == 3


def test_after_a_restart_older_stamps_are_drawn(publishers, snapshot):
    outputs = TrackerOutputs(PARAMETERS)
    publishers["~markers"].read = True
    publish(outputs, snapshot, 50.0)
    outputs.restart()
    publish(outputs, snapshot, 5.0)
    assert len(publishers["~markers"].messages) == 2


def markers_of(publishers, snapshot, cycles=1):
    outputs = TrackerOutputs(PARAMETERS)
    publishers["~markers"].read = True
    for i in range(cycles):
        publish(outputs, snapshot, 5.0 + i)
    return publishers["~markers"].messages[-1].markers


def test_the_picture_is_that_of_figure_6(publishers, snapshot):
    first, *markers = markers_of(publishers, snapshot)
    assert first.action == Marker.DELETEALL
    named = {marker.ns: marker for marker in markers}
    assert len({(marker.ns, marker.id) for marker in markers}) == len(markers)
    red, grey = named["moving"].color, named["standing"].color
    assert red.r > 2 * red.g
    assert grey.r == pytest.approx(grey.g, abs=0.05)
    assert named["field of view"].color.a < 0.2
    assert len(named["field of view"].points) == 8 * 6
    assert named["path"].header.frame_id == PARAMETERS.odom_frame
    assert named["velocity"].header.frame_id == PARAMETERS.base_frame
    assert "m/s" in named["id"].text
    assert named["sensor"].text == "laser"
    start, end = named["velocity"].points
    assert end.x - start.x > 0.4


def test_a_sector_ends_where_the_picture_does(publishers, snapshot):
    (rim,) = (m for m in markers_of(publishers, snapshot) if m.ns == "rim")
    assert max(p.x for p in rim.points) == pytest.approx(PARAMETERS.sector_radius)


def test_ways_do_not_grow_for_ever(publishers, snapshot):
    most = 1 + PARAMETERS.path_duration * PARAMETERS.debug_rate
    (path,) = (m for m in markers_of(publishers, snapshot, int(most) + 20) if m.ns == "path")
    assert len(path.points) == most


def test_the_way_of_what_is_gone_is_forgotten(publishers, snapshot):
    outputs = TrackerOutputs(PARAMETERS)
    publishers["~markers"].read = True
    publish(outputs, snapshot, 5.0)
    publish(outputs, make_snapshot(), 6.0)
    assert "path" not in {m.ns for m in publishers["~markers"].messages[-1].markers}
