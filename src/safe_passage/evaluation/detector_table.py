"""Table 3 of paper 002: the person detector on simulated warehouse views."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np

import safe_passage._person_detection as detection
from safe_passage.core.geometry import Pose, compose
from safe_passage.evaluation.detection_metrics import DetectionCounts, count_frame
from safe_passage.evaluation.views import FARTHEST, NEAREST, View
from safe_passage.simulation.robots import CameraModel

WANTED = 0.5  # visible share from which a person must be found
GATE = 0.5  # [m] farthest a candidate's head may lie from the person that it is, over ground


@dataclass
class DetectorScore:
    """What a detector made of views."""

    counts: DetectionCounts = field(default_factory=DetectionCounts)
    milliseconds: list[float] = field(default_factory=list)  # a view
    errors: list[float] = field(default_factory=list)  # [m] of accepted persons' places
    missed: list[tuple[int, float, float]] = field(default_factory=list)  # view, distance, visible


def score_view(
    detector: detection.PersonDetector, view: View, camera: CameraModel, number: int
) -> DetectorScore:
    """One view; the detector sees it as its first, so that views may come in any order."""
    detector.reset()
    T = camera.pose_in_base()
    seed = detection.GroundPlane(T[2, :3], camera.z)
    start = time.perf_counter()
    frame = detection.from_depth(view.depth, view.bgr, detection.Intrinsics(*camera.intrinsics))
    result = detector.detect(frame, seed)
    score = DetectorScore(milliseconds=[1e3 * (time.perf_counter() - start)])
    wanted = {p.id for p in view.persons if is_wanted(p.distance, p.visible)}
    optional = {p.id for p in view.persons} - wanted
    ranked = sorted(result.detections, key=lambda d: -d.confidence)
    owned = [(d.accepted, *_owner(d, view, camera)) for d in ranked]
    score.counts = count_frame(
        [(accepted, owner) for accepted, owner, _ in owned], wanted, optional
    )
    found = {owner for accepted, owner, _ in owned if accepted}
    score.errors = [error for accepted, owner, error in owned if accepted and owner is not None]
    score.missed = [(number, p.distance, p.visible) for p in view.persons if p.id in wanted - found]
    return score


def is_wanted(distance: float, visible: float) -> bool:
    """Whether a person at `distance` [m] with this share visible must be found."""
    return visible >= WANTED and NEAREST <= distance <= FARTHEST


def _owner(found: detection.Detection, view: View, camera: CameraModel) -> tuple[int | None, float]:
    """The person that a candidate is, and how far [m] its head lies from it."""
    place = head_in_map(found.candidate.head, view.pose, camera)
    distances = [np.hypot(*(place - p.position)) for p in view.persons]
    if not distances or min(distances) > GATE:
        return None, float("nan")
    nearest = int(np.argmin(distances))
    return view.persons[nearest].id, float(distances[nearest])


def head_in_map(head: np.ndarray, pose: Pose, camera: CameraModel) -> np.ndarray:
    """(2,) [m] of a head (3,) in the detector's ground frame, whose origin is under the camera."""
    under = compose(pose, (camera.x, camera.y, camera.yaw))
    return np.array(compose(under, (float(head[0]), float(head[1]), 0.0))[:2])
