"""Where tf has gaps, however its messages come in."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.ros.sampled_transforms import SampleGaps

LONGEST = 0.2  # [s]


def gaps_of(stamps, parent="base", child="turning"):
    gaps = SampleGaps(LONGEST)
    for stamp in stamps:
        gaps.note(parent, child, stamp)
    return gaps


def test_between_neighbours_that_are_near_there_is_none():
    gaps = gaps_of([1.0, 1.1, 1.2])
    assert all(not gaps.gap("base", "turning", t) for t in (0.5, 1.0, 1.15, 1.2, 9.0))


def test_a_gap_is_told_with_frame_and_length_and_its_ends_are_no_part_of_it():
    gaps = gaps_of([1.0, 2.5])
    assert gaps.gap("base", "turning", 1.7) == "tf of turning was not told for 1.50 s"
    assert gaps.gap("turning", "base", 1.7)
    assert not gaps.gap("base", "turning", 1.0)
    assert not gaps.gap("base", "turning", 2.5)


def test_frames_beside_the_way_do_not_matter():
    gaps = gaps_of([1.0, 2.5], "map", "base")
    for stamp in (1.0, 1.1):
        gaps.note("base", "turning", stamp)
        gaps.note("base", "mast", stamp)
    assert not gaps.gap("mast", "turning", 1.7)
    assert gaps.gap("map", "turning", 1.7)


def test_another_parent_begins_anew():
    gaps = gaps_of([1.0, 2.5])
    gaps.note("trolley", "turning", 2.6)
    assert not gaps.gap("trolley", "turning", 1.7)


def test_a_circle_of_frames_ends():
    gaps = gaps_of([1.0, 2.5], "a", "b")
    gaps.note("b", "a", 1.0)
    gaps.gap("a", "nowhere", 1.7)


def test_forgotten():
    gaps = gaps_of([1.0, 2.5])
    gaps.clear()
    assert not gaps.gap("base", "turning", 1.7)


@given(st.lists(st.integers(0, 40), min_size=1, max_size=30), st.integers(-5, 205))
def test_any_order_tells_the_same(tenths, at):
    stamps, stamp = [0.1 * t for t in tenths], 0.02 * at + 0.005
    before = max((s for s in stamps if s < stamp), default=None)
    after = min((s for s in stamps if s > stamp), default=None)
    told = gaps_of(stamps).gap("base", "turning", stamp)
    within = before is not None and after is not None and after - before > LONGEST + 1e-9
    if within and after - before == pytest.approx(LONGEST):
        return  # rounding decides
    assert bool(told) == within or after - before == pytest.approx(LONGEST)
