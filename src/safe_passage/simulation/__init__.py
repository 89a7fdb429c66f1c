"""Worlds with exact truth: what cameras and lidars see in them."""

import os

os.environ.setdefault("MUJOCO_GL", "egl")  # no display needed; read when MuJoCo is imported
