"""The pictures of docs/: `python3 -m safe_passage.evaluation.arm_pictures FOLDER`."""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np

from safe_passage.calibration import ArmCalibrator, CalibrationParameters
from safe_passage.evaluation.calibration_plots import draw_fit
from safe_passage.evaluation.calibration_report import POSES, ROTATION, TRANSLATION
from safe_passage.evaluation.calibration_trials import Trials
from safe_passage.evaluation.self_filter_report import Frames, Trial
from safe_passage.robot_model import RobotModel, load_robot_model
from safe_passage.self_filter import SelfFilter, SelfFilterParameters
from safe_passage.simulation.arms import find_urdf

IIWA = "pybullet_data/kuka_iiwa/model.urdf"
NEAR, FAR = 0.5, 4.0  # [m] of the colours
SEED = 5


def draw_self_filter(model: RobotModel, file: Path, frames: int = 2) -> None:
    """A row a frame: what the camera measures, and what is left of it."""
    made = Frames(model, Trial(frames, SEED))
    ours = SelfFilter(model, made.scene.pinhole, SelfFilterParameters())
    rows = []
    for number in range(frames):
        one = made.frame(number)
        left = ours.filter(one.view.depth, one.stamp, one.joints, one.T_camera_root)
        rows.append(np.hstack([_coloured(one.view.depth), _coloured(left.depth)]))
    cv2.imwrite(str(file), cv2.resize(np.vstack(rows), None, fx=0.7, fy=0.7))


def draw_calibration(model: RobotModel, file: Path) -> None:
    """The paper's Fig. 2, of five poses."""
    trials = Trials(model, SEED)
    setup = trials.setup(0, POSES)
    guess = trials.guess(0, setup.T_root_camera, TRANSLATION, ROTATION)
    camera = trials.scene.pinhole
    result = ArmCalibrator(model, camera, CalibrationParameters()).calibrate(setup.views, guess)
    draw_fit(model, camera, setup.views, result, file)


def _coloured(depth: np.ndarray) -> np.ndarray:
    """Red near, blue far, black where there is no depth."""
    shade = 255 * (1.0 - np.clip((np.nan_to_num(depth) - NEAR) / (FAR - NEAR), 0.0, 1.0))
    image = cv2.applyColorMap(shade.astype(np.uint8), cv2.COLORMAP_JET)
    image[~np.isfinite(depth)] = 0
    return image


if __name__ == "__main__":
    iiwa, folder = load_robot_model(find_urdf(IIWA), {}), Path(sys.argv[1])
    draw_self_filter(iiwa, folder / "depth_self_filter.png")
    draw_calibration(iiwa, folder / "calibrate_camera.png")
