from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.costmap.crossing import crossed

AHEAD = np.array([[1.0, 0.0]])


@pytest.mark.parametrize(
    "end, free",
    [
        ((2.0, 0.0), True),  # through the middle
        ((1.0, 0.0), False),  # ends in the cell
        ((0.5, 0.0), False),  # ends before it
        ((1.06, 0.0), True),  # ends just behind
        ((2.0, 0.09), True),  # grazes the upper corner: 0.0473 m above the middle where it enters
        ((2.0, 0.12), False),  # passes above
        ((-2.0, 0.0), False),  # the other way
    ],
)
def test_one_beam_and_one_cell(end, free):
    assert crossed(AHEAD, np.array([end]), size=0.1, max_range=5.0).tolist() == [free]


def test_cells_beyond_the_greatest_range_are_not_judged():
    assert not crossed(AHEAD, np.array([[2.0, 0.0]]), size=0.1, max_range=0.9).any()


def test_beams_on_both_sides_of_the_cut_of_the_angle_are_asked():
    behind = np.array([[-1.0, 0.0]])
    for y in (0.01, -0.01):
        ends = np.array([[-2.0, y], [2.0, 0.5], [2.0, -0.5]])
        assert crossed(behind, ends, size=0.1, max_range=5.0).all()


def test_no_beams_and_no_cells():
    nothing = np.empty((0, 2))
    assert not crossed(AHEAD, nothing, 0.1, 5.0).any()
    assert not crossed(AHEAD, np.zeros((3, 2)), 0.1, 5.0).any()
    assert crossed(nothing, AHEAD, 0.1, 5.0).size == 0


@given(
    centre=st.tuples(st.floats(-3, 3), st.floats(-3, 3)),
    end=st.tuples(st.floats(-5, 5), st.floats(-5, 5)),
)
def test_a_cell_said_free_has_the_beam_inside_it(centre, end):
    centre, end = np.array(centre), np.array(end)
    if crossed(centre[None], end[None], size=0.1, max_range=9.0)[0]:
        along = np.linspace(0.0, 1.0, 20001)[:, None] * end
        assert (np.abs(along - centre).max(axis=1) <= 0.051).any()
        assert np.abs(end - centre).max() >= 0.0499
