"""Files into values, errors name the file; yaml into dataclasses, errors name the key."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any, Mapping, Sequence, TypeVar

import cv2
import numpy as np
import yaml

from safe_passage.core.errors import InputError, ParameterError, shown
from safe_passage.core.parameters import check_flag, check_text, from_mapping

T = TypeVar("T")


def read_yaml(path: Path) -> dict[str, Any]:
    """The file's mapping; InputError names the file when it cannot be read."""
    try:
        values = yaml.safe_load(path.read_text())
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except Exception as error:  # what python's constructors raise of values, PyYAML passes on
        raise InputError(f"{path}: not yaml ({error or type(error).__name__})") from None
    if not isinstance(values, dict):
        raise InputError(f"{path}: not a mapping")
    return values


def read_array(path: Path) -> np.ndarray:
    """The numbers of an .npy file; InputError names the file when it holds none."""
    try:
        values = np.load(path, allow_pickle=False)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from None
    except Exception as error:  # what python's own parser raises of a header, numpy passes on
        raise InputError(f"{path}: not an array ({error})") from None
    if not isinstance(values, np.ndarray) or values.dtype.kind not in "iuf":
        raise InputError(f"{path}: not an array of numbers")
    return values


def read_picture(path: Path, flags: int = cv2.IMREAD_UNCHANGED) -> np.ndarray:
    """(H, W) or (H, W, channels); InputError names the file when it is no picture."""
    try:
        picture = cv2.imread(str(path), flags)
    except cv2.error:  # too many pixels; of other damage it says nothing
        picture = None
    if picture is None:
        raise InputError(f"{path}: not a picture")
    return picture


def build(cls: type[T], entry: Any, where: str) -> T:
    """Make the dataclass `cls` of a yaml mapping.

    A field's annotation says what its value must be: float, int, bool, str and tuples of such are
    checked and converted.

    Raises:
        ParameterError: names `where` and the key that is missing, not known or wrong.
    """
    if not isinstance(entry, Mapping):
        raise ParameterError(f"{where} is {shown(entry)}, must be a mapping of keys to values")
    fields = {field.name: field for field in dataclasses.fields(cls)}  # type: ignore[arg-type]
    if not set(entry) <= set(fields):
        from_mapping(cls, entry, where)  # names the one that is not known
    for name, field in fields.items():
        given = (field.default, field.default_factory) != (dataclasses.MISSING,) * 2
        if not given and name not in entry:
            raise ParameterError(f"{where}: {name} is missing")
    typed = {
        key: _typed(str(fields[key].type), value, f"parameter {where}/{key}")
        for key, value in entry.items()
    }
    return from_mapping(cls, typed, where)


def build_list(cls: type[T], entries: Any, where: str) -> tuple[T, ...]:
    """The same of each entry of a list; nothing at all is an empty one."""
    if not isinstance(entries, (list, tuple, type(None))):
        raise ParameterError(f"{where} is {shown(entries)}, must be a list")
    return tuple(build(cls, entry, f"{where}[{i}]") for i, entry in enumerate(entries or ()))


def _typed(kind: str, value: Any, name: str) -> Any:
    """`value` as the annotation `kind` wants it."""
    if kind.startswith("tuple["):
        return _typed_tuple(kind[len("tuple[") : -1], value, name)
    if kind == "float":
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ParameterError(f"{name} is {shown(value)}, must be a number")
        if not math.isfinite(value):
            raise ParameterError(f"{name} is {shown(value)}, must be finite")
        return float(value)
    if kind == "int" and (isinstance(value, bool) or not isinstance(value, int)):
        raise ParameterError(f"{name} is {shown(value)}, must be a whole number")
    if kind == "bool":
        check_flag(name, value)
    if kind == "str":
        check_text(name, value, may_be_empty=True)
    return value


def _typed_tuple(inner: str, value: Any, name: str) -> tuple:
    """`inner`: "KIND, KIND" for so many values, or "KIND, ..." for any number."""
    if not isinstance(value, Sequence) or isinstance(value, str):
        raise ParameterError(f"{name} is {shown(value)}, must be a list")
    repeated = inner.endswith(", ...")
    kinds = [inner[: -len(", ...")]] * len(value) if repeated else inner.split(", ")
    if len(kinds) != len(value):
        raise ParameterError(f"{name} is {shown(value)}, must hold {len(kinds)} values")
    return tuple(
        _typed(kind, one, f"{name}[{i}]") for i, (kind, one) in enumerate(zip(kinds, value))
    )
