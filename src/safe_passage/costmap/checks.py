"""Checks of parameters that are not numbers; numbers have `safe_passage.core.parameters`."""

from __future__ import annotations

from typing import Any

from safe_passage.core.errors import ParameterError


def check_flag(name: str, value: Any) -> None:
    """Raise ParameterError unless `value` is true or false."""
    if not isinstance(value, bool):
        raise ParameterError(f"{name} is {value!r}, must be true or false")


def check_text(name: str, value: Any, may_be_empty: bool = False) -> None:
    """Raise ParameterError unless `value` is a string (with content, unless told otherwise)."""
    if not isinstance(value, str) or not (value or may_be_empty):
        raise ParameterError(
            f"{name} is {value!r}, must be a {'' if may_be_empty else 'non-empty '}string"
        )


def check_choice(name: str, value: Any, choices: tuple) -> None:
    """Raise ParameterError unless `value` is one of `choices`."""
    if value not in choices:
        raise ParameterError(f"{name} is {value!r}, must be one of {', '.join(map(str, choices))}")
