"""Table 3 of paper 002: the person detector on simulated warehouse views."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from typing import Iterable, Sequence

import numpy as np

import safe_passage._person_detection as detection
from safe_passage.core.geometry import Pose, compose
from safe_passage.evaluation.detection_metrics import DetectionCounts, count_frame
from safe_passage.evaluation.views import FARTHEST, NEAREST, View
from safe_passage.simulation.robots import CameraModel
from safe_passage.simulation.truth import PersonTruth

GATE = 0.5  # [m] farthest a candidate's head may lie from the person that it is, over ground


@dataclass(frozen=True)
class Standard:
    """Who must be found: others may be found or missed."""

    visible: float  # share, at least
    height: float = 0.0  # [px] of the person's box, at least
    nearest: float = NEAREST  # [m] from the camera over ground
    farthest: float = FARTHEST  # [m]

    def wants(self, person: PersonTruth) -> bool:
        """Whether it must be found."""
        return (
            person.visible >= self.visible
            and person.box[3] >= self.height
            and self.nearest <= person.distance <= self.farthest
        )


# `reasonable` is that of the Caltech pedestrian benchmark: 50 pixels or taller, 35 % hidden at most
# (Dollar, Wojek, Schiele, Perona, "Pedestrian detection", PAMI 2012, section 4).
STANDARDS = {"reasonable": Standard(0.65, 50.0), "half_visible": Standard(0.5)}


@dataclass(frozen=True)
class PersonOutcome:
    """A person who was in a view, near enough and of whom anything was visible."""

    view: int
    distance: float  # [m]
    visible: float  # share
    found: bool


@dataclass
class DetectorScore:
    """What a detector made of views."""

    counts: dict[str, DetectionCounts] = field(  # by STANDARDS
        default_factory=lambda: dict.fromkeys(STANDARDS, DetectionCounts())
    )
    persons: list[PersonOutcome] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)  # [m] of accepted persons' places

    def __add__(self, other: DetectorScore) -> DetectorScore:
        return DetectorScore(
            {name: self.counts[name] + other.counts[name] for name in STANDARDS},
            self.persons + other.persons,
            self.errors + other.errors,
        )


def score_view(
    detector: detection.PersonDetector, view: View, camera: CameraModel, number: int
) -> DetectorScore:
    """One view; the detector sees it as its first, so that views may come in any order."""
    ranked = sorted(detect(detector, view, camera).detections, key=lambda d: -d.confidence)
    owned = [(d.accepted, *_owner(d, view, camera)) for d in ranked]
    found = {owner for accepted, owner, _ in owned if accepted}
    everybody = {person.id for person in view.persons}
    score = DetectorScore()
    for name, standard in STANDARDS.items():
        wanted = {person.id for person in view.persons if standard.wants(person)}
        candidates = [(accepted, owner) for accepted, owner, _ in owned]
        score.counts[name] = count_frame(candidates, wanted, everybody - wanted)
    score.errors = [error for accepted, owner, error in owned if accepted and owner is not None]
    score.persons = [
        PersonOutcome(number, p.distance, p.visible, p.id in found)
        for p in view.persons
        if NEAREST <= p.distance <= FARTHEST and p.visible > 0.0
    ]
    return score


def time_views(
    detector: detection.PersonDetector, views: Sequence[View], camera: CameraModel
) -> list[float]:
    """[ms] from picture and depth to persons, a view; the first view once more, to warm up."""
    times = []
    for view in [*views[:1], *views]:
        start = time.perf_counter()
        detect(detector, view, camera)
        times.append(1e3 * (time.perf_counter() - start))
    return times[1:]


def detect(
    detector: detection.PersonDetector, view: View, camera: CameraModel
) -> detection.DetectionResult:
    """What the detector says to a view that it knows nothing before."""
    detector.reset()
    T = camera.pose_in_base()
    frame = detection.from_depth(view.depth, view.bgr, detection.Intrinsics(*camera.intrinsics))
    return detector.detect(frame, detection.GroundPlane(T[2, :3], camera.z))


def recall_by(
    persons: Iterable[PersonOutcome], key: str, edges: Sequence[float]
) -> list[tuple[float, float, int, float]]:
    """Recall in bins of `distance` or `visible`: (from, to, persons, recall), NaN without any.

    A bin holds what lies from its lower edge on and under its upper one; the last one, that too.
    """
    rows = []
    listed = list(persons)
    for low, high in zip(edges, edges[1:]):
        last = high == edges[-1]
        inside = [
            person.found
            for person in listed
            if low <= getattr(person, key) < high or (last and getattr(person, key) == high)
        ]
        rows.append((low, high, len(inside), sum(inside) / len(inside) if inside else math.nan))
    return rows


def _owner(found: detection.Detection, view: View, camera: CameraModel) -> tuple[int | None, float]:
    """The person that a candidate is, and how far [m] its head lies from it."""
    place = head_in_map(found.candidate.head, view.pose, camera)
    distances = [np.hypot(*(place - p.position)) for p in view.persons]
    if not distances or min(distances) > GATE:
        return None, math.nan
    nearest = int(np.argmin(distances))
    return view.persons[nearest].id, float(distances[nearest])


def head_in_map(head: np.ndarray, pose: Pose, camera: CameraModel) -> np.ndarray:
    """(2,) [m] of a head (3,) in the detector's ground frame, whose origin is under the camera."""
    under = compose(pose, (camera.x, camera.y, camera.yaw))
    return np.array(compose(under, (float(head[0]), float(head[1]), 0.0))[:2])
