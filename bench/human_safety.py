"""Human safety, end to end: detector, merger, costmap."""

from __future__ import annotations

from bench import costmap, detector, merger


def run(quick: bool) -> list[dict]:
    """All metrics of issue and paper 002, sections 2.2 and 2.3."""
    return [*detector.run(quick), *costmap.run(quick), *merger.run(quick)]
