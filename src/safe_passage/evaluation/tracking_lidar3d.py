"""The same tracker on a 3D lidar (paper 000, 6): how far away people are tracked."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Mapping, NamedTuple, Sequence

import numpy as np

from safe_passage.evaluation.tracking_catalogue import drive, walk
from safe_passage.evaluation.tracking_metrics import accumulate, tracked
from safe_passage.evaluation.tracking_recording import Recording
from safe_passage.evaluation.tracking_runs import Told, tracker_parameters
from safe_passage.evaluation.tracking_scenarios import Lidar3D, TrackingScenario, drawn
from safe_passage.monitoring.parameters import TrackerParameters
from safe_passage.simulation.robots import make_robot
from safe_passage.simulation.worlds import make_world

BIN = 5.0  # [m] of distance
SETTLE = 2.0  # [s] from a recording's beginning until a track can be expected
ENOUGH = 0.9  # share of cycles in which people at a distance must be tracked
YARD: Mapping[str, Any] = {
    "name": "loading yard",
    "size": [170.0, 60.0],
    "start": [-10.0, 0.0, 0.0],
    "boxes": [
        {"x": 20.0, "y": 14.0, "size": [12.0, 2.5, 2.6], "material": "metal"},  # containers
        {"x": 42.0, "y": -16.0, "yaw": 0.3, "size": [12.0, 2.5, 2.6], "material": "metal"},
        {"x": -25.0, "y": -12.0, "yaw": 1.3, "size": [6.0, 2.5, 2.6], "material": "metal"},
        *({"x": x, "y": 10.0, "size": [0.3, 0.3, 4.0]} for x in range(-20, 70, 10)),  # lamps
        *({"x": x, "y": -10.5, "size": [0.3, 0.3, 4.0]} for x in range(-20, 70, 10)),
    ],
    "pallets": [{"x": 12.0, "y": -7.0, "goods": 1.0}, {"x": 27.0, "y": 7.5, "goods": 0.6}],
}
VELODYNE = Lidar3D()  # like an HDL-32E


def lidar3d_scenario(seed: int, seconds: float = 24.0) -> TrackingScenario:
    """A robot drives through a yard; people walk away from it and towards it, to 65 m and more."""
    robot = make_robot(
        {
            "name": "carrier",
            "footprint": [[0.5, 0.3], [-0.5, 0.3], [-0.5, -0.3], [0.5, -0.3]],
            "height": 1.1,
            "parts": [{"z": 0.1, "size": [0.9, 0.5, 0.6]}],
        }
    )
    people = (
        walk((-4.0, 2.0), (60.0, 5.0), speed=1.4),
        walk((20.0, -2.5), (60.0, -5.0), speed=1.4),
        walk((58.0, 1.5), (0.0, -1.5), speed=1.4),
        walk((35.0, 6.0), (38.0, -8.0), speed=1.1),
    )
    nominal = TrackingScenario(
        *("lidar3d", seed, seconds, make_world(YARD), robot, people, (-10.0, 0.0, 0.0)),
        program=(drive(20.0, 0.3),),
        reach=75.0,
        lidar3d=VELODYNE,
        cycle_steps=VELODYNE.steps,
    )
    return drawn(nominal)


def lidar3d_parameters(config: Path) -> TrackerParameters:
    """For such a lidar: coarser cells, as its points lie farther apart, and a wider grid.

    Args:
        config: folder of the package's parameters.
    """
    return tracker_parameters(config, name="obstacle_tracker_lidar3d")


class Bin(NamedTuple):
    """People at distances up to `end` [m], from BIN nearer on."""

    end: float
    there: int  # person-cycles
    found: int  # of them with a track that is told as moving


def recall_by_distance(recording: Recording, cycles: Sequence[Told]) -> list[Bin]:
    """Who was tracked how far from the robot; the recording's first SETTLE do not count."""
    events = tracked(accumulate(recording, cycles))
    found = np.zeros(recording.moved.shape, bool)
    frames = events.index.get_level_values(0).to_numpy(int)
    found[frames, events.OId.to_numpy(int)] = True
    settled = recording.stamps > recording.stamps[0] + SETTLE
    there = recording.moved & settled[:, None]
    found &= there
    offset = recording.people[:, :, :2] - recording.poses[:, None, :2]
    number = np.floor(np.hypot(offset[..., 0], offset[..., 1]) / BIN).astype(int)
    return [
        Bin((k + 1) * BIN, int(there[number == k].sum()), int(found[number == k].sum()))
        for k in range(int(number.max(initial=-1)) + 1)
    ]


def tracked_range(bins: Sequence[Bin]) -> float:
    """[m] up to which people were tracked in ENOUGH of the cycles at every distance; 0: nowhere."""
    reached = 0.0
    for one in bins:
        if one.there and one.found < ENOUGH * one.there:
            break
        reached = one.end if one.there else reached
    return reached
