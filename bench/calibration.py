"""Calibration against the arm: simulated setups with known truth, and a real recording."""

from __future__ import annotations

import os
from itertools import product
from pathlib import Path

import numpy as np
from safe_passage.core.errors import InputError
from safe_passage.evaluation.calibration_real import (
    RealOutcome,
    calibrate_real,
    load_real_arm,
    medians,
)
from safe_passage.evaluation.calibration_report import (
    ROTATION,
    TRANSLATION,
    Job,
    Outcome,
    Variant,
    run_job,
    table,
)
from safe_passage.evaluation.parallel import Workers, run_jobs
from safe_passage.simulation.arms import find_urdf

from bench.metric import metric

IIWA = "pybullet_data/kuka_iiwa/model.urdf"
SEED = 20261
TRIALS, TRIALS_QUICK = 100, 2
REGION, REGION_QUICK = 10, 1  # setups on which the region of convergence is looked at
SCALES, SCALES_QUICK = (0.5, 1.0, 1.5, 2.0, 3.0), (1.0,)
REAL, REAL_QUICK = 5, 1  # guesses for the real recording
METHODS = ("GICP", "ICP", "PLANE_ICP")
WORKERS = Workers(os.cpu_count() or 1)


def run(quick: bool) -> list[dict]:
    """All metrics."""
    outcomes = simulated(quick)
    print(table(outcomes))
    return [*figures(outcomes), *real(REAL_QUICK if quick else REAL)]


def simulated(quick: bool) -> list[Outcome]:
    """Every variant on every setup that it is asked on."""
    kinds = list(product(("GICP", "ICP"), (5, 1)))
    asked = tuple(Variant(method, poses) for method, poses in kinds)
    scales = SCALES_QUICK if quick else SCALES
    plain = tuple(Variant(m, n, scale, False) for scale in scales for m, n in kinds)
    wider = tuple(Variant("GICP", 5, scale) for scale in scales if scale > 1.0)
    region = REGION_QUICK if quick else REGION
    urdf = find_urdf(IIWA)
    jobs = [
        Job(urdf, SEED, number, asked + (plain + wider if number < region else ()))
        for number in range(TRIALS_QUICK if quick else TRIALS)
    ]
    return [one for found in run_jobs(run_job, jobs, WORKERS, "setups") for one in found]


def figures(outcomes: list[Outcome]) -> list[dict]:
    """Of five poses by GICP, and of the others against it."""

    def of(variant: Variant) -> list[Outcome]:
        return [one for one in outcomes if one.variant == variant]

    ours = of(Variant())
    mm = 1e3 * np.array([one.translation for one in ours])
    degrees = np.degrees([one.rotation for one in ours])
    rows = [
        metric("rms_mm", 1e3 * float(np.median([one.rms for one in ours])), "mm", "<= 7"),
        metric("translation_error_mm", float(np.percentile(mm, 95)), "mm", "<= 3"),
        metric("rotation_error_deg", float(np.percentile(degrees, 95)), "deg", "<= 0.2"),
        metric("success_share", float(np.mean([one.success for one in ours])), "", ">= 0.95"),
        metric("translation_error_median_mm", float(np.median(mm)), "mm"),
        metric("rotation_error_median_deg", float(np.median(degrees)), "deg"),
        metric("held_out_rms_mm", 1e3 * float(np.median([o.held_out for o in ours])), "mm"),
        metric("wrong_result_share", share_wrong(ours), ""),
    ]
    for method, poses in product(("GICP", "ICP"), (5, 1)):
        name, own = f"{method.lower()}_{poses}", of(Variant(method, poses))
        rows.append(metric(f"right_share_{name}", share(own), ""))
        rows.append(
            metric(
                f"held_out_rms_{name}_mm", 1e3 * float(np.median([o.held_out for o in own])), "mm"
            )
        )
        widest = [
            one.scale
            for one in {o.variant for o in outcomes}
            if (one.method, one.poses, one.search) == (method, poses, False)
            and share(of(one)) >= 0.9
        ]
        reach = max(widest, default=0.0)
        rows.append(metric(f"region_{name}_cm", 100 * TRANSLATION * reach, "cm"))
        rows.append(metric(f"region_{name}_deg", float(np.degrees(ROTATION) * reach), "deg"))
    return rows


def share(outcomes: list[Outcome]) -> float:
    """Of those that came out right, whatever their verdict."""
    return float(np.mean([one.true for one in outcomes]))


def share_wrong(outcomes: list[Outcome]) -> float:
    """Of results given that are off by more than a success may be."""
    return float(np.mean([one.verdict.name == "OK" and not one.true for one in outcomes]))


def real(guesses: int) -> list[dict]:
    """The real recording, each method from the same guesses; not measured where it is not."""
    try:
        arm = load_real_arm(Path(os.environ.get("SAFE_PASSAGE_DATA", "../shared/data")))
    except InputError as error:
        print(error)
        return [metric("real_median_mm", None, "mm", "<= 8")]
    rows = []
    for method in METHODS:
        found = [
            calibrate_real(arm, method, seed, TRANSLATION, ROTATION) for seed in range(guesses)
        ]
        nearer = [1e3 * min(one.to_reference.values()) for one in found]
        tail = "" if method == "GICP" else f"_{method.lower()}"
        bars = ("<= 8", "<= 7") if method == "GICP" else ("", "")
        rows += [
            metric(f"real_median_mm{tail}", 1e3 * max(o.median for o in found), "mm", bars[0]),
            metric(f"real_to_reference_mm{tail}", max(nearer), "mm", bars[1]),
            metric(f"real_refused{tail}", sum(o.result.verdict.name != "OK" for o in found), ""),
            metric(f"real_standard_deviation_mm{tail}", 1e3 * max(map(spread, found)), "mm"),
        ]
        for name in arm.references:
            short = name[3:].split("_")[0]
            rows += [
                metric(f"real_to_{short}_mm{tail}", worst(found, "to_reference", name), "mm"),
                metric(f"real_at_arm_{short}_mm{tail}", worst(found, "at_arm", name), "mm"),
            ]
    for name, T in arm.references.items():
        short = name[3:].split("_")[0]
        rows.append(metric(f"real_median_of_{short}_mm", 1e3 * max(medians(arm, T)), "mm"))
    return rows


def spread(found: RealOutcome) -> float:
    """[m] that the result itself says of the camera's place; inf: nothing is known."""
    said = found.result.uncertainty
    return np.inf if said is None else said.translation


def worst(found: list, what: str, name: str) -> float:
    """[mm]"""
    return 1e3 * max(getattr(one, what)[name] for one in found)
