"""Tracking scenarios and their recordings: everyone keeps apart, truth and measurements agree."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from safe_passage.core.errors import InputError
from safe_passage.core.geometry import placed
from safe_passage.evaluation import tracking_recording as tr
from safe_passage.evaluation import tracking_scenarios
from safe_passage.evaluation.parallel import Workers
from safe_passage.evaluation.tracking_catalogue import NORTH, Catalogue, later, stand, walk
from safe_passage.evaluation.tracking_runs import measurements, tracker_parameters
from safe_passage.evaluation.tracking_scenarios import nominal_poses
from safe_passage.simulation.walkers import Walker

CONFIG = Path(__file__).resolve().parents[3] / "config"


@pytest.fixture(scope="module")
def catalogue():
    return Catalogue(CONFIG, 1)


@pytest.fixture(scope="module")
def driving(catalogue):
    """Two seconds of a robot that drives among people who walk."""
    return tr.record(replace(catalogue.make("crossing_driving"), seconds=2.0))


def test_every_scenario_can_be_drawn(catalogue):
    names = [scenario.name for scenario in catalogue.all()]
    assert names == list(catalogue.names())
    assert len(names) >= 12


def test_a_seed_makes_a_scenario_and_another_one_another(catalogue):
    again, other = (Catalogue(CONFIG, seed).make("past_table") for seed in (1, 2))
    assert again == catalogue.make("past_table")
    assert other.people != again.people


def test_people_who_would_collide_are_refused(catalogue, monkeypatch):
    nominal = catalogue.make("crossing_standing")
    clash = replace(nominal, people=(stand(0.0, 0.0), walk((0.0, 0.3), (0.0, 0.2))))
    monkeypatch.setattr(tracking_scenarios, "TRIES", 3)
    with pytest.raises(InputError, match="crossing_standing, seed 1"):
        tracking_scenarios.drawn(clash)


def test_a_robot_that_would_hit_something_is_refused(catalogue):
    blocked = replace(catalogue.make("static_driving"), start=(-4.6, -3.0, -NORTH), people=())
    with pytest.raises(InputError, match="drives into something"):
        tr.record(blocked)


def test_later_stands_walks_and_stands():
    walker = Walker(later((0.0, 0.0), (4.0, 0.0), 3.0, 1.0, 5.0))
    assert (walker.at(2.9).x, walker.at(2.9).stands) == (0.0, True)
    assert walker.at(5.0).x == pytest.approx(2.0)
    assert (walker.at(7.5).x, walker.at(7.5).stands) == (4.0, True)


def test_the_truth_is_where_the_beams_met_people(driving):
    """Despite drifting odometry: the truth is given as seen from the robot."""
    misses = []
    for cycle, measured in enumerate(measurements(driving, tracker_parameters(CONFIG))):
        points = np.concatenate([placed(m.points[:, :2], np.array(m.pose)) for m in measured])
        for person in driving.people[cycle, :, :2]:
            near = points[np.hypot(*(points - person).T) < 0.6]
            if len(near):
                misses.append(np.hypot(*(near.mean(axis=0) - person)))
    assert len(misses) > 80  # a scanner does not see everyone, and its outliers are filtered
    assert np.max(misses) < 0.5 and np.mean(misses) < 0.2


def test_velocities_are_those_of_the_positions(driving):
    ways = np.diff(driving.people[:, :, :2], axis=0)
    walks = np.median(ways, axis=0) / 0.04
    assert walks == pytest.approx(np.median(driving.people[:, :, 2:], axis=0), abs=0.1)


def test_scanners_take_turns(driving):
    sensors = [[raw.sensor for raw in cycle] for cycle in driving.raw]
    assert sensors[:4] == [["laser_rear"], ["laser_front"], ["laser_rear"], ["laser_front"]]
    assert np.diff(driving.stamps) == pytest.approx(0.04)


def test_merged_cycles_keep_every_measurement(driving):
    half = tr.merged(driving, 2)
    assert len(half.stamps) == len(driving.stamps) // 2 == len(half.raw)
    assert half.stamps[0] == driving.stamps[1]
    assert [raw.stamp for raw in half.raw[0]] == [0.04, 0.08]


def test_a_recording_is_the_same_every_time(driving):
    again = tr.record(driving.scenario)
    assert (again.people == driving.people).all()
    assert (again.raw[7][0].data == driving.raw[7][0].data).all()


def test_a_recording_comes_back_from_the_cache(driving, tmp_path, monkeypatch):
    monkeypatch.setattr(tr, "CACHE", tmp_path)
    (first,) = tr.recordings([driving.scenario], Workers())
    monkeypatch.setattr(tr, "record", None)
    (second,) = tr.recordings([driving.scenario], Workers())
    assert (second.visible == first.visible).all() and (second.poses == first.poses).all()
    assert [len(cycle) for cycle in second.raw] == [len(cycle) for cycle in driving.raw]
    assert (second.raw[-1][0].data == driving.raw[-1][0].data).all()
    assert second.raw[-1][0].pose == driving.raw[-1][0].pose


def test_another_definition_is_another_file(driving):
    other = replace(driving.scenario, seconds=3.0)
    assert tr.cache_file(driving.scenario) != tr.cache_file(other)


def test_who_is_behind_something_is_not_visible(catalogue):
    """A pillar 0.7 m wide; the second person stands beside it."""
    hidden = replace(
        catalogue.make("occlusion_pillars"),
        people=(stand(3.3, 1.4), stand(1.9, 1.4)),
        seconds=1.0,
    )
    assert tr.record(hidden).visible[-1].tolist() == [False, True]


def test_who_stands_has_not_moved(catalogue):
    scenario = replace(
        catalogue.make("crossing_standing"),
        people=(stand(0.0, 0.0), later((2.0, 0.0), (2.0, 2.0), 0.5, 1.0, 1.0)),
        seconds=1.0,
    )
    moved = tr.record(scenario).moved
    assert not moved[:, 0].any()
    assert not moved[:12, 1].any() and moved[13:, 1].all()


def test_clouds_are_sampled_from_depth(catalogue):
    scenario = replace(catalogue.make("fig6"), seconds=0.6)
    recording = tr.record(scenario)
    clouds = [raw for cycle in recording.raw for raw in cycle if raw.data.ndim == 2]
    assert {raw.sensor for raw in clouds} == {"camera_front", "camera_rear"}
    assert all(10000 < len(raw.data) <= tr.PIXELS for raw in clouds)


def test_nominal_poses_follow_the_program(catalogue):
    poses = nominal_poses(catalogue.make("crossing_driving"))
    assert poses[0] == pytest.approx([-2.6, -3.3, 0.0])
    assert poses[500, 0] == pytest.approx(-2.6 + 0.5 * 9.0, abs=0.35)
