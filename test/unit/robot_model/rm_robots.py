"""A small robot whose every pose is known by hand."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

TWO_ARMS = """<?xml version="1.0"?>
<robot name="two_arms">
  <link name="base"><visual><geometry><box size="0.4 0.2 0.1"/></geometry></visual></link>
  <link name="upper">
    <visual><origin xyz="0.5 0 0"/><geometry><box size="1 0.1 0.1"/></geometry></visual>
  </link>
  <link name="slide"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="finger">
    <visual><geometry><cylinder radius="0.05" length="0.3"/></geometry></visual>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 1"/><axis xyz="0 0 2"/>
    <limit lower="-1.5" upper="1.5" effort="1" velocity="1"/>
  </joint>
  <joint name="rail" type="prismatic">
    <parent link="upper"/><child link="slide"/><origin xyz="1 0 0"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.5" effort="1" velocity="1"/>
  </joint>
  <joint name="follower" type="continuous">
    <parent link="slide"/><child link="finger"/><axis xyz="0 1 0"/>
    <mimic joint="shoulder" multiplier="2" offset="0.1"/>
  </joint>
</robot>
"""


def iiwa() -> Path:
    """The KUKA LBR iiwa of the PyPI package pybullet, or skip."""
    found = importlib.util.find_spec("pybullet_data")
    if found is None or not found.submodule_search_locations:
        pytest.skip("no pybullet_data: pip install --no-deps pybullet")
    return Path(found.submodule_search_locations[0]) / "kuka_iiwa" / "model.urdf"
