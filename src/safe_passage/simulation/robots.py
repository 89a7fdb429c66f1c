"""Robots from yaml: shape, drive, where each sensor sits.

Frame: base_footprint, x forward, y left, z up from the floor (REP 105).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Mapping, Sequence

import numpy as np

from safe_passage.core.errors import ParameterError, shown
from safe_passage.core.parameters import check_flag, check_range
from safe_passage.core.reading import build, build_list, read_yaml

TOPICS = {  # of a kind's first sensor; the others' are below NAME/
    "lidars": {"topic": "scan"},
    "cameras": {
        "image": "rgb/image_rect_color",
        "camera_info": "rgb/camera_info",
        "depth": "depth_registered/image_rect",
        "points": "depth_registered/points",
    },
}


@dataclass(frozen=True)
class LidarModel:
    """A level scanner. Defaults: Hokuyo UST-20LX."""

    name: str = "laser"
    frame: str = "laser"
    topic: str = ""  # LaserScan; empty: scan for the first lidar, NAME/scan for the others
    x: float = 0.0  # [m]
    y: float = 0.0  # [m]
    z: float = 0.12  # [m] over the floor
    yaw: float = 0.0  # [rad]
    beams: int = 1081
    field_of_view: float = 1.5 * math.pi  # [rad]
    range_min: float = 0.06  # [m]
    range_max: float = 20.0  # [m]
    rate: float = 40.0  # [Hz]
    noise: float = 0.01  # [m] standard deviation of a range
    dropout: float = 0.001  # share of beams that come back without a range

    def __post_init__(self) -> None:
        check_range("beams", self.beams, 2, 100000, "beams")
        check_range("field_of_view", self.field_of_view, 0.1, 2 * math.pi, "rad")
        check_range("range_min", self.range_min, 0.0, 10.0, "m")
        check_range("range_max", self.range_max, self.range_min, 1000.0, "m")
        check_range("rate", self.rate, 0.1, 1000.0, "Hz")
        check_range("noise", self.noise, 0.0, 1.0, "m")
        check_range("dropout", self.dropout, 0.0, 1.0, "")

    def angles(self) -> np.ndarray:
        """(beams,) [rad] in the lidar's frame, ascending."""
        return np.linspace(-0.5 * self.field_of_view, 0.5 * self.field_of_view, self.beams)

    def pose_in_base(self) -> np.ndarray:
        """(4, 4) of its frame."""
        return transform((self.x, self.y, self.z), (self.yaw, 0.0))


@dataclass(frozen=True)
class CameraModel:
    """A structured-light RGB-D camera, depth registered to colour. Defaults: Orbbec Astra."""

    name: str = "camera"
    frame: str = "camera_rgb_optical_frame"
    image: str = ""  # topics; empty: as TOPICS has them
    camera_info: str = ""
    depth: str = ""
    points: str = ""
    x: float = 0.0  # [m]
    y: float = 0.0  # [m]
    z: float = 1.63  # [m] over the floor
    yaw: float = 0.0  # [rad]
    pitch: float = 0.0  # [rad] downwards
    width: int = 640  # [px]
    height: int = 480  # [px]
    focal: float = 525.0  # [px]
    rate: float = 10.0  # [Hz]
    range_min: float = 0.6  # [m] of depth along the optical axis
    range_max: float = 8.5  # [m]
    baseline: float = 0.075  # [m] between projector and infrared camera
    disparity_noise: float = 0.06  # [px] standard deviation
    disparity_step: float = 0.125  # [px] quantisation
    colour_noise: float = 2.5  # [grey levels] standard deviation

    def __post_init__(self) -> None:
        check_range("width", self.width, 16, 4096, "px")
        check_range("height", self.height, 16, 4096, "px")
        check_range("focal", self.focal, 10.0, 10000.0, "px")
        check_range("rate", self.rate, 0.1, 200.0, "Hz")
        check_range("range_min", self.range_min, 0.01, 10.0, "m")
        check_range("range_max", self.range_max, self.range_min, 100.0, "m")
        check_range("baseline", self.baseline, 0.001, 1.0, "m")
        check_range("disparity_noise", self.disparity_noise, 0.0, 10.0, "px")
        check_range("disparity_step", self.disparity_step, 0.0, 10.0, "px")
        check_range("colour_noise", self.colour_noise, 0.0, 255.0, "grey levels")

    @property
    def intrinsics(self) -> tuple[float, float, float, float]:
        """fx, fy, cx, cy [px]; (0, 0) is the middle of the first pixel."""
        return self.focal, self.focal, 0.5 * (self.width - 1), 0.5 * (self.height - 1)

    def pose_in_base(self) -> np.ndarray:
        """(4, 4) of the optical frame: x right, y down, z forward (REP 103)."""
        body = transform((self.x, self.y, self.z), (self.yaw, self.pitch))
        optical = np.eye(4)
        optical[:3, :3] = [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]
        return body @ optical


@dataclass(frozen=True)
class ScannerModel:
    """A 2D scanner on a turning platform, not simulated. Defaults: RoSi (paper 003, III)."""

    name: str = "scanner"
    frame: str = "scanner"  # does not turn; z is the platform's axis
    topic: str = "scan"  # LaserScan, a line each
    x: float = 0.0  # [m] of its frame; tf tells where an arm carries it
    y: float = 0.0  # [m]
    z: float = 1.0  # [m] over the floor
    beams: int = 361  # of a line
    field_of_view: float = math.pi  # [rad] of a line
    range_min: float = 0.1  # [m]
    range_max: float = 80.0  # [m]
    rate: float = 37.5  # [Hz] of lines

    def __post_init__(self) -> None:
        check_range("beams", self.beams, 2, 100000, "beams")
        check_range("field_of_view", self.field_of_view, 0.1, 2 * math.pi, "rad")
        check_range("range_min", self.range_min, 0.0, 10.0, "m")
        check_range("range_max", self.range_max, self.range_min, 1000.0, "m")
        check_range("rate", self.rate, 0.1, 1000.0, "Hz")


@dataclass(frozen=True)
class PartModel:
    """A box of the robot's body."""

    x: float = 0.0  # [m] middle
    y: float = 0.0  # [m] middle
    z: float = 0.0  # [m] lower face
    size: tuple[float, float, float] = (0.1, 0.1, 0.1)  # [m]
    colour: tuple[float, float, float] = (0.2, 0.2, 0.2)  # RGB, 0 to 1

    def __post_init__(self) -> None:
        for side in self.size:
            check_range("size", side, 0.001, 10.0, "m")
        for share in self.colour:
            check_range("colour", share, 0.0, 1.0, "")


@dataclass(frozen=True)
class ArmModel:
    """An arm on the body; the robot's cameras see it, its lidars pass under it."""

    urdf: str  # file, or PACKAGE/PATH in a Python package, as pybullet_data/kuka_iiwa/model.urdf
    x: float = 0.0  # [m] of its root link
    y: float = 0.0  # [m]
    z: float = 0.0  # [m] over the floor
    yaw: float = 0.0  # [rad]
    joints: tuple[str, ...] = ()  # in the order of its positions; empty: as in the URDF
    positions: tuple[float, ...] = ()  # [rad] at the start; empty: zeros

    def pose_in_base(self) -> np.ndarray:
        """(4, 4) of its root link."""
        return transform((self.x, self.y, self.z), (self.yaw, 0.0))


@dataclass(frozen=True)
class DriveModel:
    """What the base can do."""

    omni: bool = False  # drives sideways too
    max_speed: float = 0.8  # [m/s] each way
    max_turn_rate: float = 0.8  # [rad/s]
    acceleration: float = 0.8  # [m/s^2]
    turn_acceleration: float = 1.6  # [rad/s^2]
    command_timeout: float = 0.5  # [s] without a command it brakes
    odometry_noise: float = 0.01  # standard deviation of the error, as share of the way of a second
    odometry_scale: float = 0.0  # share by which odometry always overrates the way

    def __post_init__(self) -> None:
        check_flag("omni", self.omni)
        check_range("max_speed", self.max_speed, 0.01, 10.0, "m/s")
        check_range("max_turn_rate", self.max_turn_rate, 0.01, 10.0, "rad/s")
        check_range("acceleration", self.acceleration, 0.01, 20.0, "m/s^2")
        check_range("turn_acceleration", self.turn_acceleration, 0.01, 50.0, "rad/s^2")
        check_range("command_timeout", self.command_timeout, 0.01, 10.0, "s")
        check_range("odometry_noise", self.odometry_noise, 0.0, 1.0, "")
        check_range("odometry_scale", self.odometry_scale, -0.5, 0.5, "")


@dataclass(frozen=True)
class Robot:
    """What a robot is: of this the simulator makes one, and tools know what should be there."""

    name: str
    footprint: tuple[tuple[float, float], ...]  # [m] outline, counter-clockwise
    height: float  # [m]
    drive: DriveModel
    parts: tuple[PartModel, ...]
    lidars: tuple[LidarModel, ...]
    cameras: tuple[CameraModel, ...]
    scanners: tuple[ScannerModel, ...] = ()
    arm: ArmModel | None = None

    def __post_init__(self) -> None:
        check_range("height", self.height, 0.1, 5.0, "m")
        if len(self.footprint) < 3:
            raise ParameterError("footprint: three or more points [x, y] in m")
        for kind in ("lidars", "cameras", "scanners"):
            names = [sensor.name for sensor in getattr(self, kind)]
            if len(set(names)) < len(names):
                raise ParameterError(f"{kind}: two of the same name among {', '.join(names)}")
        for kind, topics in TOPICS.items():
            named = tuple(_with_topics(i, s, topics) for i, s in enumerate(getattr(self, kind)))
            object.__setattr__(self, kind, named)

    def without_arm(self) -> Robot:
        """The same, for a machine on which the arm's model is not installed."""
        return replace(self, arm=None)


def transform(place: Sequence[float], yaw_pitch: tuple[float, float]) -> np.ndarray:
    """(4, 4) from a translation [m], then a yaw [rad] and a downward pitch [rad]."""
    (cy, sy), (cp, sp) = ((math.cos(a), math.sin(a)) for a in yaw_pitch)
    T = np.eye(4)
    T[:3, :3] = [[cy * cp, -sy, cy * sp], [sy * cp, cy, sy * sp], [-sp, 0.0, cp]]
    T[:3, 3] = place
    return T


def load_robot(path: Path) -> Robot:
    """Read a robot, without its nodes' parameters, which `robot_files` reads.

    Raises:
        InputError: the file cannot be read. ParameterError: names the key at fault.
    """
    values = read_yaml(path)
    if "robot" not in values:
        raise ParameterError(f"{path}: robot is missing: the key under which all is that it is")
    return make_robot(values["robot"], f"{path}: robot")


def make_robot(values: Mapping[str, Any], where: str = "robot") -> Robot:
    """Build a robot of the yaml's contents; ParameterError names what is wrong in it."""
    if not isinstance(values, Mapping):
        raise ParameterError(f"{where} is {shown(values)}, must be a mapping of keys to values")
    built = dict(values)
    built["drive"] = build(DriveModel, built.get("drive") or {}, f"{where}/drive")
    for key, model in SENSORS_AND_PARTS.items():
        built[key] = build_list(model, built.get(key), f"{where}/{key}")
    if built.get("arm") is not None:
        built["arm"] = build(ArmModel, built["arm"], f"{where}/arm")
    return build(Robot, built, where)


SENSORS_AND_PARTS: dict[str, type] = {
    "parts": PartModel,
    "lidars": LidarModel,
    "cameras": CameraModel,
    "scanners": ScannerModel,
}


def _with_topics(index: int, sensor: Any, topics: Mapping[str, str]) -> Any:
    """The sensor, topics that were not told as they usually are."""
    prefix = f"{sensor.name}/" if index else ""
    return replace(
        sensor,
        **{field: getattr(sensor, field) or prefix + topic for field, topic in topics.items()},
    )
