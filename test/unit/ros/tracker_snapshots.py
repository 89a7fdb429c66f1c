"""A wall and a post beside it, tracked; the tests say which of them moves."""

import dataclasses

import numpy as np
from safe_passage.core.geometry import placed
from safe_passage.monitoring.aggregation import Measurement
from safe_passage.monitoring.parameters import CLOUD, SourceParameters
from safe_passage.monitoring.person_looks import Look
from safe_passage.monitoring.persons import PersonLabelParameters, PersonLabels
from safe_passage.monitoring.pipeline import ObstacleTracker
from safe_passage.ros.tracker_parameters import TrackerNodeParameters

PARAMETERS = TrackerNodeParameters(
    sources=(SourceParameters("laser"), SourceParameters("camera", type=CLOUD)),
    footprint=((0.3, 0.2), (-0.3, 0.2), (-0.3, -0.2), (0.3, -0.2)),
    radius=4.0,
)
POSE = (10.0, 5.0, np.pi / 2)  # of base in odom: its x axis is odom's y
POST = (2.0, 1.0)  # [m] base
HEIGHTS = 0.3, 1.2  # [m] of the post
WALL_X = -2.0  # [m] base


def make_snapshot(speed=0.0, alive=("laser", "camera")):
    """After ten cycles; the post, seen by both sensors, moves along base's x axis [m/s]."""
    tracker = ObstacleTracker(PARAMETERS)
    wall = np.stack([np.full(100, WALL_X), np.linspace(-2.0, 2.0, 100), np.full(100, 0.2)], axis=1)
    offset = np.mgrid[-0.1:0.11:0.05, -0.1:0.11:0.05].reshape(2, -1).T
    for i in range(10):
        at = POST + np.array([0.1 * (i - 9) * speed, 0.0]) + offset
        low, high = (np.insert(at, 2, height, axis=1) for height in HEIGHTS)
        points = {"laser": np.concatenate([wall, low]), "camera": np.concatenate([low, high])}
        measurements = [Measurement(name, 0.1 * i, POSE, points[name]) for name in alive]
        snapshot = tracker.update(0.1 * i, POSE, measurements)
    return snapshot


def nobody(snapshot):
    """No detector has ever spoken."""
    return PersonLabels(PersonLabelParameters()).update(snapshot, [])


def post_is_person(snapshot, said=()):
    """A detector has seen a person where the post is."""
    at = placed(np.array([POST]), POSE)
    look = Look(snapshot.stamp, at, np.array([0.9]), said=said)
    return PersonLabels(PersonLabelParameters()).update(snapshot, [look])


def index_of(snapshot, place):
    """The track nearest to `place` [m]."""
    return int(np.argmin(np.hypot(*(snapshot.tracks.position - place).T)))


def with_moving_post(snapshot):
    """The same, the post moving and nothing else."""
    moving = np.zeros(len(snapshot.tracks), bool)
    moving[index_of(snapshot, POST)] = True
    return dataclasses.replace(snapshot, tracks=dataclasses.replace(snapshot.tracks, moving=moving))
