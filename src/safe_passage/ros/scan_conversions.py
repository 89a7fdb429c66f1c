"""Rotating scanners' clouds to scans and back; robot configurations of messages."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

from safe_passage.core.errors import InputError, ParameterError
from safe_passage.msg import RobotConfiguration as RobotMessage
from safe_passage.ros.diagnostics import Outcome
from safe_passage.ros.sensor_conversions import UnusableMessageError, cloud_grid
from safe_passage.scan_segmentation.assembling import Assembled
from safe_passage.scan_segmentation.organise import organise
from safe_passage.scan_segmentation.parameters import RobotConfiguration
from safe_passage.scan_segmentation.reading import Cloud, without_returns_at_zero
from safe_passage.scan_segmentation.scan import OrganisedScan, Vector

FIELDS = ("x", "y", "z", "intensity", "beta")
REMISSION = ("intensity", "remission", "reflectance", "reflectivity")  # as drivers call it
VALUES = ("length", "width", "height", "max_slope", "max_obstacle", "margin")


@dataclass(frozen=True)
class ScanCloud:
    """What a cloud holds."""

    cloud: Cloud
    beta: np.ndarray | None  # (H,) [rad] of each line about z; None: the cloud does not say


def to_scan_cloud(header: Header, found: Assembled) -> PointCloud2:
    """x, y, z [m], intensity, beta [rad]; a row is a line, NaN = no return."""
    scan = found.scan
    height, width = scan.points.shape[:2]
    values = np.empty((height, width, len(FIELDS)), "<f4")
    values[..., :3] = scan.points
    values[..., 3] = 0.0 if scan.remission is None else scan.remission
    values[..., 4] = found.beta
    fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate(FIELDS)]
    step = 4 * len(FIELDS)
    data = values.tobytes()
    return PointCloud2(header, height, width, fields, False, step, step * width, data, False)


def from_scan_cloud(message: PointCloud2) -> ScanCloud:
    """Points, remission and angles; raises UnusableMessageError."""
    if not message.header.frame_id:
        raise UnusableMessageError(Outcome.BAD_FIELDS, "no frame_id")
    grid = cloud_grid(message, (*REMISSION, "beta"))
    points = np.stack([grid[axis] for axis in "xyz"], axis=-1).astype(np.float32)
    points = without_returns_at_zero(points)
    if not np.isfinite(points).all(axis=-1).any():
        raise UnusableMessageError(Outcome.NOT_FINITE, "no point is finite")
    names = grid.dtype.names or ()
    said = next((name for name in REMISSION if name in names), None)
    remission = None if said is None else grid[said].astype(np.float32)
    beta = None
    if "beta" in names and grid.shape[0] > 1:
        beta = grid["beta"].astype(np.float64).mean(axis=1)
        if not np.isfinite(beta).all():
            raise UnusableMessageError(Outcome.BAD_FIELDS, "beta is not finite")
    return ScanCloud(Cloud(points, remission, (0.0, 0.0, 0.0)), beta)


def to_organised(content: ScanCloud, up: Vector, axis: Vector | None) -> OrganisedScan:
    """The scan; raises InputError where no lines can be made of it.

    Args:
        axis: of the rotation, of clouds without beta; None: not known.
    """
    if content.beta is None:
        return organise(content.cloud, up, axis)
    cloud = content.cloud
    return OrganisedScan(cloud.points, content.beta, cloud.remission, up=up)


def unit(values: np.ndarray | tuple[float, ...]) -> Vector:
    """The direction of three values; raises InputError where they have none."""
    length = float(np.linalg.norm(values))
    if len(values) != 3 or not np.isfinite(length) or length < 1e-9:
        raise InputError(f"{tuple(values)} is no direction")
    x, y, z = (float(value) / length for value in values)
    return x, y, z


def from_robot(message: RobotMessage) -> RobotConfiguration | None:
    """The configuration, None where no value is given; raises ParameterError."""
    values = {name: getattr(message, name) for name in VALUES}
    if not any(values.values()):
        return None
    try:
        return RobotConfiguration(**values)
    except ParameterError as error:
        raise ParameterError(f"values/{error}") from None


def to_robot(robot: RobotConfiguration) -> RobotMessage:
    """The same the other way."""
    return RobotMessage(**{name: getattr(robot, name) for name in VALUES})
