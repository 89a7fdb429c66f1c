"""A rectified camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from safe_passage.core.errors import InputError
from safe_passage.core.parameters import check_range


@dataclass(frozen=True)
class PinholeCamera:
    """Optical frame: x right, y down, z forward. Pixel (u, v) has its centre at (u, v)."""

    width: int  # [px]
    height: int  # [px]
    fx: float  # [px]
    fy: float  # [px]
    cx: float  # [px]
    cy: float  # [px]

    def __post_init__(self) -> None:
        check_range("width", self.width, 1, 16384, "px")
        check_range("height", self.height, 1, 16384, "px")
        check_range("fx", self.fx, 1e-3, 1e6, "px")
        check_range("fy", self.fy, 1e-3, 1e6, "px")
        check_range("cx", self.cx, -1e5, 1e5, "px")
        check_range("cy", self.cy, -1e5, 1e5, "px")

    @classmethod
    def of_matrix(cls, matrix: np.ndarray, width: int, height: int) -> PinholeCamera:
        """Of K (3, 3) or the left part of P."""
        K = np.asarray(matrix, float)
        if K.ndim != 2 or K.shape[0] != 3 or not np.isfinite(K).all():
            raise InputError(f"camera matrix {K.tolist()}: must be 3 x 3 and finite")
        return cls(width, height, float(K[0, 0]), float(K[1, 1]), float(K[0, 2]), float(K[1, 2]))

    def points(self, depth: np.ndarray, pixels: np.ndarray | None = None) -> np.ndarray:
        """Points (N, 3) [m] in the optical frame of the pixels with a depth, row by row.

        Args:
            depth: (height, width) [m], NaN = none.
            pixels: (height, width) bool, which ones are wanted; all without it.
        """
        wanted = np.isfinite(depth) if pixels is None else np.isfinite(depth) & pixels
        v, u = np.nonzero(wanted)
        z = depth[v, u].astype(float)
        return np.stack([(u - self.cx) / self.fx * z, (v - self.cy) / self.fy * z, z], axis=1)

    def pixels(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows, columns (whole pixels) and whether inside the picture, of `points` (N, 3) [m]."""
        z = points[:, 2]
        ahead = z > 1e-6
        safe = np.where(ahead, z, 1.0)
        u = np.rint(self.fx * points[:, 0] / safe + self.cx)
        v = np.rint(self.fy * points[:, 1] / safe + self.cy)
        inside = ahead & (u >= 0) & (u < self.width) & (v >= 0) & (v < self.height)
        return np.where(inside, v, 0).astype(int), np.where(inside, u, 0).astype(int), inside
