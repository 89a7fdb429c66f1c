"""Off-screen pictures of a MuJoCo model."""

from __future__ import annotations

import mujoco
import numpy as np

from safe_passage.simulation.scene_model import HIDDEN, ROBOT, Z_FAR, Z_NEAR


class Painter:
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
