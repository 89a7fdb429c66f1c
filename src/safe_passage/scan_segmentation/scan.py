"""One scan of a rotating 2D scanner, and where up is."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field
from typing import Tuple

import numpy as np

from safe_passage.core.errors import InputError, SafePassageError

Vector = Tuple[float, float, float]
MIN_LINES, MIN_POINTS = 8, 200  # fewer make no scan of a place


class Reason(enum.Enum):
    """Why a scan was not segmented."""

    TOO_FEW_POINTS = "too few points"
    DEGENERATE = "degenerate cloud"
    NO_PLANE = "no plane validated"
    NO_GROUND = "no ground plane"
    SCANNER_BELOW_GROUND = "scanner below the ground"
    FEW_GROUND_POINTS = "too few ground points"
    CANCELLED = "cancelled"


class SegmentationError(SafePassageError):
    """The scan does not support a result, so there is none: the reason, and what was seen."""

    def __init__(self, reason: Reason, detail: str) -> None:
        super().__init__(f"{reason.value}: {detail}")
        self.reason = reason


@dataclass(frozen=True)
class OrganisedScan:
    """Scan lines of one (half) revolution. Frame: the scanner's, any orientation."""

    points: np.ndarray  # (H, W, 3) [m], a row is a scan line, NaN = no return
    beta: np.ndarray  # (H,) [rad] about the axis at which each line was taken
    remission: np.ndarray | None = None  # (H, W), any scale
    axis: Vector = (0.0, 0.0, 1.0)  # unit, of the rotation
    origin: Vector = (0.0, 0.0, 0.0)  # [m] of the scanner
    up: Vector = (0.0, 0.0, 1.0)  # unit, against gravity
    notes: tuple[str, ...] = field(default=())  # what was done to it on the way in

    def __post_init__(self) -> None:
        if self.points.ndim != 3 or self.points.shape[2] != 3:
            raise InputError(f"scan: points are {self.points.shape}, must be (lines, points, 3)")
        if self.beta.shape != self.points.shape[:1]:
            raise InputError(f"scan: {len(self.beta)} angles for {len(self.points)} lines")
        if self.remission is not None and self.remission.shape != self.points.shape[:2]:
            raise InputError(f"scan: remission is {self.remission.shape}, not as the points")
        for name in ("axis", "up"):
            if not abs(np.linalg.norm(getattr(self, name)) - 1.0) < 1e-6:
                raise InputError(f"scan: {name} {getattr(self, name)} is no unit vector")

    @property
    def valid(self) -> np.ndarray:
        """(H, W) bool: where something was hit."""
        return np.isfinite(self.points).all(axis=2)


def to_cartesian(ranges: np.ndarray, alpha: np.ndarray, beta: np.ndarray) -> np.ndarray:
    """Points (H, W, 3) of ranges (H, W) [m]: equations 1 to 3. Non-finite ranges give NaN.

    Args:
        alpha: (W,) [rad] of the beams over the plane that the rotation axis is normal to.
        beta: (H,) [rad] of the lines.
    """
    ranges = np.where(np.isfinite(ranges), ranges, np.nan)
    across = np.cos(alpha) * ranges
    x, y = np.cos(beta)[:, None] * across, np.sin(beta)[:, None] * across
    return np.stack([x, y, np.sin(alpha) * ranges], axis=-1)


def axis_rotation(axis: Vector) -> np.ndarray:
    """(3, 3) that turns the scanner's frame so that `axis` becomes z."""
    z = np.asarray(axis, float)
    x = np.array([1.0, 0.0, 0.0]) if abs(z[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    x = x - z * (x @ z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z])


def line_images(scan: OrganisedScan) -> tuple[np.ndarray, np.ndarray]:
    """Each line turned into its plane (equations 4 and 5): u, v (H, W, 2) [m], and y' (H, W).

    y' is zero where the scanner lies on the axis, and small and alike along a line beside it.
    """
    R = axis_rotation(scan.axis)
    centred = (scan.points - np.asarray(scan.origin)) @ R.T
    c, s = np.cos(scan.beta)[:, None], np.sin(scan.beta)[:, None]
    x = c * centred[..., 0] + s * centred[..., 1]
    y = c * centred[..., 1] - s * centred[..., 0]
    return np.stack([x, centred[..., 2]], axis=-1), y


def from_line_images(
    uv: np.ndarray, y: np.ndarray, beta: np.ndarray, scan: OrganisedScan
) -> np.ndarray:
    """The way back (equation 4 with -beta): points (N, 3) of uv (N, 2), y (N,) and beta (N,)."""
    c, s = np.cos(beta), np.sin(beta)
    turned = np.stack([c * uv[:, 0] - s * y, s * uv[:, 0] + c * y, uv[:, 1]], axis=-1)
    return turned @ axis_rotation(scan.axis) + np.asarray(scan.origin)


@dataclass(frozen=True)
class Level:
    """A frame with z up and its origin in the scanner."""

    R_level_scan: np.ndarray  # (3, 3)
    origin: np.ndarray  # (3,) [m] in the scanner's frame

    @staticmethod
    def of(scan: OrganisedScan) -> Level:
        """x: where the axis points to over the floor; of an upright one, the scanner's own x."""
        up = np.asarray(scan.up, float)
        for forward in (np.asarray(scan.axis), np.eye(3)[0], np.eye(3)[1]):
            x = forward - up * (up @ forward)
            if np.linalg.norm(x) > 0.3:
                break
        x = x / np.linalg.norm(x)
        return Level(np.stack([x, np.cross(up, x), up]), np.asarray(scan.origin, float))

    def points(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) of the scanner's frame in this one."""
        return (points - self.origin) @ self.R_level_scan.T

    def back(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) of this frame in the scanner's."""
        return points @ self.R_level_scan + self.origin


def unique_cells(points: np.ndarray, cell: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cells (M, D) that hold points (N, D), one point (M,) of each, and the cell (N,) of each."""
    if not len(points):
        empty = np.empty(0, int)
        return np.empty(points.shape, int), empty, empty
    at = np.floor(points / cell).astype(np.int64)
    low = at.min(axis=0)
    size = at.max(axis=0) - low + 1
    key = np.zeros(len(at), np.int64)  # np.unique of rows is several times slower
    for column, count in zip((at - low).T, size):
        key = key * count + column
    _, first, of = np.unique(key, return_index=True, return_inverse=True)
    return at[first], first, of
