"""Depth pictures of posed surfaces, drawn off-screen by OpenGL (EGL; software where no GPU is)."""

from __future__ import annotations

from typing import Any, Sequence

import moderngl
import numpy as np

from safe_passage.core.errors import InputError
from safe_passage.robot_model.camera import PinholeCamera
from safe_passage.robot_model.surfaces import Surface

NEAR = 0.02  # [m] what is nearer to the camera is not drawn
FAR = 200.0  # [m]
EGL: dict[str, Any] = {"backend": "egl"}  # needs no display
MOST_POSES = 16  # drawn at once

VERTEX = """
#version 330
uniform mat4 projection;
uniform mat4 T_camera_surface[%d];
in vec3 position;
out float z;
void main() {
    vec4 p = T_camera_surface[gl_InstanceID] * vec4(position, 1.0);
    z = p.z;
    gl_Position = projection * p;
}
"""
# Nearest and farthest surface of each pixel out of one drawing: the least of z and of -z.
FRAGMENT = """
#version 330
in float z;
out vec2 depths;
void main() { depths = vec2(z, -z); }
"""


class DepthRenderer:
    """Draws the same surfaces again and again.

    It may be used from one thread at a time, whichever.

    Args:
        surfaces: what is drawn, each in its own frame.
        camera: by which it is seen.

    Raises:
        InputError: there is no off-screen OpenGL here.
    """

    def __init__(self, surfaces: Sequence[Surface], camera: PinholeCamera) -> None:
        self.camera = camera
        try:
            self._gl = moderngl.create_context(standalone=True, require=330, **EGL)
        except Exception as error:  # glcontext raises bare Exception
            raise InputError(f"no off-screen OpenGL 3.3 through EGL: {error}") from None
        with self._gl as gl:
            self._program = gl.program(vertex_shader=VERTEX % MOST_POSES, fragment_shader=FRAGMENT)
            self._program["projection"].write(_projection(camera).T.astype("f4").tobytes())
            size = (camera.width, camera.height)
            self._texture = gl.texture(size, 2, dtype="f4")
            self._frame = gl.framebuffer([self._texture])
            self._arrays = [self._upload(one) for one in surfaces]
        self._buffer = np.empty((camera.height, camera.width, 2), np.float32)

    def depths(self, T_camera_surfaces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Nearest and farthest surface, whatever hides it, in each pixel.

        Args:
            T_camera_surfaces: (P, S, 4, 4), P poses of the S surfaces, all drawn into one picture.

        Returns:
            (height, width) float32 [m] each, +inf and -inf where there is nothing.
        """
        poses = np.asarray(T_camera_surfaces, np.float32)
        if poses.ndim != 4 or poses.shape[1:] != (len(self._arrays), 4, 4):
            raise ValueError(f"poses {poses.shape}: must be (P, {len(self._arrays)}, 4, 4)")
        with self._gl as gl:
            self._frame.use()
            self._frame.clear(np.inf, np.inf)
            gl.enable_only(moderngl.BLEND)
            gl.blend_equation = moderngl.MIN
            for first in range(0, len(poses), MOST_POSES):
                self._draw(poses[first : first + MOST_POSES])
            self._frame.read_into(self._buffer, components=2, dtype="f4")
        return self._buffer[..., 0].copy(), -self._buffer[..., 1]

    def close(self) -> None:
        """Give the graphics memory back."""
        self._gl.release()

    def _upload(self, surface: Surface) -> moderngl.VertexArray | None:
        if not len(surface.faces):
            return None
        corners = self._gl.buffer(surface.vertices.astype("f4").tobytes())
        faces = self._gl.buffer(surface.faces.astype("i4").tobytes())
        return self._gl.vertex_array(self._program, [(corners, "3f", "position")], faces)

    def _draw(self, poses: np.ndarray) -> None:
        padded = np.zeros((MOST_POSES, 4, 4), np.float32)
        for i, array in enumerate(self._arrays):
            if array is not None:
                padded[: len(poses)] = poses[:, i].transpose(0, 2, 1)  # column-major
                self._program["T_camera_surface"].write(padded.tobytes())
                array.render(instances=len(poses))  # of triangles


def _projection(camera: PinholeCamera) -> np.ndarray:
    """(4, 4) from the optical frame to clip space; row 0 of what is read is the picture's first."""
    w, h = camera.width, camera.height
    return np.array(
        [
            [2.0 * camera.fx / w, 0.0, (2.0 * camera.cx + 1.0) / w - 1.0, 0.0],
            [0.0, 2.0 * camera.fy / h, (2.0 * camera.cy + 1.0) / h - 1.0, 0.0],
            [0.0, 0.0, (FAR + NEAR) / (FAR - NEAR), -2.0 * FAR * NEAR / (FAR - NEAR)],
            [0.0, 0.0, 1.0, 0.0],
        ]
    )
