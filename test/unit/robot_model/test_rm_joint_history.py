"""Joint states at an image's stamp."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.core.errors import InputError
from safe_passage.robot_model import JointHistory


def history(*stamps: float) -> JointHistory:
    made = JointHistory(length=2.0, tolerance=0.02, max_gap=0.2)
    for stamp in stamps:
        made.add(stamp, ["a", "b"], [stamp, -stamp])
    return made


@given(st.floats(0.0, 1.0))
def test_positions_are_interpolated(stamp: float) -> None:
    known = history(*(0.1 * i for i in range(11)))
    at = known.at(stamp, ["a", "b"])
    assert at["a"] == pytest.approx(stamp, abs=1e-9)
    assert at["b"] == pytest.approx(-stamp, abs=1e-9)


def test_states_may_come_out_of_order_and_twice() -> None:
    known = history(0.0, 0.2, 0.1, 0.1)
    known.add(0.1, ["a"], [55.0])
    assert known.at(0.05, ["a"])["a"] == pytest.approx(0.05)
    assert known.at(0.15, ["a"])["a"] == pytest.approx(0.15)


def test_nothing_is_made_up_beyond_the_tolerance() -> None:
    known = history(1.0, 1.1)
    assert known.at(1.115, ["a"])["a"] == pytest.approx(1.1)
    for stamp, says in ((1.2, "before the stamp"), (0.9, "after the stamp")):
        with pytest.raises(InputError, match=f"joint a: .*{says}"):
            known.at(stamp, ["a"])


def test_a_gap_at_the_stamp_is_refused() -> None:
    with pytest.raises(InputError, match="gap"):
        history(0.0, 0.5).at(0.25, ["a"])


def test_a_joint_without_a_state_is_named() -> None:
    with pytest.raises(InputError, match="joint c: no state"):
        history(0.0).at(0.0, ["a", "c"])


def test_what_is_old_is_forgotten() -> None:
    known = history(0.0, 10.0)
    with pytest.raises(InputError):
        known.at(0.0, ["a"])
    known.clear()
    with pytest.raises(InputError, match="no state"):
        known.at(10.0, ["a"])


@pytest.mark.parametrize(("names", "positions"), [(["a"], []), (["a", "b"], [0.0, math.inf])])
def test_a_broken_state_is_refused_whole(names: list[str], positions: list[float]) -> None:
    known = JointHistory()
    with pytest.raises(InputError):
        known.add(0.0, names, positions)
    with pytest.raises(InputError, match="no state"):
        known.at(0.0, ["a"])
