"""The paper's own line detection: a Hough transform of each scan line's image (section II-A)."""

from __future__ import annotations

import math

import cv2
import numpy as np

from safe_passage.scan_segmentation.lines import Segments, find_segments
from safe_passage.scan_segmentation.parameters import SegmentationParameters
from safe_passage.scan_segmentation.scan import OrganisedScan, line_images

PIXEL = 0.02  # [m]
NEAR = 0.06  # [m] of a segment that the other method has found, too
STEP = 0.05  # [m] between places looked at along a segment


def hough_segments(uv: np.ndarray, p: SegmentationParameters) -> np.ndarray:
    """(K, 4) [m] start and end of segments of one line of points (W, 2), by OpenCV."""
    points = uv[np.isfinite(uv).all(axis=1)]
    if len(points) < p.line_points:
        return np.empty((0, 4))
    low = points.min(axis=0) - 2 * PIXEL
    column, row = np.floor((points - low) / PIXEL).astype(int).T
    image = np.zeros((int(row.max()) + 3, int(column.max()) + 3), np.uint8)
    image[row, column] = 255
    found = cv2.HoughLinesP(
        image,
        1.0,
        math.pi / 180.0,
        p.line_points,
        minLineLength=p.line_length / PIXEL,
        maxLineGap=p.line_gap / PIXEL,
    )
    if found is None:
        return np.empty((0, 4))
    return (found[:, 0] + 0.5) * PIXEL + np.tile(low, 2)


def agreement(scan: OrganisedScan, p: SegmentationParameters) -> tuple[float, float]:
    """Share of the length of our segments that Hough's cover, and the other way round."""
    uv, _ = line_images(scan)
    ours = _ends(scan, find_segments(scan, p), uv)
    mutual = np.zeros((2, 2))  # covered and whole length of ours, of Hough's
    for row in range(len(uv)):
        mine, theirs = ours[row], hough_segments(uv[row], p)
        mutual[0] += _covered(mine, theirs)
        mutual[1] += _covered(theirs, mine)
    shares = mutual[:, 0] / np.maximum(mutual[:, 1], 1e-9)
    return float(shares[0]), float(shares[1])


def _ends(scan: OrganisedScan, segments: Segments, uv: np.ndarray) -> list[np.ndarray]:
    """(K, 4) of each line: our segments in its image."""
    found = [np.empty((0, 4))] * len(uv)
    for row in np.unique(segments.row):
        of = segments.row == row
        ends = [uv[row, segments.first[of]], uv[row, segments.last[of]]]
        found[row] = np.hstack(ends)
    return found


def _covered(of: np.ndarray, by: np.ndarray) -> np.ndarray:
    """[m] of segments (K, 4) that are near one of the others, and all of them."""
    total, near = 0.0, 0.0
    for segment in of:
        length = float(np.linalg.norm(segment[2:] - segment[:2]))
        count = max(2, math.ceil(length / STEP))
        at = segment[:2] + np.linspace(0, 1, count)[:, None] * (segment[2:] - segment[:2])
        total += length
        if len(by):
            along = by[:, 2:] - by[:, :2]
            squared = np.maximum((along**2).sum(axis=1), 1e-12)
            share = np.clip(((at[:, None] - by[:, :2]) * along).sum(axis=2) / squared, 0.0, 1.0)
            off = at[:, None] - by[:, :2] - share[..., None] * along
            near += length * float((np.linalg.norm(off, axis=2).min(axis=1) < NEAR).mean())
    return np.array([near, total])
