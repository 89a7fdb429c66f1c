"""Random rooms with doors, clutter and pits: what the segmentation says of them, with a margin."""

import math

import numpy as np
import pytest
from safe_passage.evaluation.segmentation_trials import ROBOT, TrialJob, judge_trial

SEED = 4100  # another than the benchmark's
FINE_CELL = 0.01  # [m]


@pytest.fixture(scope="module")
def trials():
    return [judge_trial(TrialJob(number, SEED)) for number in range(24)]


def test_every_room_is_segmented(trials):
    assert [trial.refused for trial in trials if trial.refused] == []


def test_nothing_that_is_no_floor_is_drivable(trials):
    assert sum(trial.drivable_cells for trial in trials) > 1_000_000
    assert sum(trial.false_cells for trial in trials) == 0
    assert sum(trial.false_fits for trial in trials) < 0.001 * sum(
        trial.drivable_cells for trial in trials
    )


def test_doors_are_judged_right(trials):
    decided = [trial for trial in trials if not trial.is_close(FINE_CELL)]
    assert [trial.number for trial in decided if not trial.is_right] == []
    errors = np.array([trial.found_width - trial.width for trial in trials])
    assert np.abs(errors).max() < 0.03
    passable = [trial for trial in decided if trial.passable]
    assert np.mean([trial.map_passes for trial in passable]) > 0.7


def test_a_door_whose_frame_runs_along_the_scan_lines_is_never_said_to_be_wider_than_it_is():
    trials = [judge_trial(TrialJob(number, SEED, upright=True)) for number in range(16)]
    assert [t.number for t in trials if t.says_passable and not t.passable] == []
    assert [t.number for t in trials if t.map_passes and not t.passable] == []
    assert all(t.least_width <= t.width for t in trials)
    between_lines = 2 * math.pi / 430 * 5.0  # [m] at the farthest door
    assert all(abs(t.found_width - t.width) < between_lines for t in trials)
    wide = [t for t in trials if t.width > ROBOT.width + 2 * between_lines]
    assert len(wide) > 3 and all(t.says_passable for t in wide)


def test_planes_are_accurate(trials):
    normal = np.concatenate([trial.errors.normal for trial in trials])
    offset = np.concatenate([trial.errors.offset for trial in trials])
    assert normal.max() <= 0.4 and np.percentile(normal, 95) <= 0.15
    assert offset.max() <= 3.0
