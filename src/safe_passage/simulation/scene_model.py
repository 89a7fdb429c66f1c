"""World, robot and people as a MuJoCo model. Nothing in it has dynamics. Frame: map."""

from __future__ import annotations

from typing import Sequence

import mujoco
import numpy as np

from safe_passage.simulation import arms, materials
from safe_passage.simulation.blocks import Block
from safe_passage.simulation.people_assets import BodyMesh
from safe_passage.simulation.robots import Robot
from safe_passage.simulation.worlds import World

# Groups of geoms: a ray is tested only against those it can meet, a camera draws the first five.
LOW, HIGH, PEOPLE, ROBOT, ARM, HIDDEN = 0, 1, 2, 3, 4, 5
LOW_TOP = 0.6  # [m] lidars lie below it
Z_NEAR, Z_FAR = 0.05, 60.0  # [m] that can be drawn
FLOOR, TILE = "concrete", 3.0  # material, [m] between its joints


def quaternion(yaw: float) -> tuple[float, float, float, float]:
    return float(np.cos(0.5 * yaw)), 0.0, 0.0, float(np.sin(0.5 * yaw))


def build_model(
    world: World, robot: Robot, bodies: Sequence[BodyMesh]
) -> tuple[mujoco.MjModel, tuple[str, ...]]:
    """The model, and the names of the arm's joints."""
    spec = mujoco.MjSpec()
    spec.modelname = world.name
    visual = spec.visual
    visual.map.znear, visual.map.zfar = Z_NEAR, Z_FAR
    spec.stat.extent = 1.0  # so that znear and zfar are metres
    visual.global_.offwidth = max([camera.width for camera in robot.cameras], default=640)
    visual.global_.offheight = max([camera.height for camera in robot.cameras], default=480)
    visual.quality.offsamples = 0
    visual.headlight.ambient = [0.42, 0.42, 0.42]
    visual.headlight.diffuse = [0.18, 0.18, 0.18]
    visual.headlight.specular = [0.0, 0.0, 0.0]
    for material in materials.PAINTERS:
        _add_material(spec, material)
    _add_lights(spec, world)
    sky = spec.add_texture(name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX)
    sky.builtin, sky.width, sky.height = mujoco.mjtBuiltin.mjBUILTIN_FLAT, 8, 48
    sky.rgb1 = sky.rgb2 = [0.62, 0.64, 0.66]
    floor = spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE)
    floor.size = [0.5 * world.size[0], 0.5 * world.size[1], 1.0]
    floor.material, floor.group = FLOOR, HIGH
    for block in world.blocks:
        _add_block(spec, block)
    joints = _add_robot(spec, robot)
    for i, body in enumerate(bodies):
        _add_person(spec, i, body)
    return spec.compile(), joints


def _add_material(spec: mujoco.MjSpec, name: str) -> None:
    flat = name == FLOOR  # tiled; the others cover each face of a block
    picture = np.tile(materials.paint(name), (1 if flat else 6, 1, 1))
    kind = mujoco.mjtTexture.mjTEXTURE_2D if flat else mujoco.mjtTexture.mjTEXTURE_CUBE
    texture = spec.add_texture(name=name, type=kind, nchannel=3)
    texture.height, texture.width = picture.shape[:2]
    texture.data = picture.tobytes()
    material = spec.add_material(name=name, specular=0.1, shininess=0.1)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
    if flat:
        material.texuniform, material.texrepeat = True, [1.0 / TILE, 1.0 / TILE]


def _add_lights(spec: mujoco.MjSpec, world: World) -> None:
    for place in world.lights:
        light = spec.worldbody.add_light(pos=list(place), dir=[0.0, 0.0, -1.0])
        light.type = mujoco.mjtLightType.mjLIGHT_SPOT
        light.castshadow = False
        light.cutoff, light.exponent = 85.0, 1.0
        light.diffuse, light.specular = [0.5, 0.5, 0.48], [0.05, 0.05, 0.05]
    sky = spec.worldbody.add_light(pos=[0, 0, 6], dir=[0.35, -0.25, -1.0])
    sky.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    sky.castshadow = False
    sky.diffuse, sky.specular = [0.35, 0.35, 0.37], [0.0, 0.0, 0.0]


def _add_block(spec: mujoco.MjSpec, block: Block) -> None:
    geom = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX)
    geom.size = [0.5 * side for side in block.size]
    geom.pos = [block.x, block.y, block.z + 0.5 * block.size[2]]
    geom.quat = quaternion(block.yaw)
    geom.material = block.material
    geom.rgba = [block.shade] * 3 + [1.0]
    geom.group = LOW if block.z < LOW_TOP else HIGH
    geom.contype = geom.conaffinity = 0


def _add_robot(spec: mujoco.MjSpec, robot: Robot) -> tuple[str, ...]:
    body = spec.worldbody.add_body(name="robot", mocap=True)
    for part in robot.parts:
        geom = body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, group=ROBOT)
        geom.size = [0.5 * side for side in part.size]
        geom.pos = [part.x, part.y, part.z + 0.5 * part.size[2]]
        geom.rgba = [*part.colour, 1.0]
        geom.contype = geom.conaffinity = 0
    for model in robot.cameras:
        T = model.pose_in_base()
        camera = body.add_camera(name=model.name, pos=T[:3, 3])
        gl = T[:3, :3] @ np.diag([1.0, -1.0, -1.0])  # OpenGL's camera looks along -z, y up
        camera.quat = _matrix_quaternion(gl)
        camera.fovy = float(np.degrees(2.0 * np.arctan2(0.5 * model.height, model.focal)))
    return arms.attach(body, robot.arm, ARM) if robot.arm else ()


def _add_person(spec: mujoco.MjSpec, index: int, person: BodyMesh) -> None:
    body = spec.worldbody.add_body(name=f"person{index}", mocap=True)
    name = f"clothes{index}"
    texture = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, nchannel=3)
    texture.height, texture.width = person.texture.shape[:2]
    texture.data = person.texture.tobytes()
    material = spec.add_material(name=name, specular=0.0, shininess=0.0)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
    for k, vertices in enumerate(person.vertices):
        mesh = spec.add_mesh(name=f"person{index}_pose{k}")
        mesh.uservert = vertices.ravel()
        mesh.userface = person.faces.ravel()
        mesh.usertexcoord = person.texcoords.ravel()
        mesh.userfacetexcoord = person.face_texcoords.ravel()
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
        geom = body.add_geom(name=mesh.name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh.name)
        geom.material, geom.group = name, HIDDEN
        geom.contype = geom.conaffinity = 0


def _matrix_quaternion(matrix: np.ndarray) -> np.ndarray:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(matrix).ravel())
    return quaternion
