"""Where a box fits on maps that are drawn by hand, and on a kernel's."""

import math

import numpy as np
import pytest
import safe_passage._scan_segmentation as kernels
from hypothesis import given, settings
from hypothesis import strategies as st
from safe_passage.scan_segmentation import (
    Colour,
    ColourMap,
    RobotConfiguration,
    SegmentationParameters,
)
from safe_passage.scan_segmentation.traversability import (
    check_traversability,
    fine_map,
    orientations,
    rough_maps,
)

P = SegmentationParameters(fine_cell=0.02, orientations=12)


def basic(size=(4.0, 4.0), fine=0.02) -> ColourMap:
    shape = round(size[1] / fine), round(size[0] / fine)
    cells = np.full(shape, Colour.GREEN, np.uint8)
    return ColourMap(cells, np.zeros(2), fine)


def with_door(width, thick=0.1, yaw_cells=0) -> ColourMap:
    """A wall at x = 2 m with an opening in its middle."""
    made = basic()
    half = round(0.5 * width / made.resolution)
    columns = slice(round(2.0 / made.resolution), round((2.0 + thick) / made.resolution))
    made.cells[:, columns] = Colour.RED
    made.cells[100 - half : 100 + half, columns] = Colour.GREEN
    return made


def passes(found: ColourMap) -> bool:
    """Whether drivable cells lead from the left to the right of the wall."""
    drivable = np.isin(found.cells, (Colour.GREEN, Colour.ORANGE))
    return bool(drivable[:, 100:105].any(axis=0).all())


@pytest.mark.parametrize("width, fits", [(0.80, False), (0.84, False), (0.88, True), (1.0, True)])
def test_a_robot_passes_doors_that_are_wider(width, fits):
    robot = RobotConfiguration(length=1.2, width=0.85)
    assert passes(check_traversability(with_door(width), robot, [0.0], P)) is fits


def test_a_margin_is_kept_on_both_sides():
    robot = RobotConfiguration(length=1.2, width=0.85, margin=0.05)
    assert not passes(check_traversability(with_door(0.92), robot, [0.0], P))
    assert passes(check_traversability(with_door(0.98), robot, [0.0], P))


def test_a_narrow_way_is_orange_and_a_wide_one_green():
    robot = RobotConfiguration(length=1.2, width=0.85)
    narrow = check_traversability(with_door(0.90), robot, [0.0], P).cells[:, 100:105]
    assert (narrow == Colour.ORANGE).any() and not (narrow == Colour.GREEN).any()
    wide = check_traversability(with_door(1.6), robot, [0.0], P).cells[:, 100:105]
    assert (wide == Colour.GREEN).any()


def test_unknown_is_not_traversable():
    made = basic()
    made.cells[:, 100] = Colour.UNKNOWN
    found = check_traversability(made, RobotConfiguration(), [], P)
    assert not passes(found) and (found.cells[:, 100] == Colour.UNKNOWN).all()


def test_low_obstacles_are_driven_over_with_care():
    made = basic()
    made.cells[100, 100] = Colour.ORANGE
    found = check_traversability(made, RobotConfiguration(), [], P)
    assert found.cells[100, 100] == Colour.ORANGE


def test_the_robots_centre_stays_off_walls_by_half_its_width():
    found = check_traversability(with_door(0.0), RobotConfiguration(), [0.0], P)
    drivable = np.isin(found.cells, (Colour.GREEN, Colour.ORANGE))
    last = np.flatnonzero(drivable[:, :100].any(axis=0)).max()
    assert 100 - last == pytest.approx(0.425 / 0.02, abs=1.5)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10_000), st.floats(0.1, 0.6), st.floats(0.3, 1.2), st.integers(1, 60))
def test_two_resolutions_say_what_the_fine_one_says(seed, width, length, count):
    """The door trick saves work and changes no answer: neither a way lost nor one made up."""
    rng = np.random.default_rng(seed)
    blocked = np.zeros((100, 100), bool)
    blocked[rng.integers(0, 100, count), rng.integers(0, 100, count)] = True
    robot = RobotConfiguration(length=length, width=width)
    angles = orientations([], P)
    rough = rough_maps(blocked, robot, angles, 5, 0.02)
    fine = fine_map(blocked, rough.undecided, robot, angles, 5, 0.02)
    both = np.kron(rough.free, np.ones((5, 5))).astype(bool) | fine
    alone = fine_map(blocked, np.ones_like(rough.free), robot, angles, 5, 0.02)
    np.testing.assert_array_equal(both, alone)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 1000), st.floats(0.0, math.pi), st.floats(0.5, 12.0), st.floats(0.5, 12.0))
def test_the_box_is_the_box(seed, angle, half_length, half_width):
    rng = np.random.default_rng(seed)
    blocked = np.zeros((40, 40), np.uint8)
    blocked[rng.integers(0, 40, 8), rng.integers(0, 40, 8)] = 1
    at = np.argwhere(np.ones((40, 40))).astype(np.int32)
    found = np.array(kernels.fit_box(blocked, at, [angle], [half_length], [half_width])) >= 0
    row, column = np.nonzero(np.pad(blocked, 20, constant_values=1))
    dy, dx = (row - 20)[None] - at[:, :1], (column - 20)[None] - at[:, 1:]
    along = np.abs(math.cos(angle) * dx + math.sin(angle) * dy) - half_length
    across = np.abs(math.cos(angle) * dy - math.sin(angle) * dx) - half_width
    surely_hit = ((along < -1e-6) & (across < -1e-6)).any(axis=1)
    surely_free = ~((along < 1e-6) & (across < 1e-6)).any(axis=1)
    assert not found[surely_hit].any()
    # beyond the border spans of whole rows count, so a little more than the box
    inner = (np.abs(at - 20) < 20 - half_length - half_width - 1).all(axis=1)
    assert found[surely_free & inner].all()


def test_walls_give_orientations_along_and_across_them():
    found = orientations([0.3], P)
    assert np.abs(found - 0.3).min() < 1e-3
    assert np.abs(found - 0.3 - math.pi / 2).min() < 1e-3
    assert (found >= 0.0).all() and (found <= math.pi).all()


def drawn(vertex, gap=5.0, z=None) -> np.ndarray:
    """Three lines of three points, 4 cells apart, drawn on a map."""
    y, x = np.mgrid[2:13:4, 2:13:4].astype(float)
    xyz = np.stack([x, y, np.zeros((3, 3)) if z is None else z], axis=-1)
    out = np.zeros((14, 14), np.uint8)
    kernels.draw_ground(xyz, np.array(vertex, np.uint8), False, 1.5 * gap, 1.0, out)
    return out


def test_ground_lies_between_ground_points_and_nowhere_else():
    found = drawn([[1, 1, 1]] * 3)
    assert (found[2:10, 2:10] == 1).all() and found.sum() == 64


def test_a_lost_point_leaves_a_hole():
    found = drawn([[1, 1, 1], [1, 0, 1], [1, 1, 1]])
    assert found[6, 6] == 0 and 0 < found.sum() < 64


def test_ground_points_far_apart_have_nothing_between_them():
    assert drawn([[1, 1, 1]] * 3, gap=2.0).sum() == 0


def test_a_step_between_ground_points_is_no_ground():
    z = np.array([[0.0, 0.0, 20.0]] * 3)
    found = drawn([[1, 1, 1]] * 3, z=z)
    assert (found[2:10, 2:6] == 1).all() and (found[:, 6:] == 0).all()


def test_feet_are_marked_apart():
    found = drawn([[1, 1, 2]] * 3)
    assert (found[2:10, 2:6] == 1).all() and (found[2:10, 6:10] == 2).all()


def test_rays_pass_over_all_cells_on_their_way_and_stay_on_the_map():
    out = np.zeros((10, 10), np.uint8)
    kernels.draw_rays(
        np.array([[0.5, 0.5], [5.0, 5.0]]), np.array([[9.5, 0.5], [50.0, np.nan]]), out
    )
    assert (out[0] == 1).all() and out[1:].sum() == 0
