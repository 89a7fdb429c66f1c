"""What is wrong in a file is named in few words, however much of it there is."""

from string import ascii_letters

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.core.errors import ParameterError, shown
from safe_passage.core.parameters import check_choice, check_flag, check_range, check_text
from safe_passage.core.reading import build_list

NESTED = "a: &a [x, x]\n" + "".join(
    f"{name}: &{name} [{', '.join([f'*{before}'] * 9)}]\n" for before, name in zip("abcde", "bcdef")
)
CHECKS = (
    lambda value: check_flag("p", value),
    lambda value: check_range("p", value, 0.0, 1.0, "m"),
    lambda value: check_text("p", value),
    lambda value: check_choice("p", value, ("a", "b")),
    lambda value: build_list(dict, value, "p"),
)


@pytest.mark.parametrize("check", CHECKS)
def test_a_value_of_very_many_entries_is_told_in_a_few(check):
    """A few lines of yaml can stand for them, each the same list again."""
    huge = {"p": yaml.safe_load(NESTED)["f"]}
    assert len(repr(huge)) > 100_000
    with pytest.raises(ParameterError) as error:
        check(huge)
    assert len(str(error.value)) < 1000


@given(st.recursive(st.none() | st.text() | st.floats(), st.lists))
def test_it_is_short_and_on_one_line(value):
    assert len(shown(value)) < 1500
    assert "\n" not in shown(value)


@given(
    st.integers(-(10**12), 10**12)
    | st.floats()
    | st.text(ascii_letters, max_size=9)
    | st.booleans()
)
def test_a_small_value_is_told_whole(value):
    assert shown(value) == repr(value)
