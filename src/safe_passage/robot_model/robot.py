"""URDF -> links with their surfaces, joints, and where a set of joint angles puts them."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Mapping

import numpy as np
from scipy.spatial.transform import Rotation
from urdf_parser_py import xml_reflection
from urdf_parser_py.urdf import URDF

from safe_passage.core.errors import InputError
from safe_passage.robot_model import surfaces
from safe_passage.robot_model.resources import Packages, resolve
from safe_passage.robot_model.surfaces import Surface

MOVABLE = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: its position is multiplier * other + offset."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Joint:
    """Between two links."""

    name: str
    kind: str  # as in the URDF
    parent: str
    child: str
    T_parent_joint: np.ndarray  # (4, 4) at position 0
    axis: np.ndarray  # (3,) unit, in the joint's frame
    limits: tuple[float, float]  # [rad] or [m]; infinite without
    mimic: Mimic | None = None

    def motion(self, position: float) -> np.ndarray:
        """T_joint_child (4, 4) at `position` [rad] or [m]."""
        T = np.eye(4)
        if self.kind == "prismatic":
            T[:3, 3] = position * self.axis
        else:
            x, y, z = self.axis
            s, c = np.sin(position), np.cos(position)
            cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
            T[:3, :3] += s * cross + (1.0 - c) * cross @ cross  # Rodrigues
        return T


@dataclass(frozen=True)
class RobotModel:
    """Links in a tree. All poses are in the frame of `root`."""

    name: str
    root: str
    joints: tuple[Joint, ...]  # parents before their children
    links: Mapping[str, Surface] = field(repr=False)  # in the link's frame; empty: no geometry

    @property
    def movable(self) -> tuple[str, ...]:
        """Names of the joints whose positions must be given."""
        return tuple(j.name for j in self.joints if j.kind in MOVABLE and j.mimic is None)

    def poses(self, positions: Mapping[str, float]) -> dict[str, np.ndarray]:
        """T_root_link (4, 4) of every link.

        Args:
            positions: of every movable joint [rad] or [m]; others are ignored.

        Raises:
            InputError: names the joint whose position is missing or not finite.
        """
        T_root = {self.root: np.eye(4)}
        for joint in self.joints:
            T = T_root[joint.parent] @ joint.T_parent_joint
            if joint.kind in MOVABLE:
                T = T @ joint.motion(_position(joint, positions))
            T_root[joint.child] = T
        return T_root

    def outside_limits(self, positions: Mapping[str, float]) -> tuple[str, ...]:
        """Names of the joints beyond their limits."""
        return tuple(
            j.name
            for j in self.joints
            if j.kind in MOVABLE
            and not j.limits[0] - 1e-6 <= _position(j, positions) <= j.limits[1] + 1e-6
        )


def load_robot_model(
    urdf: str | Path, packages: Packages | Mapping[str, Path], visual: bool = True
) -> RobotModel:
    """Read a URDF and the meshes it names.

    Args:
        urdf: its text (what `robot_description` holds), or its file.
        packages: folder of a ROS package by its name, for package:// URIs.
        visual: take the visual geometry, not the collision's; a link that lacks the one wanted
            is taken by the other.

    Raises:
        InputError: names the link, joint or file that cannot be used.
    """
    base = urdf.parent if isinstance(urdf, Path) else None
    robot = _parse(urdf)
    links = {}
    for link in robot.links:
        wanted, other = link.visuals, link.collisions
        elements = (wanted or other) if visual else (other or wanted)
        try:
            links[link.name] = surfaces.joined([_surface(e, base, packages) for e in elements])
        except InputError as error:
            raise InputError(f"link {link.name}: {error}") from None
    joints = _in_order([_joint(one) for one in robot.joints], links)
    children = {one.child for one in joints}
    roots = [name for name in links if name not in children]
    return RobotModel(robot.name, roots[0], joints, links)


def _parse(urdf: str | Path) -> Any:
    where = str(urdf) if isinstance(urdf, Path) else "robot_description"
    errors: list[str] = []
    xml_reflection.core.on_error = errors.append  # else it prints them to standard error
    try:
        text = urdf.read_text() if isinstance(urdf, Path) else urdf
        robot = URDF.from_xml_string(text.encode())  # bytes: it may have an encoding declared
    except Exception as error:  # the parser passes on lxml's, and asserts
        raise InputError(f"{where}: not a URDF ({error or type(error).__name__})") from None
    if not robot.links:
        raise InputError(f"{where}: there is no link in it")
    return robot


def _surface(element: Any, base: Path | None, packages: Packages | Mapping[str, Path]) -> Surface:
    shape = element.geometry
    if hasattr(shape, "filename"):
        made = surfaces.load_mesh(resolve(shape.filename, base, packages), shape.scale)
    elif hasattr(shape, "length"):
        made = surfaces.cylinder(shape.radius, shape.length)
    elif hasattr(shape, "radius"):
        made = surfaces.sphere(shape.radius)
    elif hasattr(shape, "size"):
        made = surfaces.box(shape.size)
    else:
        raise InputError("its geometry is not a mesh, box, cylinder or sphere")
    return made.moved(_pose(element.origin))


def _joint(joint: Any) -> Joint:
    if joint.type not in (*MOVABLE, "fixed"):
        raise InputError(f"joint {joint.name}: its type {joint.type!r} is not supported")
    axis = np.array(joint.axis or (1.0, 0.0, 0.0), float)
    if np.linalg.norm(axis) < 1e-9:
        raise InputError(f"joint {joint.name}: its axis is nought")
    bounded = joint.limit is not None and joint.type in ("revolute", "prismatic")
    limits = (joint.limit.lower or 0.0, joint.limit.upper or 0.0) if bounded else (-np.inf, np.inf)
    mimic = None
    if joint.mimic is not None:
        factor = joint.mimic.multiplier
        mimic = Mimic(
            joint.mimic.joint, 1.0 if factor is None else float(factor), joint.mimic.offset or 0.0
        )
    return Joint(
        joint.name,
        joint.type,
        joint.parent,
        joint.child,
        _pose(joint.origin),
        axis / np.linalg.norm(axis),
        limits,
        mimic,
    )


def _pose(origin: Any) -> np.ndarray:
    T = np.eye(4)
    if origin is not None:
        T[:3, :3] = Rotation.from_euler("xyz", origin.rpy or (0.0, 0.0, 0.0)).as_matrix()
        T[:3, 3] = origin.xyz or (0.0, 0.0, 0.0)
    return T


def _in_order(joints: list[Joint], links: Mapping[str, Surface]) -> tuple[Joint, ...]:
    """Parents first.

    Raises:
        InputError: a link is not known, has two parents, or hangs on none.
    """
    for joint in joints:
        for link in (joint.parent, joint.child):
            if link not in links:
                raise InputError(f"joint {joint.name}: there is no link {link}")
    children = [joint.child for joint in joints]
    for child in children:
        if children.count(child) > 1:
            raise InputError(f"link {child}: has two parents")
    known = {name for name in links if name not in children}
    if len(known) != 1:
        raise InputError(f"there must be one root link, there are {sorted(known) or 'none'}")
    ordered: list[Joint] = []
    while len(ordered) < len(joints):
        ready = [j for j in joints if j.parent in known and j.child not in known]
        if not ready:
            raise InputError("the joints form a loop")
        ordered += ready
        known |= {joint.child for joint in ready}
    return tuple(ordered)


def _position(joint: Joint, positions: Mapping[str, float]) -> float:
    mimic = joint.mimic
    name = joint.name if mimic is None else mimic.joint
    if name not in positions:
        raise InputError(f"joint {name}: its position is missing")
    position = float(positions[name])
    if not np.isfinite(position):
        raise InputError(f"joint {name}: its position is {position}")
    return position if mimic is None else mimic.multiplier * position + mimic.offset
