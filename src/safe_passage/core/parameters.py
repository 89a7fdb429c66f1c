"""Parameters as frozen dataclasses: the field is the name, its default the default."""

from __future__ import annotations

import contextlib
import contextvars
import dataclasses
import math
from typing import Any, Iterator, Mapping, TypeVar

from safe_passage.core.errors import ParameterError, shown

T = TypeVar("T")


@dataclasses.dataclass(frozen=True)
class Check:
    """What a parameter must be, as its dataclass checks it."""

    name: str
    least: float | None = None
    most: float | None = None
    unit: str = ""
    choices: tuple = ()


_recorded: contextvars.ContextVar[list[Check] | None] = contextvars.ContextVar(
    "recorded", default=None
)


@contextlib.contextmanager
def recorded_checks() -> Iterator[list[Check]]:
    """Every check_range and check_choice of this thread inside the `with`, in their order."""
    checks: list[Check] = []
    token = _recorded.set(checks)
    try:
        yield checks
    finally:
        _recorded.reset(token)


def _record(check: Check) -> None:
    checks = _recorded.get()
    if checks is not None:
        checks.append(check)


def from_mapping(cls: type[T], values: Mapping[str, Any], where: str = "") -> T:
    """Make the dataclass `cls` from `values`; refuse an unknown key by its full name.

    Args:
        cls: a dataclass whose `__post_init__` validates.
        values: field name -> value, as read from yaml.
        where: the namespace to name in errors, such as `/robot/tracker`.

    Raises:
        ParameterError: a key is not a field, or a field's value does not validate.
    """
    fields = {field.name for field in dataclasses.fields(cls)}  # type: ignore[arg-type]
    for key in values:
        if key not in fields:
            known = ", ".join(sorted(fields))
            raise ParameterError(f"parameter {where}/{key} is not known; known are: {known}")
    try:
        return cls(**values)
    except ParameterError as error:
        raise ParameterError(f"parameter {where}/{error}") from None


def check_range(name: str, value: float, least: float, most: float, unit: str) -> None:
    """Raise ParameterError unless `value` is a number in [least, most] (so NaN is refused)."""
    _record(Check(name, least, most, unit))
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not number or math.isnan(value) or not least <= value <= most:
        raise ParameterError(f"{name} is {shown(value)}, must lie in [{least}, {most}] {unit}")


def check_flag(name: str, value: Any) -> None:
    """Raise ParameterError unless `value` is true or false."""
    if not isinstance(value, bool):
        raise ParameterError(f"{name} is {shown(value)}, must be true or false")


def check_text(name: str, value: Any, may_be_empty: bool = False) -> None:
    """Raise ParameterError unless `value` is a string (with content, unless told otherwise)."""
    if not isinstance(value, str) or not (value or may_be_empty):
        raise ParameterError(
            f"{name} is {shown(value)}, must be a {'' if may_be_empty else 'non-empty '}string"
        )


def check_choice(name: str, value: Any, choices: tuple) -> None:
    """Raise ParameterError unless `value` is one of `choices`."""
    _record(Check(name, choices=choices))
    if value not in choices:
        raise ParameterError(
            f"{name} is {shown(value)}, must be one of {', '.join(map(str, choices))}"
        )
