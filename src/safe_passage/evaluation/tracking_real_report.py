"""The obstacle tracker on real recordings: a table, sums, a picture of each."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any, Mapping, Sequence

from safe_passage.core.progress import Progress
from safe_passage.evaluation.report import table
from safe_passage.evaluation.tracking_real import (
    CAME,
    LEGS,
    VEHICLE,
    RealRecording,
    Result,
    judge,
)
from safe_passage.evaluation.tracking_real_plots import draw_run

NAN = float("nan")
HEADER = (
    *("recording", "truth", "s", "cycles", "tracks a cycle", "called moving", "movers", "found"),
    *("most ids", "wait [s]", "mover-cycles", "tracked", "error [m]", "speed error [m/s]"),
    *("static tracks", "false moving", "ms"),
)


def judge_all(
    recordings: Sequence[RealRecording], config: Path, pictures: Path | None = None
) -> list[Result]:
    """A result for each, and a picture if there is a folder for them."""
    results = []
    progress = Progress("real recordings", len(recordings))
    for recording in recordings:
        ran, truth, found = judge(recording, config)
        if pictures:
            draw_run(ran, truth, pictures / f"{recording.name.replace(' ', '_')}.png")
        results.append(found)
        progress.show(len(results))
    return results


def sums(results: Sequence[Result]) -> Mapping[str, float]:
    """Over all that tell the same; NaN where none does."""
    legs, came, cars = (
        [one for one in results if one.recording.truth == truth] for truth in (LEGS, CAME, VEHICLE)
    )
    standing = [one for one in results if one.recording.stands]
    driving = [one for one in results if not one.recording.stands]
    return {
        "walkers_tracked": _share(legs, "tracked", "mover_cycles"),
        "walkers_found": _share(legs, "found", "movers"),
        "walkers_most_ids": max((one.ids for one in legs), default=NAN),
        "came_tracked": _share(came, "tracked", "mover_cycles"),
        "car_tracked": _share(cars, "tracked", "mover_cycles"),
        "car_ids": max((one.ids for one in cars), default=NAN),
        "car_speed_error": max((one.speed_error for one in cars), default=NAN),
        "false_moving_share_standing": _share(standing, "false_moving", "static_tracks"),
        "false_moving_share_driving": _share(driving, "false_moving", "static_tracks"),
    }


def _share(results: Sequence[Result], part: str, whole: str) -> float:
    total = sum(getattr(one, whole) for one in results)
    return sum(getattr(one, part) for one in results) / total if total else NAN


def as_markdown(results: Sequence[Result]) -> str:
    """A table, a line a recording."""
    return table(HEADER, [_row(one) for one in results])


def as_values(results: Sequence[Result]) -> dict[str, Any]:
    """The same for JSON."""
    names = [field.name for field in dataclasses.fields(Result) if field.name != "recording"]
    found = {
        one.recording.name: {
            "truth": one.recording.truth,
            **{name: getattr(one, name) for name in names},
        }
        for one in results
    }
    return {"sums": dict(sums(results)), "recordings": found}


def _row(r: Result) -> tuple:
    return (
        *(r.recording.name, r.recording.truth, f"{r.seconds:.0f}", r.cycles, f"{r.tracks:.1f}"),
        *(r.called_moving, r.movers, r.found, r.ids or "-", _shown(r.wait, 1), r.mover_cycles),
        f"{r.tracked / r.mover_cycles:.0%}" if r.mover_cycles else "-",
        *(_shown(r.error, 2), _shown(r.speed_error, 2), r.static_tracks, r.false_moving),
        f"{r.milliseconds:.1f}",
    )


def _shown(value: float, digits: int) -> str:
    return "-" if value != value else f"{value:.{digits}f}"
