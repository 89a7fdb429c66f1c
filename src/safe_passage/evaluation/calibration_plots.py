"""The paper's Fig. 2: the sensor's points (green) and the model's (orange), before and after."""

from __future__ import annotations

from pathlib import Path
from typing import Sequence

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from safe_passage.calibration import ArmView, Calibration
from safe_passage.calibration.arm_surface import ArmSurface
from safe_passage.robot_model import PinholeCamera, RobotModel

GREEN, ORANGE = "#2ca02c", "#ff7f0e"
SHOWN = 6000  # points of each cloud
MARGIN = 0.25  # [m] around the arm


def draw_fit(
    model: RobotModel,
    camera: PinholeCamera,
    views: Sequence[ArmView],
    result: Calibration,
    file: Path,
) -> None:
    """All poses in one: as the guess has it, and as the calibration has it.

    Looked at from the side of the camera, so that an error along its rays shows.
    """
    surface = ArmSurface(model, camera, 2)
    figure, axes = plt.subplots(1, 2, figsize=(13, 6.5), sharex=True, sharey=True)
    side = result.T_root_camera[:3, 0] + 0.5 * result.T_root_camera[:3, 2]
    titles = ("before: the guess", f"after: {result.why}")
    for axis, T, title in zip(axes, (result.T_initial, result.T_root_camera), titles):
        model_points = np.concatenate([surface.visible(v.positions, T).points for v in views])
        sensor = np.concatenate([camera.points(v.depth) for v in views])
        sensor = sensor @ T[:3, :3].T + T[:3, 3]
        if len(model_points):  # else the camera looks away from the arm
            low, high = model_points.min(axis=0) - MARGIN, model_points.max(axis=0) + MARGIN
            sensor = sensor[((sensor > low) & (sensor < high)).all(axis=1)]
        for points, colour, name in ((sensor, GREEN, "sensor"), (model_points, ORANGE, "model")):
            shown = points[:: max(1, len(points) // SHOWN)]
            flat = _projected(shown, side)
            axis.plot(*flat.T, ".", color=colour, markersize=1.0, label=name)
        axis.set(title=title, aspect="equal", xlabel="[m]")
        axis.legend(loc="upper right", markerscale=8)
    figure.tight_layout()
    file.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(file, dpi=100)
    plt.close(figure)


def _projected(points: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """(N, 2) [m] as seen along a level `direction`: to the right, up."""
    level = direction * [1.0, 1.0, 0.0]
    level /= max(float(np.linalg.norm(level)), 1e-9)
    right = np.array([level[1], -level[0], 0.0])
    return np.stack([points @ right, points[:, 2]], axis=1)
