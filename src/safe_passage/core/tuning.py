"""Changes of parameters while they are in use: a new whole set, or none at all.

Parameters are named by paths: `gate`, `person_labels/label_gate` of a part, and of a list of parts
that have names `obstacle_layer/inflation_radius`.
"""

from __future__ import annotations

import dataclasses
import math
from collections import defaultdict
from typing import Any, Mapping, TypeVar

from safe_passage.core.described import Description, described_as
from safe_passage.core.errors import ParameterError, shown

T = TypeVar("T")


def value_at(parameters: Any, path: str) -> Any:
    """The parameter's value; raises KeyError."""
    name, _, rest = path.partition("/")
    if rest:
        return value_at(_part(parameters, name), rest)
    if name not in _fields(parameters):
        raise KeyError(path)
    return getattr(parameters, name)


def description_at(parameters: Any, path: str) -> Description:
    """With the bounds that hold for the values now; its name is the path. Raises KeyError."""
    value_at(parameters, path)
    owner = parameters
    *parts, name = path.split("/")
    for part in parts:
        owner = _part(owner, part)
    found = {description.name: description for description in described_as(owner)}
    return dataclasses.replace(found[name], name=path)


def changed(parameters: T, changes: Mapping[str, Any]) -> T:
    """A new set with all the changes in it; path -> value.

    Raises:
        ParameterError: one is not known, has the wrong type or does not validate, alone or with the
            others.
    """
    own: dict[str, Any] = {}
    inner: dict[str, dict[str, Any]] = defaultdict(dict)
    for path, value in changes.items():
        name, _, rest = path.partition("/")
        if rest:
            inner[name][rest] = value
        else:
            own[name] = _typed(parameters, name, value)
    for name, values in inner.items():
        field = _field_of(parameters, name)
        try:
            own[field] = _changed_part(own.get(field, getattr(parameters, field)), name, values)
        except ParameterError as error:
            said = str(error)
            raise ParameterError(said if said.startswith(name) else f"{name}/{said}") from None
    return dataclasses.replace(parameters, **own)  # type: ignore[type-var]


def _changed_part(part: Any, name: str, values: Mapping[str, Any]) -> Any:
    if not isinstance(part, tuple):
        return changed(part, values)
    return tuple(changed(one, values) if one.name == name else one for one in part)


def _fields(parameters: Any) -> dict[str, dataclasses.Field]:
    return {field.name: field for field in dataclasses.fields(parameters)}


def _part(parameters: Any, name: str) -> Any:
    """The part of this name."""
    try:
        part = getattr(parameters, _field_of(parameters, name))
    except ParameterError:
        raise KeyError(name) from None
    return next(one for one in part if one.name == name) if isinstance(part, tuple) else part


def _field_of(parameters: Any, name: str) -> str:
    """The field that is the part of this name, or holds it in a list."""
    for field in _fields(parameters):
        value = getattr(parameters, field)
        if field == name and dataclasses.is_dataclass(value):
            return field
        if isinstance(value, tuple) and any(getattr(one, "name", None) == name for one in value):
            return field
    raise ParameterError(f"{name} is not known")


def _typed(parameters: Any, name: str, value: Any) -> Any:
    """The value as its field wants it."""
    if name not in _fields(parameters):
        raise ParameterError(f"{name} is not known")
    kind = str(_fields(parameters)[name].type)
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if kind == "float":
        if not number or not math.isfinite(value):
            raise ParameterError(f"{name} is {shown(value)}, must be a finite number")
        return float(value)
    wanted = {"int": int, "bool": bool, "str": str}.get(kind)
    if wanted is None or type(value) is not wanted:
        raise ParameterError(f"{name} is {shown(value)}, must be {kind}")
    return value
