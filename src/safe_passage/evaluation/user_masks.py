"""Detections against masks of persons: one label a person, as a user tracker writes them."""

from __future__ import annotations

from typing import Any, Iterable

import cv2
import numpy as np

from safe_passage.evaluation.detection_metrics import DetectionCounts, count_frame

LEAST_PERSON = 2000  # [px] smaller regions of a mask are its specks
LEAST_SHARE = 0.5  # of a candidate's own points that must lie on a person to be that person


def persons_in(mask: np.ndarray) -> list[np.ndarray]:
    """Boolean masks (H, W), one a person: by label, and by region where all have the label 255."""
    persons = []
    for label in np.unique(mask[mask > 0]):
        _, regions = cv2.connectedComponents((mask == label).astype(np.uint8))
        sizes = np.bincount(regions.ravel())[1:]
        if label == 255:
            persons += [regions == 1 + i for i, size in enumerate(sizes) if size >= LEAST_PERSON]
        elif sizes.sum() >= LEAST_PERSON:
            persons.append(mask == label)
    return persons


def judge(
    detections: Iterable[Any], pixels: Iterable[np.ndarray], persons: list[np.ndarray]
) -> DetectionCounts:
    """Count one frame.

    Args:
        detections: with `accepted`, the surest first.
        pixels: for each, its own points in the image (N, 2) as integer column, row.
        persons: masks from `persons_in`.

    A candidate is the person on which most of its points lie.
    """
    owners = ((d.accepted, _owner(points, persons)) for d, points in zip(detections, pixels))
    return count_frame(owners, range(len(persons)))


def _owner(points: np.ndarray, persons: list[np.ndarray]) -> int | None:
    if not persons or not len(points):
        return None
    height, width = persons[0].shape
    column, row = points[:, 0], points[:, 1]
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    shares = [person[row[inside], column[inside]].sum() / len(points) for person in persons]
    best = int(np.argmax(shares))
    return best if shares[best] >= LEAST_SHARE else None
