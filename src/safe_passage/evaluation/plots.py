"""Results as pictures. Matplotlib is asked for only when one is drawn; no display is needed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Mapping, Sequence

import numpy as np

from safe_passage.core.errors import InputError
from safe_passage.evaluation.closed_loop_table import METHODS, Outcome
from safe_passage.evaluation.detector_report import (
    DISTANCES,
    VISIBLE,
    DetectorReport,
    binned_recall,
)
from safe_passage.evaluation.oracle import KEEP
from safe_passage.evaluation.scenarios import KINDS
from safe_passage.evaluation.setting import Setting
from safe_passage.evaluation.warehouse_legs import JudgedSegment
from safe_passage.simulation.static_map import make_map

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = {"none": "tab:red", "hog": "tab:orange", "yolo": "tab:green", "tracked": "tab:purple"}
LABELS = {"none": "no safety area", "hog": "HOG", "yolo": "YOLO", "tracked": "YOLO and tracker"}
STRIP = 0.4  # [m] side of a segment's picture


def draw_detectors(report: DetectorReport, file: Path) -> None:
    """Recall by distance and by visible share."""
    figure, axes = _figure(1, 2, (9.0, 3.6))
    keys = (("distance", DISTANCES, "distance [m]"), ("visible", VISIBLE, "visible share"))
    for ax, (key, edges, label) in zip(axes, keys):
        for method, score in report.scores.items():
            bins = binned_recall(score, key, edges)
            middles = [0.5 * (low + high) for low, high, _, _ in bins]
            values = [recall for *_, recall in bins]
            ax.plot(middles, values, "o-", color=COLOURS[method], label=LABELS[method])
        ax.set(xlabel=label, ylabel="recall", ylim=(0.0, 1.03), xlim=(edges[0], edges[-1]))
        ax.grid(alpha=0.3)
        ax.legend()
    _save(figure, file)


def draw_legs(examples: Mapping[str, Sequence[JudgedSegment]], file: Path) -> None:
    """Segments of warehouse things taken for legs, and of legs, each with a strip around it."""
    columns = max(max((len(found) for found in examples.values()), default=1), 1)
    figure, axes = _figure(len(examples), columns, (2.4 * columns, 2.5 * len(examples)))
    for row, (thing, found) in zip(np.reshape(axes, (len(examples), columns)), examples.items()):
        for ax in row:
            ax.set_axis_off()
        for ax, one in zip(row, found):
            _draw_segment(ax, thing, one)
    _save(figure, file)


def draw_distances(outcomes: Sequence[Outcome], file: Path) -> None:
    """How many runs came how near, by kind and method."""
    figure, axes = _figure(1, len(KINDS), (9.0, 3.6))
    edges = np.arange(0.0, 3.3, 0.2)
    for ax, kind in zip(axes, KINDS):
        for method in METHODS:
            near = [
                o.run.min_distance for o in outcomes if (o.run.kind, o.run.method) == (kind, method)
            ]
            if near:
                clipped = np.clip(near, edges[0], edges[-1] - 0.01)
                ax.hist(clipped, edges, alpha=0.5, color=COLOURS[method], label=LABELS[method])
        ax.axvline(KEEP, color="black", linestyle="--", linewidth=1.0)
        ax.set(xlabel="least distance of a run [m]", ylabel="runs", title=f"{kind} person")
        ax.legend()
    _save(figure, file)


def draw_tracks(outcomes: Sequence[Outcome], setting: Setting, file: Path, each: int = 3) -> None:
    """The first `each` runs of every kind over the map, the way of all methods; like fig. 9."""
    figure, axes = _figure(len(KINDS), each, (5.0 * each, 3.6 * len(KINDS)))
    world, robot = setting.load()
    static = make_map(world, robot.height)
    rows, columns = static.occupied.shape
    x, y = static.origin
    extent = (x, x + columns * static.resolution, y, y + rows * static.resolution)
    for line, kind in zip(np.reshape(axes, (len(KINDS), each)), KINDS):
        numbers = sorted({o.number for o in outcomes if o.run.kind == kind})
        for ax, number in zip(line, numbers):
            ax.imshow(static.occupied, cmap="Greys", origin="lower", extent=extent, alpha=0.6)
            shown = [o for o in outcomes if (o.run.kind, o.number) == (kind, number)]
            for outcome in shown:
                _draw_run(ax, outcome)
            ax.set(title=f"{kind} {number}", xticks=(), yticks=(), aspect="equal")
            ax.legend(fontsize="x-small", loc="upper right")
    _save(figure, file)


def _draw_run(ax: Axes, outcome: Outcome) -> None:
    from matplotlib.patches import Circle

    run = outcome.run
    colour = COLOURS[run.method]
    label = f"{LABELS[run.method]}: {run.min_distance:.2f} m"
    ax.plot(run.column("x"), run.column("y"), color=colour, linewidth=1.5, label=label)
    ax.plot(run.column("person_x"), run.column("person_y"), color="tab:blue", linewidth=1.0)
    nearest = int(np.argmin(run.column("distance")))
    place = run.column("person_x")[nearest], run.column("person_y")[nearest]
    robot = run.column("x")[nearest], run.column("y")[nearest]
    ax.add_patch(Circle(place, KEEP, fill=False, color=colour, linewidth=0.8))
    ax.plot(*zip(place, robot), color=colour, linewidth=0.8, linestyle=":")
    ax.plot(*place, ".", color="tab:blue")


def _draw_segment(ax: Axes, thing: str, one: JudgedSegment) -> None:
    from matplotlib.patches import Rectangle

    middle = one.points.mean(axis=0)
    points = one.points - middle
    low, high = points.min(axis=0) - 0.02, points.max(axis=0) + 0.02
    ax.plot(*points.T, ".", color="tab:red" if one.false_alarm else "tab:green")
    ax.add_patch(Rectangle(low, *(high - low), fill=False, color="tab:blue"))
    side = 0.5 * max(STRIP, 1.1 * float(np.ptp(points, axis=0).max()))
    ax.set(xlim=(-side, side), ylim=(-side, side), aspect="equal", xticks=(), yticks=())
    ax.set_title(
        f"{thing}, {np.hypot(*middle):.1f} m\n{len(points)} points, leg {one.probability:.2f}",
        fontsize=8,
    )
    ax.set_axis_on()


def _figure(rows: int, columns: int, size: tuple[float, float]) -> Any:
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise InputError("pictures need matplotlib (python3-matplotlib)") from None
    figure = Figure(figsize=size)
    return figure, figure.subplots(rows, columns)


def _save(figure: Any, file: Path) -> None:
    figure.tight_layout()
    try:
        figure.savefig(file, dpi=110)
    except OSError as error:
        raise InputError(f"{file}: {error}") from None
