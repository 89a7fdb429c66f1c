from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.costmap.raytrace import line_indices

WIDTH, HEIGHT = 23, 17
cells = st.tuples(st.integers(0, WIDTH - 1), st.integers(0, HEIGHT - 1))


def trace(start, end, **options):
    found = line_indices(*start, np.array([end[0]]), np.array([end[1]]), WIDTH, **options)
    return [divmod(int(i), WIDTH)[::-1] for i in found[0]]


def one_step_at_a_time(start, end):
    """Textbook line with a running error, as a second opinion."""
    (x, y), dx, dy = start, end[0] - start[0], end[1] - start[1]
    flat = abs(dx) >= abs(dy)
    long, short = (abs(dx), abs(dy)) if flat else (abs(dy), abs(dx))
    sign_x, sign_y = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
    error, path = long // 2, [(x, y)]
    for _ in range(long):
        error += short
        turn = error >= long
        error -= long if turn else 0
        x += sign_x if flat or turn else 0
        y += sign_y if not flat or turn else 0
        path.append((x, y))
    return path


def test_a_gentle_slope_by_hand():
    # 5 long, 2 short: error starts at 2, turns when it reaches 5: after steps 2 and 4
    assert trace((0, 0), (5, 2)) == [(0, 0), (1, 0), (2, 1), (3, 1), (4, 2), (5, 2)]


def test_a_line_to_its_own_start_is_one_cell():
    assert trace((3, 4), (3, 4)) == [(3, 4)]


def test_stops_at_the_greatest_length():
    assert trace((0, 0), (10, 0), max_length=4)[-1] == (4, 0)
    # 12 x 5 cells are 13 long: 6.5 of 13 is half of the 12 steps
    assert len(set(trace((0, 0), (12, 5), max_length=6.5))) == 7


def test_shorter_lines_repeat_their_last_cell():
    both = line_indices(0, 0, np.array([4, 1]), np.array([0, 0]), WIDTH)
    assert both.tolist() == [[0, 1, 2, 3, 4], [0, 1, 1, 1, 1]]


@given(start=cells, end=cells)
def test_agrees_with_one_step_at_a_time(start, end):
    assert trace(start, end) == one_step_at_a_time(start, end)


def test_no_lines_at_all():
    nothing = np.array([], dtype=np.int32)
    assert line_indices(0, 0, nothing, nothing, WIDTH).size == 0
