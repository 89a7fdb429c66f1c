"""Real recordings: their format, here with somebody who walks past a wall, exactly."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from safe_passage.core.geometry import matrix, placed
from safe_passage.evaluation import tracking_real as real
from safe_passage.evaluation.scan_matching import match_scans
from safe_passage.evaluation.tracking_real_plots import draw_run
from safe_passage.evaluation.tracking_real_report import as_markdown, as_values, judge_all, sums
from safe_passage.evaluation.tracking_real_truth import linked, newcomers, persons_of_legs
from safe_passage.leg_detection.scan import Scan
from safe_passage.simulation import raycast

CONFIG = Path(__file__).resolve().parents[3] / "config"
BEAMS, STEP = 541, np.radians(0.5)
WALLS = [([-3.0, 2.9, 0.0], [6.0, 3.1, 2.0]), ([5.0, -4.0, 0.0], [5.2, 3.0, 2.0])]  # [m] corners
PILLAR = ([1.0, -2.2, 0.0], [1.3, -1.8, 2.0])
EVERY = 0.1  # [s]


def scan(i, pose=(0.0, 0.0, 0.0), person=None):
    """By a scanner at the origin of base."""
    angles = -np.radians(135) + STEP * np.arange(BEAMS)
    T = matrix(pose)
    rays = np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1) @ T[:3, :3].T
    origin = T[:3, 3] + [0.0, 0.0, 0.3]
    found = [raycast.box(origin, rays, *map(np.array, box)) for box in (*WALLS, PILLAR)]
    if person is not None:
        low, high = np.array([*person, 0.0]), np.array([*person, 1.5])
        found.append(raycast.capsule(origin, rays, low, high, 0.15))
    ranges = np.min(found, axis=0)
    return Scan(ranges, angles[0], STEP, 0.1, 20.0, 100.0 + EVERY * i)


def walker(i):
    return np.array([3.0, -2.5 + 0.1 * i])


def recording(scans, truth, **more):
    scanner = real.RealScanner("laser", scans, legs=more.pop("legs", None))
    return real.RealRecording("tiny", "obstacle_tracker_single_lidar", truth, (scanner,), **more)


def walk(cycles=50):
    return [scan(i, person=walker(i)) for i in range(cycles)]


def test_who_walks_is_found_by_marked_legs_with_one_identity(tmp_path):
    legs = [walker(i)[None] + [[-0.1, 0.1], [-0.1, -0.1]] for i in range(50)]
    ran, truth, result = real.judge(recording(walk(), real.LEGS, legs=legs), CONFIG)
    assert (result.movers, result.found, result.ids) == (1, 1, 1)
    assert result.mover_cycles == 45  # the first half metre does not count
    assert result.tracked >= 38
    assert result.error < 0.2
    assert result.static_tracks >= 1
    assert result.false_moving == 0
    assert "| tiny | marked legs | 5 | 50 |" in as_markdown([result])
    draw_run(ran, truth, tmp_path / "tiny.png")
    assert (tmp_path / "tiny.png").stat().st_size > 1000


def test_without_marks_it_is_what_came():
    _, truth, result = real.judge(recording(walk(), real.CAME), CONFIG)
    assert (result.movers, result.found) == (1, 1)
    away = np.hypot(*(truth.people[:, 0] - [walker(i) for i in range(50)]).T)
    assert np.nanmax(away) < 0.25


def test_another_vehicle_has_a_speed():
    way = np.array([[100.0 + EVERY * i, *walker(i), np.pi / 2] for i in range(50)])
    _, _, result = real.judge(recording(walk(), real.VEHICLE, vehicle=way), CONFIG)
    assert result.found == 1
    assert result.speed_error < 0.3


def test_a_robot_that_drives_alone_sees_nothing_move():
    poses = [(0.04 * i, 0.0, 0.01 * i) for i in range(40)]
    scans = [scan(i, pose) for i, pose in enumerate(poses)]
    way = match_scans(scans)
    assert np.hypot(*(way[-1, 1:3] - poses[-1][:2])) < 0.03
    assert way[-1, 3] == pytest.approx(poses[-1][2], abs=0.01)
    result = real.judge(recording(scans, real.NOBODY, way=way), CONFIG)[2]
    assert (result.movers, result.false_moving) == (0, 0)
    assert result.static_tracks >= 3


def test_after_a_gap_the_tracker_begins_anew():
    scans = walk(20)
    later = [replace(one, stamp=one.stamp + 60.0) for one in scans]
    ran = real.judge(recording([*scans, *later], real.CAME), CONFIG)[0]
    before, after = ran.told[19], ran.told[25]
    assert len(after.id)
    assert not set(before.id) & set(after.id)


def test_cycles_are_the_first_scanners_with_the_others_since():
    front = real.RealScanner("laser_front", [scan(i) for i in range(3)])
    rear = [replace(scan(i), stamp=100.0 + EVERY * i - 0.05) for i in range(3)]
    both = real.RealRecording(
        "two", "obstacle_tracker", real.CAME, (front, real.RealScanner("laser_rear", rear))
    )
    assert [cycle.scans for cycle in real.cycles_of(both)] == [
        tuple((scanner, number) for scanner in (0, 1)) for number in range(3)
    ]
    names = [source.name for source in real.parameters_for(both, CONFIG).sources]
    assert names == ["laser_front", "laser_rear"]


def test_two_legs_are_a_person_one_is_too():
    found = persons_of_legs(np.array([[1.0, 0.0], [1.0, 0.3], [4.0, 0.0]]))
    assert sorted(found.tolist()) == [[1.0, 0.15], [4.0, 0.0]]
    assert persons_of_legs(np.empty((0, 2))).shape == (0, 2)


def test_what_most_scans_show_is_furniture():
    found = newcomers(walk(30))
    assert [len(one.persons) for one in found] == [1] * 30
    assert len(newcomers([scan(i) for i in range(5)])[0].points) == 0


def test_people_are_linked_by_nearness():
    stamps = np.arange(6) * 0.2
    a, b = [0.0, 0.0], [3.0, 0.0]
    places = [[a, b], [[0.2, 0.0], b], [b], [[0.6, 0.0], b], [b], []]
    truth = linked(stamps, [np.array(one, float).reshape(-1, 2) for one in places])
    assert truth.people.shape == (6, 2, 2)
    assert truth.visible[:, 0].tolist() == [True, True, False, True, False, False]
    assert truth.moved[:, 0].tolist() == [False, False, False, True, True, True]
    assert not truth.moved[:, 1].any()
    nobody = linked(stamps, [np.empty((0, 2))] * 6)
    assert nobody.moved.shape == (6, 0)


def test_who_was_away_for_long_is_somebody_else():
    stamps = np.array([0.0, 0.2, 5.0])
    truth = linked(stamps, [np.zeros((1, 2))] * 3)
    assert truth.visible.tolist() == [[True, False], [True, False], [False, True]]


def test_placed_in_the_odometrys_frame():
    way = np.array([[100.0, 1.0, 0.0, 0.0], [102.0, 3.0, 0.0, 0.0]])
    assert real.pose_at(way, 101.0) == (2.0, 0.0, 0.0)
    assert placed(np.zeros((1, 2)), real.pose_at(np.empty((0, 4)), 5.0)).tolist() == [[0.0, 0.0]]


def test_sums_are_over_what_tells_the_same(tmp_path):
    results = judge_all([recording(walk(), real.CAME)], CONFIG, tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["tiny.png"]
    (only,) = results
    found = sums(results)
    assert found["came_tracked"] == only.tracked / only.mover_cycles
    assert found["false_moving_share_standing"] == 0.0
    assert np.isnan(found["false_moving_share_driving"])
    assert np.isnan(found["walkers_tracked"])
    assert as_values(results)["recordings"]["tiny"]["truth"] == real.CAME
    assert all(np.isnan(value) for value in sums([]).values())
