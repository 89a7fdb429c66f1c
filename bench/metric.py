"""One row of a benchmark's result."""

from __future__ import annotations

import operator

OPERATORS = {
    "<=": operator.le,
    ">=": operator.ge,
    "<": operator.lt,
    ">": operator.gt,
    "=": operator.eq,
}


def metric(name: str, value: float | None, unit: str, bar: str = "") -> dict:
    """A row; `bar` such as "<= 30" decides whether it holds. `value` None: not measured here."""
    holds = None
    if bar and value is not None:
        sign, limit = bar.split()
        holds = bool(OPERATORS[sign](value, float(limit)))
    return {"name": name, "value": value, "unit": unit, "bar": bar, "holds": holds}
