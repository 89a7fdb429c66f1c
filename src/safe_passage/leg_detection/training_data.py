"""Labelled segments: what the classifiers are trained on and judged by.

Scans of one scanner follow each other ten times a second and are all but copies, so data is never
split by scan: a whole recording, or a whole place, is trained on or judged by (`groups`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable, Sequence

import numpy as np

from safe_passage.leg_detection.features import FEATURE_NAMES, beam_speeds, segment_features
from safe_passage.leg_detection.scan import Scan
from safe_passage.leg_detection.segmentation import SegmentationParameters, Segments, segment

LEG, OTHER, UNKNOWN = 1, 0, -1
LEG_TOLERANCE = 0.1  # [m] from a leg's position to the nearest point of its segment
PERSON_RADIUS = 0.5  # [m] about a leg: what else is there may be the same person's
BACKGROUND_TOLERANCE = 0.1  # [m] a beam that meets the same thing again
BACKGROUND_SHARE = 0.5  # of a recording's scans: seen more often, a thing is furniture


@dataclass(frozen=True)
class LegRecording:
    """Scans of one scanner with the positions of legs in them."""

    name: str
    scans: Sequence[Scan]  # in order of time
    legs: Sequence[np.ndarray] | None  # (L, 2) [m] a scan, scanner's frame; None: nobody is there


@dataclass(frozen=True)
class LabelledScan:
    """A scan of which the truth is known beam by beam, as a simulator knows it."""

    scan: Scan
    person_beams: np.ndarray  # (N,) bool, beams that meet a person


@dataclass(frozen=True)
class LabelledSegments:
    """Segments of many scans, those with enough points only."""

    features: np.ndarray  # (K, 14)
    labels: np.ndarray  # (K,) int: LEG, OTHER, UNKNOWN
    groups: np.ndarray  # (K,) str, the recording that each comes from

    @property
    def known(self) -> LabelledSegments:
        """Without the UNKNOWN ones."""
        return self.where(self.labels != UNKNOWN)

    def where(self, chosen: np.ndarray) -> LabelledSegments:
        """Those of which `chosen` (K,) bool is true."""
        return LabelledSegments(self.features[chosen], self.labels[chosen], self.groups[chosen])

    def count(self, label: int) -> int:
        """How many have this label."""
        return int((self.labels == label).sum())


def joined(parts: Iterable[LabelledSegments]) -> LabelledSegments:
    """All of them as one."""
    listed = list(parts)
    if not listed:
        empty = np.zeros((0, len(FEATURE_NAMES)))
        return LabelledSegments(empty, np.zeros(0, int), np.zeros(0, str))
    return LabelledSegments(
        np.concatenate([part.features for part in listed]),
        np.concatenate([part.labels for part in listed]),
        np.concatenate([part.groups for part in listed]),
    )


def from_recording(
    recording: LegRecording, parameters: SegmentationParameters, blocks: int = 1
) -> LabelledSegments:
    """Labels by leg positions.

    LEG: of each leg position the segment with the nearest point, if that is within LEG_TOLERANCE.
    Recordings mark the legs of those persons who walked for them, not all: others pass by. So the
    rest is OTHER only where it is known to be furniture, because beams met it at the same range in
    BACKGROUND_SHARE of the scans (the scanner stood still); what came and went, and what is within
    PERSON_RADIUS of a leg, is UNKNOWN. Who stands still through half a recording and is not marked
    is furniture to this rule. Without leg positions (nobody was there) everything is OTHER.

    blocks: groups that the recording makes, each a stretch of time, `name 1` to `name N`.
    """
    labelled = []
    background = None if recording.legs is None else background_beams(recording.scans)
    for i, (segments, features) in enumerate(_cut(recording.scans, parameters)):
        if recording.legs is None or background is None:
            labels = np.full(len(segments), OTHER)
        else:
            labels = label_by_legs(segments, recording.legs[i], background[i])
        block = f" {1 + blocks * i // len(recording.scans)}" if blocks > 1 else ""
        labelled.append(_enough(segments, features, labels, parameters, recording.name + block))
    return joined(labelled)


def from_labelled_scans(
    scans: Sequence[LabelledScan], parameters: SegmentationParameters, name: str, judging: bool
) -> LabelledSegments:
    """Labels by beams; the scans are of one scanner, in order of time.

    LEG: at least half of the points are a person's. OTHER: none is. In between, a leg is hidden in
    something larger. To train by it would teach walls: UNKNOWN. But judging, it is a leg that has
    to be found, provided that `min_points` of it are seen.
    """
    labelled = []
    cut = _cut([labelled_scan.scan for labelled_scan in scans], parameters)
    for labelled_scan, (segments, features) in zip(scans, cut):
        of_person = segments.sums(labelled_scan.person_beams[segments.beams].astype(float))
        labels = np.where(of_person > 0, UNKNOWN, OTHER)
        labels[2 * of_person >= segments.sizes] = LEG
        if judging:
            hidden = labels == UNKNOWN
            labels[hidden] = np.where(of_person[hidden] >= parameters.min_points, LEG, OTHER)
        labelled.append(_enough(segments, features, labels, parameters, name))
    return joined(labelled)


def label_by_legs(segments: Segments, legs: np.ndarray, background: np.ndarray) -> np.ndarray:
    """Labels (K,) of one scan's segments, see `from_recording`.

    Args:
        legs: (L, 2) [m] in the scanner's frame.
        background: (N,) bool, beams that met furniture.
    """
    furniture = 2.0 * segments.sums(background[segments.beams].astype(float)) >= segments.sizes
    labels = np.where(furniture, OTHER, UNKNOWN)
    if not len(segments):
        return labels
    for leg in legs:
        distances = np.linalg.norm(segments.points - leg, axis=1)
        near = np.unique(segments.owners[distances <= PERSON_RADIUS])
        labels[near] = np.where(labels[near] == LEG, LEG, UNKNOWN)
        nearest = int(np.argmin(distances))
        if distances[nearest] <= LEG_TOLERANCE:
            labels[segments.owners[nearest]] = LEG
    return labels


def background_beams(scans: Sequence[Scan]) -> np.ndarray:
    """Which returns (T, N) bool lie where the same beam met something in most of the scans."""
    ranges = np.array([np.where(scan.returns(), scan.ranges, np.nan) for scan in scans])
    with np.errstate(invalid="ignore"):
        again = [
            (np.abs(ranges - now) <= BACKGROUND_TOLERANCE).mean(axis=0) >= BACKGROUND_SHARE
            for now in ranges
        ]
    return np.array(again)


def _cut(
    scans: Sequence[Scan], parameters: SegmentationParameters
) -> Iterable[tuple[Segments, np.ndarray]]:
    """Segments and features (K, 14) of each scan, speeds from the scan before it."""
    before = None
    for scan in scans:
        segments = segment(scan, parameters.jump_distance)
        yield (
            segments,
            segment_features(segments, beam_speeds(scan, before, parameters.max_scan_gap)),
        )
        before = scan


def _enough(
    segments: Segments,
    features: np.ndarray,
    labels: np.ndarray,
    parameters: SegmentationParameters,
    name: str,
) -> LabelledSegments:
    """Those with at least `min_points`."""
    groups = np.full(len(segments), name)
    return LabelledSegments(features, labels, groups).where(segments.sizes >= parameters.min_points)
