"""The obstacle tracker under faults: a sensor is told to be dead, nothing is where nothing is."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import rospy
from geometry_msgs.msg import Point, Vector3
from safe_passage.msg import Person, PersonArray, TrackedObstacleArray
from safe_passage.ros.conversions import to_header
from tf2_msgs.msg import TFMessage
from tracker_world import BASE, ODOM, SENSORS, TICK, WALL, World

from bench.fault_graph import NODE_TESTS
from bench.fault_subject import Input, Seen, Sent, Subject, of, silence

TRACKS, PERSONS = "tracks", "tracked_persons"
STANDS = 2.5, 0.0  # [m] odom: somebody whom all sensors but the rear one see
TIMEOUT = 0.5  # [s] of a source
TOLERANCE = 0.2  # [s] that a message waits for tf
FAR = 0.4  # [m] from what there is
NAMES = dict(zip(SENSORS, ("front", "rear", "camera")))


class Messages(World):
    """What the node's test measures, at any time; published by nobody."""

    def __init__(self) -> None:
        self._robot, self._tf = "robot1", self
        self._now = 0.0
        self.begin()
        self.people_after = lambda _: [np.array(STANDS)]

    def publish(self, transforms: list) -> None:  # as the publisher of tf
        self._told = TFMessage(transforms)

    def tf(self, stamp: rospy.Time) -> TFMessage:
        """All frames."""
        self.publish_tf(stamp)
        return self._told


class ObstacleTrackerSubject(Subject):
    """Two lidars, a camera and a detector before somebody who stands, and a wall."""

    name = "obstacle_tracker"
    launch = "obstacle_tracker.launch"
    arguments = (
        f"odom_frame:={ODOM}",
        f"base_frame:={BASE}",
        f"config:={NODE_TESTS}/obstacle_tracker.yaml",
    )
    frames = frozenset({BASE, ODOM})
    tick, pause = TICK, 0.01
    without_number = frozenset({"person_probability", "min_height", "max_height"}) | {
        "velocity", "height", "box_pose", "box_size", "confidence",  # of persons, where unknown
    }  # fmt: skip

    def __init__(self) -> None:
        self.outputs = {TRACKS: TrackedObstacleArray, PERSONS: PersonArray}
        self._world = Messages()
        self.inputs = (
            Input("tf", "/tf", TFMessage, self._world.tf, TOLERANCE, silence(TRACKS, PERSONS)),
            *(self._sensor(topic) for topic in SENSORS),
            Input(
                "persons", "persons", PersonArray, self._persons, 1.0, self.healthy, told=False,
                every=4,
            ),  # a detector is slower
        )  # fmt: skip

    def prepare(self) -> None:
        rospy.set_param("obstacle_tracker/person_sources", [{"topic": "persons"}])

    def _sensor(self, topic: str) -> Input:
        def make(stamp: rospy.Time) -> Any:
            return self._world.message(topic, stamp)

        def dead(seen: Seen) -> str:
            arrays = of(TRACKS, seen)
            index = list(NAMES).index(topic)
            alive = [a for a in arrays if a.alive[index]]
            others = [a for a in arrays if sum(a.alive) != len(SENSORS) - 1]
            if not arrays or alive or others:
                return (
                    f"of {len(arrays)} tracks {len(alive)} have it alive, {len(others)} others dead"
                )
            return self._what_stands(arrays[-1:]) if topic != "scan_front" else ""

        return Input(topic, topic, SENSORS[topic].KIND, make, TIMEOUT, dead)

    def _persons(self, stamp: rospy.Time) -> PersonArray:
        camera = SENSORS["camera/points"]
        message = PersonArray(header=to_header(stamp, self._world.frame(camera.name)))
        at = np.linalg.inv(camera.T_base_sensor) @ (*STANDS, 0.0, 1.0)
        person = Person(position=Point(*at[:3]), confidence=0.9, method=Person.METHOD_YOLO)
        person.velocity = Vector3(math.nan, math.nan, math.nan)
        message.persons.append(person)
        return message

    def healthy(self, seen: Seen) -> str:
        arrays, persons = of(TRACKS, seen), of(PERSONS, seen)
        if not arrays or not persons:
            return "no tracks or no persons"
        if not all(arrays[-1].alive):
            return f"alive {arrays[-1].alive}"
        if not any(
            math.dist((p.position.x, p.position.y), STANDS) < FAR for p in persons[-1].persons
        ):
            return "the person is not told"
        return self._what_stands(arrays[-1:])

    def _what_stands(self, arrays: list) -> str:
        """Somebody is tracked where somebody is."""
        for array in arrays:
            places = [(o.position.x, o.position.y) for o in array.obstacles if o.observed]
            if not any(math.dist(place, STANDS) < FAR for place in places):
                return f"nobody at {STANDS}: {places}"
        return ""

    def wrong(self, seen: Seen, sent: list[Sent]) -> str:
        """Something observed, or somebody, where nothing is."""
        del sent
        for array in of(TRACKS, seen):
            for one in array.obstacles:
                cells = np.stack([one.cells_x, one.cells_y], axis=1) if one.cells_x else []
                if one.observed and len(cells) and (_off(np.array(cells)) > FAR).any():
                    return f"an obstacle where nothing is: {cells[_off(np.array(cells)) > FAR][0]}"
        for array in of(PERSONS, seen):
            for person in array.persons:
                if math.dist((person.position.x, person.position.y), STANDS) > FAR:
                    return f"a person where nobody is: {person.position.x} {person.position.y}"
        return ""


def _off(cells: np.ndarray) -> np.ndarray:
    """(N,) [m] from cells (N, 2) to the person or the wall, what is nearer."""
    low, high = WALL[0][:2], WALL[1][:2]
    wall = np.linalg.norm(np.maximum(np.maximum(low - cells, cells - high), 0.0), axis=1)
    return np.minimum(wall, np.linalg.norm(cells - STANDS, axis=1) - 0.2)
