"""The paper's section 2.3 on simulated setups: method, number of poses, region of convergence."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from safe_passage.calibration import ArmCalibrator, CalibrationParameters, Verdict
from safe_passage.evaluation.calibration_trials import Trials, errors
from safe_passage.robot_model import load_robot_model

POSES = 5
TRANSLATION, ROTATION = 0.1, np.radians(10.0)  # [m], [rad] of a guess of scale 1
MOST_TRANSLATION, MOST_ROTATION = 0.003, np.radians(0.2)  # of a success


@dataclass(frozen=True)
class Variant:
    """One way to calibrate."""

    method: str = "GICP"
    poses: int = POSES
    scale: float = 1.0  # of the guess's error
    search: bool = True  # look around the guess first; without: the paper's way


@dataclass(frozen=True)
class Job:
    """One setup, calibrated in several ways."""

    urdf: Path
    seed: int
    number: int
    variants: tuple[Variant, ...]


@dataclass(frozen=True)
class Outcome:
    """Of one variant on one setup."""

    variant: Variant
    translation: float  # [m] off the truth
    rotation: float  # [rad]
    verdict: Verdict
    rms: float  # [m]
    held_out: float  # [m] rms in poses that were not calibrated by

    @property
    def true(self) -> bool:
        """Whether the camera's pose is right, whatever the verdict."""
        return self.translation <= MOST_TRANSLATION and self.rotation <= MOST_ROTATION

    @property
    def success(self) -> bool:
        """Right, and given as a result."""
        return self.true and self.verdict is Verdict.OK


def run_job(job: Job) -> list[Outcome]:
    """All variants on the same images."""
    trials = _trials(job.urdf, job.seed)
    setup = trials.setup(job.number, POSES)
    found = []
    for one in job.variants:
        parameters = CalibrationParameters(method=one.method, start_search=one.search)
        if not one.search:  # from as far as the search would
            far = (*parameters.start_distances[:2], *parameters.distances)
            parameters = CalibrationParameters(method=one.method, start_search=False, distances=far)
        calibrator = ArmCalibrator(trials.model, trials.scene.pinhole, parameters)
        guess = trials.guess(
            job.number, setup.T_root_camera, one.scale * TRANSLATION, one.scale * ROTATION
        )
        result = calibrator.calibrate(setup.views[: one.poses], guess)
        others = calibrator.evaluate(setup.held_out, result.T_root_camera)
        rms = float(np.mean([other.rms for other in others]))
        off = errors(result.T_root_camera, setup.T_root_camera)
        found.append(Outcome(one, *off, result.verdict, result.rms, rms))
        calibrator.close()
    return found


def table(outcomes: list[Outcome]) -> str:
    """A line a variant."""
    lines = [
        "method poses guess off     search | success refused wrong | error mm deg (median, p95)"
        " | rms mm, held out"
    ]
    for variant in dict.fromkeys(one.variant for one in outcomes):
        own = [one for one in outcomes if one.variant == variant]
        mm = 1e3 * np.array([one.translation for one in own])
        degrees = np.degrees([one.rotation for one in own])
        refused = np.mean([one.verdict is not Verdict.OK for one in own])
        wrong = np.mean([one.verdict is Verdict.OK and not one.true for one in own])
        rms, held_out = (
            1e3 * np.nanmedian([getattr(one, what) for one in own]) for what in ("rms", "held_out")
        )
        search = "yes" if variant.search else "no"
        asked = (
            f"{variant.method:<6} {variant.poses:>5} {100 * TRANSLATION * variant.scale:>4.0f} cm "
            f"{np.degrees(ROTATION) * variant.scale:>3.0f} deg {search:>6}"
        )
        lines.append(
            f"{asked} | {np.mean([one.success for one in own]):7.2f} {refused:7.2f} {wrong:5.2f} |"
            f" {np.median(mm):6.2f} {np.median(degrees):5.3f}, {np.percentile(mm, 95):7.2f}"
            f" {np.percentile(degrees, 95):6.3f} | {rms:5.2f} {held_out:5.2f}"
        )
    return "\n".join(lines)


@lru_cache(maxsize=1)
def _trials(urdf: Path, seed: int) -> Trials:
    return Trials(load_robot_model(urdf, {}), seed)
