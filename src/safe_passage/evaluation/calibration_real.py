"""Calibration on the real recording of a KUKA LBR Med7 before a ZED2i (shared/data/arm_depth)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from safe_passage.calibration import ArmCalibrator, Calibration, CalibrationParameters
from safe_passage.calibration.arm_surface import ArmSurface
from safe_passage.calibration.recording import ArmRecording, read_folder
from safe_passage.calibration.writers import T_BODY_OPTICAL
from safe_passage.evaluation.calibration_trials import errors
from safe_passage.robot_model import RobotModel, load_robot_model

REFERENCES = ("HT_hydra_robust", "HT_dr")


@dataclass(frozen=True)
class RealArm:
    """The recording, and what others have made of it."""

    model: RobotModel
    recording: ArmRecording
    masks: list[np.ndarray]  # (H, W) bool of each pose: the arm
    references: dict[str, np.ndarray]  # T_root_camera (4, 4), published estimates


@dataclass(frozen=True)
class RealOutcome:
    """Of one calibration."""

    result: Calibration
    median: float  # [m] masked cloud to visible model, of the worst pose
    to_reference: dict[str, float]  # [m] between the camera's places
    at_arm: dict[str, float]  # [m] the same, mean over the points of the arm


def load_real_arm(recordings: Path) -> RealArm:
    """From `shared/data`."""
    description, folder = (
        recordings / "arm_depth" / name for name in ("lbr_description", "med7_zed2i")
    )
    model = load_robot_model(
        description / "urdf" / "med7" / "med7.urdf", {"lbr_description": description}
    )
    recording = read_folder(folder, model.movable, 0.5)
    masks = [
        cv2.imread(str(folder / f"mask_sam2_left_image_{i}.png"), cv2.IMREAD_GRAYSCALE) > 0
        for i in range(len(recording.views))
    ]
    references = {
        name: np.load(folder / f"{name}.npy").astype(float) @ T_BODY_OPTICAL for name in REFERENCES
    }
    return RealArm(model, recording, masks, references)


def calibrate_real(
    arm: RealArm, method: str, seed: int, translation: float, rotation: float
) -> RealOutcome:
    """From the first reference, off by `translation` [m] and `rotation` [rad] in any directions."""
    rng = np.random.default_rng(seed)
    axes = rng.normal(size=(2, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    guess = arm.references[REFERENCES[0]].copy()
    guess[:3, :3] = guess[:3, :3] @ Rotation.from_rotvec(rotation * axes[0]).as_matrix()
    guess[:3, 3] += translation * axes[1]
    camera, views = arm.recording.camera, arm.recording.views
    calibrator = ArmCalibrator(arm.model, camera, CalibrationParameters(method=method))
    result = calibrator.calibrate(views, guess)
    calibrator.close()
    T = result.T_root_camera
    arms = [camera.points(view.depth, mask) for view, mask in zip(views, arm.masks)]
    points = np.concatenate(arms)
    return RealOutcome(
        result,
        max(medians(arm, T)),
        {name: errors(T, other)[0] for name, other in arm.references.items()},
        {name: _apart(T, other, points) for name, other in arm.references.items()},
    )


def medians(arm: RealArm, T: np.ndarray) -> list[float]:
    """[m] of each pose: median distance of the masked cloud to the visible model at T (4, 4)."""
    camera = arm.recording.camera
    surface = ArmSurface(arm.model, camera)
    found = []
    for view, mask in zip(arm.recording.views, arm.masks):
        points = camera.points(view.depth, mask) @ T[:3, :3].T + T[:3, 3]
        model = surface.visible(view.positions, T).points
        found.append(float(np.median(cKDTree(model).query(points)[0])))
    surface.close()
    return found


def _apart(a: np.ndarray, b: np.ndarray, points: np.ndarray) -> float:
    moved = points @ (a - b)[:3, :3].T + (a - b)[:3, 3]
    return float(np.linalg.norm(moved, axis=1).mean())
