"""How far each object has moved, by laying its shape on its track's (paper 000, 4.3).

The search itself is C++ (`include/safe_passage/monitoring/shape_alignment.h`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from safe_passage._monitoring import ShapeAligner
from safe_passage.monitoring.ragged import Ragged

LEAST = 0.05  # [cells] of the information, along a wall


@dataclass(frozen=True)
class Alignments:
    """N pairs of shapes."""

    displacement: np.ndarray  # (N, 2) [m] of the seen shape against the predicted one
    overlap: np.ndarray  # (N,) share of the smaller shape on the other
    noise: np.ndarray  # (N, 2, 2) [m^2] covariance of the displacement


def align(aligner: ShapeAligner, seen: Ragged, predicted: Ragged, sigma: float) -> Alignments:
    """The displacement of each seen shape that makes it overlap most with the predicted one.

    Args:
        seen, predicted: N shapes each, points (M, 2) [m] in the same frame.
        sigma: [m] standard deviation of a displacement of which a cell loses one cell of overlap.
    """
    displacement, overlap, information = aligner.align_all(
        seen.values, seen.start, predicted.values, predicted.start
    )
    values, vectors = np.linalg.eigh(information)
    spread = sigma**2 / np.clip(values, LEAST, None)
    noise = np.einsum("nij,nj,nkj->nik", vectors, spread, vectors)
    return Alignments(displacement, overlap, noise)
