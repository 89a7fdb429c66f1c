"""A tracking scenario from above: paths of people and tracks, frame of the odometry."""

from __future__ import annotations

from pathlib import Path
from typing import Sequence

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from safe_passage.core.geometry import placed
from safe_passage.evaluation.tracking_recording import Recording
from safe_passage.evaluation.tracking_runs import Told, measurements
from safe_passage.monitoring.parameters import TrackerParameters

EVERY = 4  # cycles of which the points are drawn


def draw_tracks(
    recording: Recording, cycles: Sequence[Told], parameters: TrackerParameters, file: Path
) -> None:
    """People black, moving tracks coloured by id, what was measured grey, the robot's way blue."""
    figure, axes = plt.subplots(figsize=(10, 8))
    scenario = recording.scenario
    measured = [one for cycle in measurements(recording, parameters)[::EVERY] for one in cycle]
    points = np.concatenate([placed(one.points[:, :2], np.array(one.pose)) for one in measured])
    cells = np.unique(np.round(points / 0.05).astype(int), axis=0) * 0.05
    axes.plot(*cells.T, ",", color="0.75")
    axes.plot(*recording.poses[:, :2].T, color="tab:blue", linewidth=2)
    axes.fill(*placed(np.array(scenario.robot.footprint), recording.poses[-1]).T, color="tab:blue")
    for person in range(recording.people.shape[1]):
        judged = recording.visible[:, person] & recording.moved[:, person]
        way = np.where(judged[:, None], recording.people[:, person, :2], np.nan)
        axes.plot(*recording.people[:, person, :2].T, ":", color="black", linewidth=0.8)
        axes.plot(*way.T, color="black", linewidth=1.2)
    colours = plt.get_cmap("tab20").colors
    for number, way in paths(cycles).items():
        colour = colours[number % len(colours)]
        axes.plot(*way.T, ".-", color=colour, markersize=2, linewidth=0.7)
        axes.annotate(str(number), way[0], color=colour, fontsize=8)
    axes.set_aspect("equal")
    axes.set(xlabel="x [m]", ylabel="y [m]", title=f"{scenario.name}, seed {scenario.seed}")
    low, high = np.nanpercentile(points, [0.5, 99.5], axis=0)
    axes.set(xlim=(low[0] - 0.5, high[0] + 0.5), ylim=(low[1] - 0.5, high[1] + 0.5))
    file.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(file, dpi=100, bbox_inches="tight")
    plt.close(figure)


def paths(cycles: Sequence[Told]) -> dict[int, np.ndarray]:
    """Where each track was, (N, 2) [m], while it was told as moving and seen."""
    found: dict[int, list[np.ndarray]] = {}
    for said in cycles:
        answer = said.moving & said.fresh
        for number, position in zip(said.id[answer].tolist(), said.position[answer]):
            found.setdefault(number, []).append(position)
    return {number: np.array(way) for number, way in found.items()}
