"""A world, a robot and people as a MuJoCo model: what can be drawn and what rays can hit.

Nothing here has dynamics: robot and people are put where they are, MuJoCo draws and casts rays.
Frame: map.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Sequence

import numpy as np

os.environ.setdefault("MUJOCO_GL", "egl")  # without a display; before MuJoCo is imported
import mujoco  # noqa: E402

from safe_passage.core.geometry import Pose  # noqa: E402
from safe_passage.simulation import materials  # noqa: E402
from safe_passage.simulation.people_assets import BodyMesh  # noqa: E402
from safe_passage.simulation.robots import CameraModel, LidarModel, Robot  # noqa: E402
from safe_passage.simulation.walkers import PersonState  # noqa: E402
from safe_passage.simulation.worlds import Block, World  # noqa: E402

# Groups of geoms: a ray is tested only against those it can meet.
LOW, HIGH, PEOPLE, ROBOT, HIDDEN = 0, 1, 2, 3, 5
LOW_TOP = 0.6  # [m] lidars lie below it
Z_NEAR, Z_FAR = 0.05, 60.0  # [m] that can be drawn
FLOOR, TILE = "concrete", 3.0  # material, [m] between its joints


@dataclass(frozen=True)
class Hits:
    """What rays met first."""

    distances: np.ndarray  # (N,) [m], inf: nothing
    persons: np.ndarray  # (N,) int, index of the person met, -1: none


class Scene:
    """The MuJoCo model and its drawing context.

    Args:
        world: what stands still.
        robot: its body and cameras.
        bodies: of the people, in the order of `place_people`.

    Raises:
        ImportError, RuntimeError: MuJoCo or EGL is missing.
    """

    def __init__(self, world: World, robot: Robot, bodies: Sequence[BodyMesh]) -> None:
        self.world, self.robot, self.bodies = world, robot, tuple(bodies)
        self.model = _build(world, robot, self.bodies)
        self.data = mujoco.MjData(self.model)
        self._robot = self.model.body("robot").id
        self._poses = [
            [self.model.geom(f"person{i}_pose{k}").id for k in range(len(body.vertices))]
            for i, body in enumerate(self.bodies)
        ]
        self._person_of_geom = np.full(self.model.ngeom + 1, -1)  # the last: no geom
        for i, geoms in enumerate(self._poses):
            self._person_of_geom[geoms] = i
        self._painters: dict[str, _Painter] = {}

    def place_robot(self, pose: Pose) -> None:
        """Put the robot's base_footprint at `pose`."""
        mocap = self.model.body_mocapid[self._robot]
        self.data.mocap_pos[mocap] = (pose[0], pose[1], 0.0)
        self.data.mocap_quat[mocap] = _quaternion(pose[2])

    def place_people(self, states: Sequence[PersonState | None]) -> None:
        """Put everyone where it is, in its pose; None: it is not there."""
        for i, (state, body) in enumerate(zip(states, self.bodies)):
            self.model.geom_group[self._poses[i]] = HIDDEN
            if state is None:
                continue
            mocap = self.model.body_mocapid[self.model.body(f"person{i}").id]
            self.data.mocap_pos[mocap] = (state.x, state.y, 0.0)
            self.data.mocap_quat[mocap] = _quaternion(state.yaw)
            shown = body.pose_of(state.stands, state.walked)
            self.model.geom_group[self._poses[i][shown]] = PEOPLE

    def settle(self) -> None:
        """Make what was placed known to rays and drawings."""
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)

    def cast(self, origin: np.ndarray, directions: np.ndarray, reach: float, low: bool) -> Hits:
        """First hits of rays from `origin` (3,) along unit `directions` (N, 3), up to `reach` [m].

        `low`: the rays stay below LOW_TOP: only what reaches down there is tried.
        """
        groups = np.zeros(6, np.uint8)
        groups[[LOW, PEOPLE] if low else [LOW, HIGH, PEOPLE]] = 1
        count = len(directions)
        geoms, distances = np.zeros(count, np.int32), np.zeros(count)
        mujoco.mj_multiRay(
            self.model,
            self.data,
            np.asarray(origin, float),
            np.ascontiguousarray(directions, float).ravel(),
            groups,
            1,
            self._robot,
            geoms,
            distances,
            None,
            count,
            reach,
        )
        met = geoms >= 0
        return Hits(np.where(met, distances, np.inf), self._person_of_geom[geoms])

    def scan(self, lidar: LidarModel, T_map_base: np.ndarray) -> Hits:
        """What the lidar's beams meet, without noise."""
        T = T_map_base @ lidar.pose_in_base()
        angles = lidar.angles()
        rays = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
        return self.cast(T[:3, 3], rays @ T[:3, :3].T, lidar.range_max, lidar.z < LOW_TOP)

    def render(self, camera: CameraModel) -> tuple[np.ndarray, np.ndarray]:
        """What a camera of the robot sees, without noise.

        Returns:
            bgr (H, W, 3) uint8; depth (H, W) float32 [m] along the optical axis.
        """
        if camera.name not in self._painters:
            self._painters[camera.name] = _Painter(self.model, camera.width, camera.height)
        return self._painters[camera.name].paint(self.data, self.model.camera(camera.name).id)

    def close(self) -> None:
        """Free the drawing contexts."""
        for painter in self._painters.values():
            painter.close()
        self._painters.clear()


class _Painter:
    """An off-screen picture: colour and depth out of one drawing."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        from mujoco.gl_context import GLContext

        self._model = model
        self._gl = GLContext(width, height)
        self._gl.make_current()
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._context)
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        self._view = mujoco.MjrRect(0, 0, width, height)
        self._scene = mujoco.MjvScene(model, maxgeom=model.ngeom + 100)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = False
        self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = False
        self._scene.flags[mujoco.mjtRndFlag.mjRND_HAZE] = False
        self._options = mujoco.MjvOption()
        self._options.geomgroup[:] = 1
        self._options.geomgroup[[ROBOT, HIDDEN]] = 0
        self._camera = mujoco.MjvCamera()
        self._camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self._rgb = np.empty((height, width, 3), np.uint8)
        self._zbuffer = np.empty((height, width), np.float32)

    def paint(self, data: mujoco.MjData, camera: int) -> tuple[np.ndarray, np.ndarray]:
        self._gl.make_current()
        self._camera.fixedcamid = camera
        mujoco.mjv_updateScene(
            self._model,
            data,
            self._options,
            None,
            self._camera,
            mujoco.mjtCatBit.mjCAT_ALL.value,
            self._scene,
        )
        mujoco.mjr_render(self._view, self._scene, self._context)
        mujoco.mjr_readPixels(self._rgb, self._zbuffer, self._view, self._context)
        # z-buffer of a reversed projection: 1 at Z_NEAR, 0 at Z_FAR
        inverse = self._zbuffer * (1.0 / Z_NEAR - 1.0 / Z_FAR) + 1.0 / Z_FAR
        return self._rgb[::-1, :, ::-1].copy(), (1.0 / inverse)[::-1].astype(np.float32)

    def close(self) -> None:
        self._gl.make_current()
        self._context.free()
        self._gl.free()


def _quaternion(yaw: float) -> tuple[float, float, float, float]:
    return float(np.cos(0.5 * yaw)), 0.0, 0.0, float(np.sin(0.5 * yaw))


def _build(world: World, robot: Robot, bodies: Sequence[BodyMesh]) -> mujoco.MjModel:
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
    _add_robot(spec, robot)
    for i, body in enumerate(bodies):
        _add_person(spec, i, body)
    return spec.compile()


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
    geom.quat = _quaternion(block.yaw)
    geom.material = block.material
    geom.rgba = [block.shade] * 3 + [1.0]
    geom.group = LOW if block.z < LOW_TOP else HIGH
    geom.contype = geom.conaffinity = 0


def _add_robot(spec: mujoco.MjSpec, robot: Robot) -> None:
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
