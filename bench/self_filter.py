"""The self-filter: robot pixels it takes away, people's it takes by mistake, images a second."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from safe_passage.evaluation.self_filter_report import Score, Trial, compare
from safe_passage.robot_model import load_robot_model
from safe_passage.self_filter import SelfFilterParameters
from safe_passage.simulation.arm_scene import Owner
from safe_passage.simulation.arms import find_urdf

from bench.metric import metric

IIWA = "pybullet_data/kuka_iiwa/model.urdf"
FRAMES, FRAMES_QUICK = 1000, 60
SEED = 20260


def hz(score: Score) -> float:
    """Images a second, by the median of the frames after the first ones."""
    return 1.0 / float(np.median(score.seconds[5:]))


def run(quick: bool) -> list[dict]:
    """All metrics."""
    model = load_robot_model(find_urdf(IIWA), {})
    trial = Trial(FRAMES_QUICK if quick else FRAMES, SEED)
    scores = compare(model, SelfFilterParameters(), trial)
    near = compare(model, SelfFilterParameters(), replace(trial, clearance=0.05))
    ours = scores["drawn"]
    rows = [
        metric("robot_removed_share", ours.share(Owner.ROBOT), "", ">= 0.995"),
        metric("person_lost_share", ours.share(Owner.PERSON), "", "<= 0.005"),
        metric("self_filter_hz", hz(ours), "Hz", ">= 30"),
        metric("self_filter_p99_ms", 1e3 * float(np.percentile(ours.seconds[5:], 99)), "ms"),
        metric("robot_left_share_worst_frame", ours.worst, ""),
        metric("room_lost_share", ours.share(Owner.ROOM), ""),
        metric("person_lost_share_5cm", near["drawn"].share(Owner.PERSON), ""),
    ]
    for shape in ("box", "sphere"):
        other = scores[shape]
        rows += [
            metric(f"robot_removed_share_{shape}", other.share(Owner.ROBOT), ""),
            metric(f"person_lost_share_{shape}", other.share(Owner.PERSON), ""),
            metric(f"person_lost_share_5cm_{shape}", near[shape].share(Owner.PERSON), ""),
            metric(f"self_filter_speed_ratio_{shape}", hz(ours) / hz(other), ""),
        ]
    return rows
