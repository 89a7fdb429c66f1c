"""When and why people were missed, and what was called moving and was nobody."""

from __future__ import annotations

from typing import Iterator, Sequence

import numpy as np

from safe_passage.evaluation.tracking_metrics import GATE, accumulate, pair_distances
from safe_passage.evaluation.tracking_recording import Recording
from safe_passage.evaluation.tracking_runs import Told

Span = tuple[float, float, str]  # from [s], to [s], what


def misses(recording: Recording, cycles: Sequence[Told]) -> dict[int, list[Span]]:
    """For each person the times without a track of its own, with the reason."""
    events = accumulate(recording, cycles).mot_events
    missed = events[events.Type == "MISS"]
    frames = missed.index.get_level_values(0).to_numpy(int)
    people = missed.OId.to_numpy(int)
    found: dict[int, list[Span]] = {}
    for person in np.unique(people).tolist():
        reasons = [
            (int(frame), _reason(recording.people[frame, person, :2], cycles[frame]))
            for frame in frames[people == person]
        ]
        found[person] = list(_spans(recording.stamps, reasons))
    return found


def strays(recording: Recording, cycles: Sequence[Told]) -> dict[int, list[Span]]:
    """For each track that was a false positive, when and where, and how far the next person was."""
    events = accumulate(recording, cycles).mot_events
    wrong = events[events.Type == "FP"]
    found: dict[int, list[tuple[int, str]]] = {}
    for frame, number in zip(wrong.index.get_level_values(0), wrong.HId.to_numpy(int).tolist()):
        found.setdefault(number, []).append((int(frame), "moving"))
    return {
        number: [
            (start, end, _where(recording, cycles, number, start))
            for start, end, _ in _spans(recording.stamps, rows)
        ]
        for number, rows in found.items()
    }


def as_text(recording: Recording, cycles: Sequence[Told]) -> str:
    """All of it."""
    lines = [f"## {recording.scenario.name}"]
    for what, spans in (
        ("person", misses(recording, cycles)),
        ("track", strays(recording, cycles)),
    ):
        for number, rows in sorted(spans.items()):
            told = "; ".join(f"{start:.1f}-{end:.1f} s {why}" for start, end, why in rows)
            lines.append(f"{what} {number}: {told}")
    return "\n".join(lines)


def _reason(position: np.ndarray, said: Told) -> str:
    """Why nothing at `position` (2,) [m] counted as this person."""
    distance = pair_distances(position[None], said.position)[0]
    near = distance <= GATE
    if not near.any():
        return "no track"
    if (near & said.moving & said.fresh).any():
        return "track is another's"
    if (near & said.moving).any():
        return "not seen"
    return "not moving"


def _spans(stamps: np.ndarray, rows: Sequence[tuple[int, str]]) -> Iterator[Span]:
    """Cycles in a row for the same reason as one span."""
    start = 0
    for i in range(1, len(rows) + 1):
        ends = i == len(rows) or rows[i][0] != rows[i - 1][0] + 1 or rows[i][1] != rows[start][1]
        if ends:
            yield float(stamps[rows[start][0]]), float(stamps[rows[i - 1][0]]), rows[start][1]
            start = i


def _where(recording: Recording, cycles: Sequence[Told], number: int, stamp: float) -> str:
    cycle = int(np.searchsorted(recording.stamps, stamp))
    said = cycles[cycle]
    x, y = said.position[said.id == number][0]
    distances = np.hypot(*(recording.people[cycle, :, :2] - (x, y)).T)
    if not len(distances):
        return f"at ({x:.1f}, {y:.1f})"
    nearest = int(np.argmin(distances))
    return f"at ({x:.1f}, {y:.1f}), {distances[nearest]:.1f} m from person {nearest}"
