"""What judges the segmentation: Hough's lines beside ours, random rooms, planes against truth."""

import math

import numpy as np
import pytest
from safe_passage.evaluation.hough_lines import agreement, hough_segments
from safe_passage.evaluation.segmentation_places import blocked_at, garage, random_case, room
from safe_passage.evaluation.segmentation_trials import ROBOT, Trial
from safe_passage.scan_segmentation import SegmentationParameters
from safe_passage.scan_segmentation.scan import unique_cells
from safe_passage.simulation.raycast import rectangle
from safe_passage.simulation.scan_scene import Scanner, cast, scan_place

from bench.segmentation_peers import Found, ours, score

P = SegmentationParameters()
SCANNER = Scanner(lines=60)


def test_hough_finds_a_line_of_points():
    uv = np.stack([np.linspace(1.0, 2.0, 60), np.full(60, 0.5)], axis=1)
    found = hough_segments(uv, P)
    assert len(found) and np.abs(found[:, [1, 3]] - 0.5).max() < 0.03


def test_our_lines_are_houghs():
    scan, _ = scan_place(room(), SCANNER, 1)
    in_hough, in_ours = agreement(scan, P)
    assert in_hough > 0.9 and in_ours > 0.97


def test_our_planes_are_the_rooms_surfaces():
    scan, which = scan_place(room(), Scanner(), 1)
    judged = score(ours(scan), room(), Scanner(), which)
    assert judged.surfaces >= 7 and judged.wrong <= 2
    assert np.median(judged.normal) < 0.1


def test_a_plane_that_is_no_surface_is_wrong():
    scan, which = scan_place(room(), SCANNER, 1)
    slanted = np.array([[math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.3]])
    assert score(Found(0.0, slanted), room(), SCANNER, which).wrong == 1


def test_random_places_come_again_by_their_number():
    assert random_case(3, 7) == random_case(3, 7) != random_case(4, 7)
    widths = [random_case(number, 7).place.doors[0].width for number in range(40)]
    assert 0.6 <= min(widths) < 0.75 and 1.25 < max(widths) <= 1.4


def test_truth_knows_walls_lintels_and_doors():
    points = np.array([[4.05, 0.4], [4.05, 2.0], [1.0, 0.0]])
    assert blocked_at(garage(), points, 0.2, 1.4).tolist() == [False, True, False]
    assert blocked_at(garage(), points, 0.2, 2.1).tolist() == [True, True, False]


@pytest.mark.parametrize(
    "width, says, passes, right",
    [(0.9, True, True, True), (0.9, False, False, False), (0.8, False, True, False)],
)
def test_a_decision_is_right_when_neither_door_nor_map_is_wrong(width, says, passes, right):
    trial = Trial(0, "", width, width, says, passes)
    assert trial.passable == (width > ROBOT.width) and trial.is_right is right


def test_beams_meet_the_nearest_surface():
    distance, which = cast(room(), np.array([0.0, 0.0, 1.0]), np.eye(3))
    assert distance.tolist() == pytest.approx([4.0, 2.5, 1.8])
    assert len(set(which)) == 3


def test_a_rectangle_is_met_inside_and_missed_outside():
    corner, along, across = np.array([2.0, -1.0, 0.0]), np.array([0, 2.0, 0]), np.array([0, 0, 1.0])
    beams = np.array([[1.0, 0.0, 0.1], [1.0, 0.0, 0.9], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    found = rectangle(np.zeros(3), beams, corner, along, across)
    assert found.tolist() == [2.0, math.inf, math.inf, math.inf]


def test_cells_know_their_points():
    points = np.random.default_rng(0).uniform(-3.0, 3.0, (500, 3))
    cells, first, of = unique_cells(points, 0.5)
    np.testing.assert_array_equal(cells[of], np.floor(points / 0.5).astype(int))
    np.testing.assert_array_equal(of[first], np.arange(len(cells)))
    assert len(unique_cells(points[:0], 0.5)[0]) == 0
