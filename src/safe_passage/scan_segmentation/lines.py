"""Line segments of each scan line (paper 003, section II-A)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import safe_passage._scan_segmentation as kernels
from safe_passage.scan_segmentation.parameters import SegmentationParameters
from safe_passage.scan_segmentation.scan import OrganisedScan, from_line_images, line_images


@dataclass(frozen=True)
class Segments:
    """Sorted by line. Frame: the scanner's."""

    row: np.ndarray  # (S,) int, scan line
    first: np.ndarray  # (S,) int, column of its first point
    last: np.ndarray  # (S,) int, of its last
    start: np.ndarray  # (S, 3) [m]
    end: np.ndarray  # (S, 3) [m]

    def __len__(self) -> int:
        return len(self.row)

    @property
    def directions(self) -> np.ndarray:
        """(S, 3) unit."""
        along = self.end - self.start
        return along / np.linalg.norm(along, axis=1, keepdims=True)

    def of_points(self, shape: tuple[int, ...]) -> np.ndarray:
        """(H, W) int32: the segment of each point, -1: none."""
        found = np.full((shape[0], shape[1] + 1), 0, np.int32)
        # segments of a line do not overlap: what is added at its start is taken back after its end
        numbers = np.arange(1, len(self) + 1, dtype=np.int32)
        np.add.at(found, (self.row, self.first), numbers)
        np.add.at(found, (self.row, self.last + 1), -numbers)
        return np.cumsum(found, axis=1, dtype=np.int32)[:, :-1] - 1

    def inner_points(self, shape: tuple[int, ...]) -> np.ndarray:
        """(H, W) bool: points of segments that are no segment's first or last."""
        found = self.of_points(shape) >= 0
        found[self.row, self.first] = False
        found[self.row, self.last] = False
        return found


def find_segments(scan: OrganisedScan, p: SegmentationParameters) -> Segments:
    """All lines' segments: each line an image in its own plane, and back."""
    uv, y = line_images(scan)
    where, ends = kernels.find_segments(
        uv, p.line_tolerance, p.line_points, p.line_length, p.line_gap, p.line_gap_share
    )
    row, first, last = where.T
    beta = scan.beta[row]
    start = from_line_images(ends[:, :2], y[row, first], beta, scan)
    end = from_line_images(ends[:, 2:], y[row, last], beta, scan)
    return Segments(row, first, last, start, end)
