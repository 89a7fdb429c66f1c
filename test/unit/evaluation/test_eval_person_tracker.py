"""The tracker in the closed loop: set up as on the robot, and its persons are remembered."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from safe_passage.core.errors import InputError
from safe_passage.core.reading import read_yaml
from safe_passage.evaluation.human_safety_chain import VIEW
from safe_passage.evaluation.person_tracker import PersonTracker
from safe_passage.evaluation.setting import Setting
from safe_passage.evaluation.tracking_runs import scan_measurement
from safe_passage.monitoring.person_looks import Look

SETTING = Setting.of(Path(__file__).resolve().parents[3] / "config")
ODOM = (0.0, 0.0, 0.0)


def overlay():
    return read_yaml(SETTING.robot)["obstacle_tracker"]


def test_it_is_set_up_as_on_the_robot():
    tracker, _ = SETTING.load_tracker()
    assert [source.name for source in tracker.sources] == ["laser"]
    assert tracker.resolution == overlay()["resolution"]
    camera = overlay()["person_sources"][0]
    assert (camera["field_of_view"], camera["range_min"], camera["range_max"]) == VIEW


def test_a_tracker_without_a_lidar_is_refused(tmp_path):
    robot = read_yaml(SETTING.robot)
    robot["obstacle_tracker"]["sources"] = []
    path = tmp_path / "blind.yaml"
    path.write_text(yaml.safe_dump(robot))
    with pytest.raises(InputError, match="blind.yaml: .*LaserScan"):
        Setting(SETTING.world, path, SETTING.costmap, SETTING.tracker).load_tracker()


def test_who_was_seen_once_is_told_as_long_as_the_lidar_meets_him():
    _, robot = SETTING.load()
    lidar = robot.lidars[0]
    person = np.array([[2.0, 0.0]])
    ranges = np.full(lidar.beams, np.inf)
    ranges[np.abs(lidar.angles()) < 0.08] = 2.0 - lidar.x
    tracker = PersonTracker(*SETTING.load_tracker())
    for cycle in range(40):
        now = 0.1 * cycle
        looks = [Look(now, person, np.array([0.9]))] if cycle == 20 else []
        scan = scan_measurement(lidar, ranges, tracker.source, now, ODOM)
        told = tracker.update(now, ODOM, [scan], looks)
        assert len(told) == (1 if cycle >= 20 else 0)
    assert np.allclose(told[0].position[:2], person[0], atol=0.2)
