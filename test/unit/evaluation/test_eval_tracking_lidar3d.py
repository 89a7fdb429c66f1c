"""How far away a 3D lidar's people are tracked."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from safe_passage.evaluation import tracking_lidar3d as l3
from safe_passage.evaluation.tracking_recording import Recording, record
from safe_passage.evaluation.tracking_runs import Told, measurements

CONFIG = Path(__file__).resolve().parents[3] / "config"


@pytest.fixture(scope="module")
def scenario():
    return l3.lidar3d_scenario(1, seconds=6.0)


def walking_away(scenario, cycles: int) -> Recording:
    """One person, 1 m farther away every cycle of 1 s."""
    way = np.zeros((cycles, 1, 4))
    way[:, 0, 0] = np.arange(cycles) + 0.5
    yes = np.ones((cycles, 1), bool)
    return Recording(
        scenario, np.arange(cycles) * 1.0, np.zeros((cycles, 3)), way, yes, yes, ((),) * cycles
    )


def told(x: float, moving: bool) -> Told:
    one = np.ones(1, bool)
    return Told(np.array([3]), np.array([[x, 0.0]]), np.zeros((1, 2)), one & moving, one)


def test_range_ends_where_people_are_lost(scenario):
    recording = walking_away(scenario, 20)
    bins = l3.recall_by_distance(recording, [told(t + 0.5, t < 13) for t in range(20)])
    # the first two seconds do not count, the third bin is only tracked to 13 m
    assert bins == [(5.0, 2, 2), (10.0, 5, 5), (15.0, 5, 3), (20.0, 5, 0)]
    assert l3.tracked_range(bins) == 10.0


def test_a_gap_nearby_counts():
    assert l3.tracked_range([l3.Bin(5.0, 10, 8), l3.Bin(10.0, 10, 10)]) == 0.0


def test_distances_without_people_do_not_count():
    bins = [l3.Bin(5.0, 0, 0), l3.Bin(10.0, 10, 9), l3.Bin(15.0, 0, 0), l3.Bin(20.0, 4, 4)]
    assert l3.tracked_range(bins) == 20.0
    assert l3.tracked_range([]) == 0.0


def test_rays_are_unit_vectors_of_all_rings(scenario):
    rays = l3.VELODYNE.directions()
    assert rays.shape == (32 * 1800, 3)
    assert np.linalg.norm(rays, axis=1) == pytest.approx(1.0)
    assert np.arcsin(rays[[0, -1], 2]) == pytest.approx(np.radians([-30.67, 10.67]), abs=1e-4)


def test_a_recording_holds_clouds_with_people_in_them(scenario):
    recording = record(replace(scenario, seconds=0.5))
    assert np.diff(recording.stamps) == pytest.approx(0.1)
    assert recording.visible[-1].all()
    (last,) = measurements(recording, l3.lidar3d_parameters(CONFIG))[-1]
    position = recording.people[-1, :, :2] - recording.poses[-1, :2]
    for person in position[np.hypot(*position.T) < 40.0]:
        near = last.points[np.hypot(*(last.points[:, :2] - person).T) < 0.6]
        assert len(near) >= 2
        assert 0.2 < near[:, 2].max() < 2.1


def test_the_yaml_is_that_lidars(scenario):
    parameters = l3.lidar3d_parameters(CONFIG)
    assert [source.name for source in parameters.sources] == [l3.VELODYNE.name]
    assert parameters.footprint == scenario.robot.footprint
    assert parameters.radius == scenario.reach
