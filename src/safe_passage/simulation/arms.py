"""An arm on a robot: its URDF is found, read by MuJoCo and put on the robot's body."""

from __future__ import annotations

import importlib.util
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from safe_passage.core.errors import InputError, ParameterError
from safe_passage.simulation.robots import ArmModel

PREFIX = "arm/"  # of its names in the model
LIGHT_GREY = [0.78, 0.78, 0.77, 1.0]
WHEELS = {"pybullet_data": "pybullet==3.2.7"}  # python package -> what to install for it


def find_urdf(urdf: str) -> Path:
    """The file: an absolute path, or PACKAGE/PATH inside a Python package, which is not imported.

    Raises:
        InputError: names the parameter, and the package to install.
    """
    if Path(urdf).is_absolute():
        path = Path(urdf)
    else:
        package, *inside = Path(urdf).parts
        found = importlib.util.find_spec(package) if package.isidentifier() else None
        if found is None or not found.submodule_search_locations:
            wheel = WHEELS.get(package, package)
            raise InputError(
                f"arm/urdf is {urdf!r}, but there is no Python package {package!r}: "
                f"pip install --no-deps {wheel}, or leave the robot's arm out"
            )
        path = Path(found.submodule_search_locations[0]).joinpath(*inside)
    if not path.is_file():
        raise InputError(f"arm/urdf is {urdf!r}, but there is no file {path}")
    return path


@dataclass(frozen=True)
class Description:
    """An arm's URDF, for who does not know in which folder it was."""

    urdf: str  # its meshes by file://
    root: str  # link


def read_description(arm: ArmModel) -> Description:
    """The arm's; raises InputError as `find_urdf`, and where it is no tree of links."""
    path = find_urdf(arm.urdf)
    try:
        robot = ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise InputError(f"arm/urdf: {path}: {error}") from None
    for mesh in robot.iter("mesh"):
        name = mesh.get("filename", "")
        if "://" not in name:
            mesh.set("filename", f"file://{path.parent / name}")
    children = {child.get("link") for child in robot.iter("child")}
    roots = [link.get("name", "") for link in robot.findall("link")]
    roots = [name for name in roots if name not in children]
    if len(roots) != 1:
        raise InputError(f"arm/urdf: {path}: {len(roots)} root links, must be one")
    return Description(ElementTree.tostring(robot, encoding="unicode"), roots[0])


def attach(body: mujoco.MjsBody, arm: ArmModel, group: int) -> tuple[str, ...]:
    """Put the arm on `body`, its geoms in `group`.

    Returns:
        Names of its joints in the URDF, in the order of its positions.

    Raises:
        InputError: the URDF cannot be used. ParameterError: it has not the joints wanted.
    """
    path = find_urdf(arm.urdf)
    try:
        spec = mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise InputError(f"arm/urdf: {path}: {error}") from None
    if spec.worldbody.first_body() is None:
        raise InputError(f"arm/urdf: {path}: there is no link in it")
    spec.compiler.boundmass = spec.compiler.boundinertia = 1e-3  # no dynamics: any will do
    movable = tuple(joint.name for joint in spec.joints)
    joints = arm.joints or movable
    for name in joints:
        if name not in movable:
            raise ParameterError(f"arm/joints: {name} is not one of {', '.join(movable)}")
    if arm.positions and len(arm.positions) != len(joints):
        raise ParameterError(f"arm/positions: {len(arm.positions)} for {len(joints)} joints")
    for geom in spec.geoms:
        geom.group, geom.rgba = group, LIGHT_GREY
        geom.contype = geom.conaffinity = 0
    half = 0.5 * arm.yaw
    frame = body.add_frame(pos=[arm.x, arm.y, arm.z], quat=[np.cos(half), 0.0, 0.0, np.sin(half)])
    frame.attach_body(spec.worldbody.first_body(), PREFIX, "")
    return joints
