"""What a dataclass of parameters says of itself: names, types, defaults, ranges, units, meanings.

Nothing is written a second time for it: ranges and units are those that `__post_init__` checks,
meanings are the comments behind the fields.
"""

from __future__ import annotations

import ast
import copy
import dataclasses
import inspect
import io
import re
import sys
import textwrap
import tokenize
from typing import Any

from safe_passage.core.parameters import Check, recorded_checks

REQUIRED = dataclasses.MISSING  # the default of a parameter that has none


@dataclasses.dataclass(frozen=True)
class Description:
    """One parameter."""

    name: str  # with the names of what it is part of before it: `labels/gate`, `sources[]/topic`
    type: str  # float | int | bool | str, or the annotation of a list or mapping
    default: Any  # REQUIRED if there is none
    least: Any  # of a number that is checked, in `unit`; may depend on other parameters
    most: Any  # the same; None: not checked
    unit: str
    choices: tuple  # of which it must be one; empty: not limited so
    text: str  # for people; empty: the name says it all


def described(cls: type, prefix: str = "", **given: Any) -> tuple[Description, ...]:
    """Each parameter of a dataclass, in the order of its fields.

    Parameters that are dataclasses, and lists of such, are described by their own parameters, with
    the field's name and `/`, or `[]/` for lists, before them.

    Args:
        cls: whose defaults, with what is `given`, validate. A string without default need not be
            given.
        prefix: before all names.

    Raises:
        ParameterError: it does not validate.
    """
    fields = dataclasses.fields(cls)
    unset = {f.name: f.name for f in fields if _default(f) is REQUIRED and f.type == "str"}
    return _described(cls(**{**unset, **given}), prefix)


def described_as(parameters: Any) -> tuple[Description, ...]:
    """The same; bounds that depend on other parameters are those that hold for these values."""
    return _described(parameters, "")


def _described(example: Any, prefix: str) -> tuple[Description, ...]:
    cls = type(example)
    checks, texts = _checks_of(example), _comments_of(cls)
    found: list[Description] = []
    for field in dataclasses.fields(cls):
        inner, mark = _inner_class(cls, field), "[]/" if _is_list(field) else "/"
        if inner is None:
            check = checks.get(field.name, Check(field.name))
            found.append(_description(field, prefix, check, texts.get(field.name, "")))
        elif mark == "/":
            found += _described(getattr(example, field.name), f"{prefix}{field.name}/")
        else:
            found += described(inner, f"{prefix}{field.name}[]/")
    return tuple(found)


def _description(field: dataclasses.Field, prefix: str, check: Check, comment: str) -> Description:
    said, text = _split_unit(comment, check.unit)
    return Description(
        prefix + field.name,
        str(field.type),
        _default(field),
        check.least,
        check.most,
        check.unit or said,
        check.choices,
        text,
    )


def _checks_of(example: Any) -> dict[str, Check]:
    """By field; the checks of parameters inside it ran when they were made."""
    names = {field.name for field in dataclasses.fields(example)}
    with recorded_checks() as checks:
        getattr(copy.copy(example), "__post_init__", lambda: None)()
    by_name = {check.name.rsplit("/", 1)[-1]: check for check in checks}
    return {name: check for name, check in by_name.items() if name in names}


def _default(field: dataclasses.Field) -> Any:
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return field.default


def _is_list(field: dataclasses.Field) -> bool:
    return str(field.type).startswith("tuple[")


def _inner_class(cls: type, field: dataclasses.Field) -> type | None:
    """The dataclass that the field is, or of which it is a list."""
    named = re.sub(r"^tuple\[(\w+), \.\.\.\]$", r"\1", str(field.type))
    for owner in cls.__mro__:
        inner = vars(sys.modules[owner.__module__]).get(named)
        if isinstance(inner, type) and dataclasses.is_dataclass(inner):
            return inner
    return None


def _comments_of(cls: type) -> dict[str, str]:
    """What stands behind each field, also of the classes it inherits from."""
    comments: dict[str, str] = {}
    for owner in reversed(cls.__mro__):
        if dataclasses.is_dataclass(owner):
            comments.update(_own_comments(textwrap.dedent(inspect.getsource(owner))))
    return comments


def _own_comments(source: str) -> dict[str, str]:
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    by_line = {
        token.start[0]: token.string.lstrip("# ")
        for token in tokens
        if token.type == tokenize.COMMENT
    }
    definition = ast.parse(source).body[0]
    assert isinstance(definition, ast.ClassDef)
    return {
        statement.target.id: " ".join(
            by_line[line]
            for line in range(statement.lineno, (statement.end_lineno or 0) + 1)
            if line in by_line
        )
        for statement in definition.body
        if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name)
    }


def _split_unit(comment: str, unit: str) -> tuple[str, str]:
    """A comment's unit, `[m] of a thing` or `m, of a thing`, and the rest of it."""
    bracketed = re.match(r"\[([^\]]+)\],? ?(.*)", comment)
    if bracketed:
        return bracketed.group(1), bracketed.group(2)
    plain = re.match(rf"{re.escape(unit)}(?:,? |$)(.*)", comment) if unit else None
    if plain:
        return "", plain.group(1)
    listed = re.match(r"(m|s|rad|Hz), (.*)", comment)
    return (listed.group(1), listed.group(2)) if listed else ("", comment)
