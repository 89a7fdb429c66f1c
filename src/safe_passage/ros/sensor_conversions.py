"""Scans and clouds to arrays, or the reason why that is not possible."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from sensor_msgs.msg import LaserScan, PointCloud2, PointField

from safe_passage.ros.diagnostics import Outcome

SPARE_BEAMS = 0.01  # share of a scan's beams by which its angles may be off


class UnusableMessageError(Exception):
    """A message that cannot be used, and why."""

    def __init__(self, outcome: Outcome, detail: str) -> None:
        super().__init__(detail)
        self.outcome = outcome


@dataclass(frozen=True)
class Beams:
    """A scan."""

    ranges: np.ndarray  # (N,) float32 [m], NaN: no return within the scanner's range
    angle_min: float  # [rad] of the first beam, the scanner's frame
    angle_increment: float  # [rad], negative: the scanner turns clockwise

    def angles(self) -> np.ndarray:
        """(N,) [rad]"""
        return self.angle_min + self.angle_increment * np.arange(len(self.ranges))


def scan_beams(scan: LaserScan) -> Beams:
    """The scan's beams; raises UnusableMessageError."""
    ranges = scan_ranges(scan)
    with np.errstate(invalid="ignore"):
        inside = (ranges >= scan.range_min) & (ranges <= scan.range_max)
    measured = np.where(inside, ranges, np.float32(np.nan))
    return Beams(measured, scan.angle_min, scan.angle_increment)


def scan_ranges(scan: LaserScan) -> np.ndarray:
    """Ranges (N,) float32 [m] as the scan has them; raises UnusableMessageError."""
    geometry = (scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max)
    if not np.isfinite(geometry).all() or scan.range_max <= scan.range_min:
        raise UnusableMessageError(Outcome.BAD_FIELDS, f"angles and range limits {geometry}")
    if not scan.ranges:
        raise UnusableMessageError(Outcome.EMPTY, "no beams")
    if scan.angle_increment == 0.0 and len(scan.ranges) > 1:
        raise UnusableMessageError(Outcome.BAD_FIELDS, "every beam has the same direction")
    check_count(scan)
    ranges = np.array(scan.ranges, dtype=np.float32)
    if np.isnan(ranges).all():
        raise UnusableMessageError(Outcome.NOT_FINITE, "every range is NaN")
    return ranges


def check_count(scan: LaserScan) -> None:
    """Raise UnusableMessageError if beams are missing, or are too many for the scan's angles.

    A scan that is torn leaves blind what the scanner is there to see. Drivers are off by one.
    """
    count = len(scan.ranges)
    if count == 1:
        return
    told = (scan.angle_max - scan.angle_min) / scan.angle_increment + 1.0
    if not abs(count - told) <= max(2.0, SPARE_BEAMS * told):  # NaN compares false
        what = f"{count} beams, angles of {told:.0f}"
        raise UnusableMessageError(Outcome.BAD_FIELDS, what)


def cloud_xyz(cloud: PointCloud2) -> np.ndarray:
    """Points (N, 3) float32 [m], the cloud's frame; raises UnusableMessageError."""
    return refuse_nan(_stacked(cloud_grid(cloud)))


def sampled_xyz(cloud: PointCloud2, reach: float, spacing: float) -> np.ndarray:
    """The same, of an organised cloud only pixels that lie up to `spacing` [m] apart.

    reach: [m] from the sensor at which they do; nearer they are closer together.
    """
    grid = cloud_grid(cloud)
    if 1 in grid.shape:
        return refuse_nan(_stacked(grid))
    height, width = grid.shape
    v = _pixel_step(_stacked(grid[:, width // 2]), spacing / reach)
    u = _pixel_step(_stacked(grid[height // 2]), spacing / reach)
    return refuse_nan(_stacked(grid[v // 2 :: v, u // 2 :: u]))


def _pixel_step(line: np.ndarray, angle: float) -> int:
    """How many pixels of a picture's row or column (N, 3) lie within `angle` [rad], at least 1."""
    with np.errstate(invalid="ignore"):
        directions = line / np.linalg.norm(line, axis=1)[:, None]
    gaps = np.linalg.norm(np.diff(directions, axis=0), axis=1)
    gaps = gaps[gaps > 0.0]  # NaN compares false
    return max(1, int(angle / gaps.max())) if len(gaps) else 1


NUMBERS = dict(enumerate(("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8"), 1))  # of PointField


def cloud_grid(cloud: PointCloud2, optional: tuple[str, ...] = ()) -> np.ndarray:
    """View (H, W) with fields x, y, z of the cloud's bytes; raises UnusableMessageError.

    optional: fields of any type that are in the view where the cloud has them.
    """
    fields = {field.name: field for field in cloud.fields}
    for axis in "xyz":
        field = fields.get(axis)
        if field is None or field.datatype != PointField.FLOAT32:
            raise UnusableMessageError(Outcome.BAD_FIELDS, f"no float32 field {axis}")
    names = [*"xyz", *(name for name in optional if name in fields)]
    kinds = [NUMBERS.get(fields[name].datatype, "") for name in names]
    for name, kind in zip(names, kinds):
        if not kind or fields[name].offset + int(kind[1]) > cloud.point_step:
            raise UnusableMessageError(Outcome.BAD_FIELDS, f"field {name} outside the point")
    shape = (cloud.height, cloud.width)
    if 0 in shape:
        raise UnusableMessageError(Outcome.EMPTY, "no points")
    too_short = cloud.row_step < cloud.width * cloud.point_step
    if too_short or len(cloud.data) < cloud.height * cloud.row_step:
        raise UnusableMessageError(Outcome.BAD_FIELDS, f"{len(cloud.data)} bytes for {shape}")
    layout = np.dtype(
        {
            "names": names,
            "formats": [(">" if cloud.is_bigendian else "<") + kind for kind in kinds],
            "offsets": [fields[name].offset for name in names],
            "itemsize": cloud.point_step,
        }
    )
    strides = (cloud.row_step, cloud.point_step)
    return np.ndarray(shape, layout, buffer=cloud.data, strides=strides)


def _stacked(grid: np.ndarray) -> np.ndarray:
    """(N, 3) float32 of a grid's x, y, z."""
    return np.stack([grid[axis].ravel() for axis in "xyz"], axis=1).astype(np.float32)


def refuse_nan(points: np.ndarray) -> np.ndarray:
    """The points (N, 3), unless there is none without a NaN: then UnusableMessageError."""
    if not len(points):
        raise UnusableMessageError(Outcome.EMPTY, "no points")
    if np.isnan(points).any(axis=1).all():
        raise UnusableMessageError(Outcome.NOT_FINITE, "every point has a NaN")
    return points
