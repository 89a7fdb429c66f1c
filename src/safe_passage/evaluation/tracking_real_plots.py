"""A real recording from above: what was measured, what the tracker said of it."""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from safe_passage.core.geometry import placed
from safe_passage.evaluation.tracking_metrics import Truth
from safe_passage.evaluation.tracking_plots import paths
from safe_passage.evaluation.tracking_real import LEGS, VEHICLE, Run

MARGIN = 0.5  # [m] around what is drawn
AROUND = 10.0  # [s] before and after the moment, in which paths are drawn if the robot stands
SHORT = 0.3  # [m] a shorter path is not drawn with its number
ROBOT = np.array([[0.3, 0.0], [-0.2, 0.2], [-0.2, -0.2]])  # where its outline is not known


def draw_run(ran: Run, truth: Truth, file: Path) -> None:
    """Cells of one moment; paths of a while around it, or of a robot that drives all paths."""
    figure, axes = plt.subplots(figsize=(10, 8))
    moment = _busiest(ran)
    stamps = np.array([cycle.stamp for cycle in ran.cycles])
    begin, now = stamps[0], stamps[moment]
    drawn = np.flatnonzero((np.abs(stamps - now) <= AROUND) | (not ran.recording.stands))
    _draw_moment(axes, ran, moment)
    _draw_paths(axes, ran, truth, slice(drawn[0], drawn[-1] + 1))
    axes.set_title(
        f"{ran.recording.name}: cells as they are after {now - begin:.1f} s, "
        f"paths from {stamps[drawn[0]] - begin:.0f} s to {stamps[drawn[-1]] - begin:.0f} s"
    )
    axes.set_aspect("equal")
    axes.set(xlabel="x [m]", ylabel="y [m]")
    points = np.concatenate(ran.points)
    low, high = np.nanpercentile(points, [0.1, 99.9], axis=0)
    axes.set(xlim=(low[0] - MARGIN, high[0] + MARGIN), ylim=(low[1] - MARGIN, high[1] + MARGIN))
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0, fontsize=9)
    file.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(file, dpi=90, bbox_inches="tight")
    plt.close(figure)


def _busiest(ran: Run) -> int:
    """The cycle in which most moves, the middle one of several."""
    count = np.array([(said.moving & said.fresh).sum() for said in ran.told])
    most = np.flatnonzero(count == count.max())
    return int(most[len(most) // 2])


def _draw_moment(axes: Axes, ran: Run, moment: int) -> None:
    points = np.concatenate(ran.points)
    seen = np.unique(np.round(points / 0.04).astype(int), axis=0) * 0.04
    axes.plot(*seen.T, ".", color="0.75", markersize=1.5)
    axes.plot([], [], "s", color="0.75", markersize=3, label="measured at any time")
    snapshot, pose = ran.snapshots[moment], np.array(ran.poses[moment])
    tracks = snapshot.tracks
    for moving, colour, label in ((False, "0.35", "standing"), (True, "red", "moving")):
        chosen = np.flatnonzero(
            snapshot.confirmed & (tracks.moving == moving) & (tracks.misses < 3)
        )
        cells = [placed(snapshot.shapes[i], pose) for i in chosen]
        flat = np.concatenate([*cells, np.empty((0, 2))])
        axes.plot(*flat.T, "s", color=colour, markersize=2.5, label=f"cells of a {label} track")
    outline = np.array(ran.recording.footprint) if ran.recording.footprint else ROBOT
    axes.fill(*placed(outline, pose).T, color="tab:blue", label="robot", zorder=3)
    if not ran.recording.stands:
        axes.plot(*np.array(ran.poses)[:, :2].T, color="tab:blue", label="robot's way")


def _draw_paths(axes: Axes, ran: Run, truth: Truth, drawn: slice) -> None:
    label = {VEHICLE: "way of the other car", LEGS: "ways of marked legs"}.get(
        ran.recording.truth, "ways of what was not always there"
    )
    for person in range(truth.people.shape[1]):
        if truth.moved[drawn, person].any():
            axes.plot(*truth.people[drawn, person, :2].T, color="black", linewidth=3.0, alpha=0.35,
                      solid_capstyle="round", label=label)  # fmt: skip
            label = "_"
    label = "path of a moving track, its number at the end"
    for number, way in paths(ran.told[drawn]).items():
        axes.plot(*way.T, "-", color="red", linewidth=0.9, label=label)
        label = "_"
        if np.ptp(way, axis=0).max() > SHORT:
            axes.annotate(str(number), way[-1], color="darkred", fontsize=8)
        else:
            axes.plot(*way[-1], "x", color="red", markersize=5)
