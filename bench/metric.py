"""One row of a benchmark's result."""

from __future__ import annotations

import operator

OPERATORS = {"<=": operator.le, ">=": operator.ge, "=": operator.eq}


def metric(name: str, value: float | None, unit: str, bar: str = "") -> dict:
    """A row; `bar` such as "<= 30" decides whether it holds. `value` None: not measured here."""
    holds = None
    if bar:
        sign, limit = bar.split()
        holds = value is not None and bool(OPERATORS[sign](value, float(limit)))
    return {"name": name, "value": value, "unit": unit, "bar": bar, "holds": holds}
