import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from safe_passage._monitoring import ShapeAligner
from safe_passage.monitoring.ragged import Ragged
from safe_passage.monitoring.shape_alignment import align

CELL, REACH = 0.1, 0.4
aligner = ShapeAligner(CELL, REACH)


def shape(seed: int, count: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-0.4, 0.4, (count, 2))


def line(length: float, spacing: float = CELL) -> np.ndarray:
    x = np.arange(0.0, length, spacing) + 0.5 * spacing
    return np.column_stack([x, np.zeros_like(x)])


def run(seen, predicted):
    return align(
        aligner, Ragged.of([seen], np.empty((0, 2))), Ragged.of([predicted], np.empty((0, 2))), 0.1
    )


@settings(max_examples=200)
@given(st.integers(0, 10**6), st.integers(1, 40), st.integers(1, 40), st.floats(-0.3, 0.3))
def test_branch_and_bound_finds_what_trying_everything_finds(seed, n, m, shift):
    seen, known = shape(seed, n) + shift, shape(seed + 1, m)
    args = (seen, np.array([0, n]), known, np.array([0, m]))
    fast, slow = aligner.align_all(*args), aligner.align_all(*args, exhaustively=True)
    for a, b in zip(fast, slow):
        assert (a == b).all()


@settings(max_examples=50)
@given(st.integers(0, 1000), st.floats(-0.14, 0.14), st.floats(-0.14, 0.14))
def test_a_shape_that_moved_is_found_within_a_quarter_cell(seed, dx, dy):
    """By up to two cells, against where it was predicted."""
    known = shape(seed, 25)
    found = run(np.array([dx, dy]) + known, known)
    assert found.displacement[0] == pytest.approx([dx, dy], abs=0.5 * CELL / 4 + 0.013)
    assert found.overlap[0] > 0.65  # both shapes are rounded to quarter cells, each way


def test_half_of_a_shape_has_not_moved():
    """What disappears from view shifts the centroid, not the shape."""
    corner = np.concatenate([line(1.0), line(1.0)[:, ::-1]])
    found = run(corner[:12], corner)
    assert found.displacement[0] == pytest.approx([0.0, 0.0], abs=0.03)
    assert found.overlap[0] > 0.8


def test_along_a_wall_the_displacement_is_uncertain_and_across_it_is_not():
    found = run(line(5.0), line(5.0))
    assert np.sqrt(found.noise[0, 0, 0]) > 0.2
    assert np.sqrt(found.noise[0, 1, 1]) < CELL / 4


def test_a_wall_that_slides_out_of_view_seems_to_move_but_says_so():
    found = run(np.array([0.2, 0.0]) + line(5.0), line(5.0))
    assert found.displacement[0, 0] <= 3 * np.sqrt(found.noise[0, 0, 0])


def test_shapes_apart_do_not_overlap():
    found = run(shape(1, 10) + 5.0, shape(1, 10))
    assert found.overlap[0] == 0.0
    assert found.displacement[0].tolist() == [0.0, 0.0]


def test_no_shape_overlaps_nothing():
    assert run(np.empty((0, 2)), shape(1, 10)).overlap[0] == 0.0


def test_of_equal_displacements_the_shortest_is_taken():
    found = run(np.array([[0.0, 0.0]]), np.array([[0.2, 0.0], [-0.2, 0.0], [0.012, 0.012]]))
    assert np.abs(found.displacement[0]).max() < 0.04
