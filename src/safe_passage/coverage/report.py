"""What a coverage says: tables, JSON, a picture."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from safe_passage.coverage.field import BANDS, Coverage, Sensor
from safe_passage.simulation.robots import Robot

NEAR, FAR = 2.0, 4.0  # [m] within which shares are told
DISTANCE = 1.5  # [m] at which blind sectors are
# by number of sensors: red is blind
COLOURS = ("#d9534f", "#f5d76e", "#8fd19e", "#3a9d5d", "#1f6f9f")


def summary(found: Coverage) -> dict[str, Any]:
    """All figures, for JSON."""
    return {
        "bands": {
            name: {
                "height_m": list(limits),
                "seen_share_2m": found.share(b, NEAR),
                "seen_share_4m": found.share(b, FAR),
                "seen_by_two_share_4m": found.share(b, FAR, 2),
                "blind_sectors_deg": [
                    [round(math.degrees(edge), 1) for edge in sector]
                    for sector in found.blind_sectors(b, DISTANCE)
                ],
            }
            for b, (name, limits) in enumerate(BANDS.items())
        },
        "sensors": {
            name: {"hidden_by_robot_share": float(share)}
            for name, share in zip(found.sensors, found.hidden)
        },
    }


def as_markdown(robot: str, figures: dict[str, Any]) -> str:
    """For people."""
    lines = [
        f"{robot}: seen around base, the robot's own place left out",
        "",
        f"| height [m] | within {NEAR:g} m | within {FAR:g} m | by two sensors "
        f"| blind at {DISTANCE:g} m [deg, 0 = ahead, left is positive] |",
        "|---|---|---|---|---|",
    ]
    for name, band in figures["bands"].items():
        low, high = band["height_m"]
        sectors = ", ".join(f"{a:g} to {b:g}" for a, b in band["blind_sectors_deg"]) or "nowhere"
        if band["blind_sectors_deg"] == [[-180.0, 180.0]]:
            sectors = "all around"
        lines.append(
            f"| {low:g} to {high:g}, {name} | {band['seen_share_2m']:.0%} "
            f"| {band['seen_share_4m']:.0%} | {band['seen_by_two_share_4m']:.0%} | {sectors} |"
        )
    lines += ["", "| sensor | of its view the robot itself hides |", "|---|---|"]
    lines += [
        f"| {name} | {one['hidden_by_robot_share']:.0%} |"
        for name, one in figures["sensors"].items()
    ]
    return "\n".join(lines)


def draw(robot: Robot, found: Coverage, file: Path) -> None:
    """A map for each band: red is blind."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.colors import BoundaryNorm, ListedColormap

    most = max(2, min(int(found.count.max()), len(COLOURS) - 1))
    colours = ListedColormap(COLOURS[: most + 1])
    norm = BoundaryNorm(np.arange(most + 2) - 0.5, most + 1)
    half = 0.5 * found.resolution * found.inside.shape[0]
    figure, axes = pyplot.subplots(1, len(BANDS), figsize=(4.2 * len(BANDS), 3.7), sharey=True)
    outline = np.array([*robot.footprint, robot.footprint[0]])
    for ax, (name, (low, high)), count in zip(axes, BANDS.items(), found.count):
        shown = ax.imshow(
            np.minimum(count, most),
            cmap=colours,
            norm=norm,
            origin="lower",
            extent=(-half, half, -half, half),
        )
        ax.fill(*outline.T, color="0.25")
        ax.annotate(
            "", (outline[:, 0].max() + 0.6, 0), (0, 0), arrowprops={"width": 1, "color": "k"}
        )
        sensors: list[Sensor] = [*robot.lidars, *robot.cameras]
        for sensor in sensors:
            ax.plot(sensor.x, sensor.y, "wo", markersize=4, markeredgecolor="k")
        ax.set(title=f"{name}, {low:g} to {high:g} m", xlabel="x ahead [m]")
    axes[0].set_ylabel("y left [m]")
    bar = figure.colorbar(shown, ax=axes, ticks=np.arange(most + 1), shrink=0.75)
    last = f"{most}" if found.count.max() <= most else f"{most} or more"
    bar.ax.set_yticklabels(["none: blind", *map(str, range(1, most)), last])
    bar.set_label("sensors that see it")
    figure.suptitle(f"{robot.name}: how many sensors see what stands there (white: sensors)")
    figure.savefig(file, dpi=90, bbox_inches="tight")
    pyplot.close(figure)
