"""Meshes from files, padding, simplification."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from safe_passage.core.errors import InputError
from safe_passage.robot_model import surfaces
from safe_passage.robot_model.surfaces import Surface

CUBE = (1.0, 2.0, 3.0)
DAE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimeter" meter="0.01"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="9">0 0 0 100 0 0 0 0 300</float_array>
<technique_common><accessor source="#pa" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene>
</COLLADA>"""


@pytest.mark.parametrize("ending", ["stl", "obj"])
def test_meshes_are_read_scaled_and_merged(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"cube.{ending}"
    trimesh.creation.box(extents=CUBE).export(path)
    mesh = surfaces.load_mesh(path, np.array([1.0, 1.0, 0.1]))
    assert (len(mesh.vertices), len(mesh.faces)) == (8, 12)
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), [1.0, 2.0, 0.3])


def test_a_collada_files_unit_counts_and_its_up_axis_does_not(tmp_path: Path) -> None:
    path = tmp_path / "triangle.dae"
    path.write_text(DAE)
    mesh = surfaces.load_mesh(path)
    np.testing.assert_allclose(mesh.vertices.max(axis=0), [1.0, 0.0, 3.0])


def test_a_mirrored_mesh_still_has_its_outside_outside(tmp_path: Path) -> None:
    path = tmp_path / "cube.stl"
    trimesh.creation.box(extents=CUBE).export(path)
    mirrored = surfaces.load_mesh(path, np.array([-1.0, 1.0, 1.0]))
    assert np.ptp(mirrored.inflated(0.1).vertices, axis=0)[0] == pytest.approx(1.2)


@pytest.mark.parametrize("content", [b"", b"solid nothing\nendsolid\n"])
def test_a_file_without_triangles_is_named(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "empty.stl"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"empty\.stl"):
        surfaces.load_mesh(path)


def test_other_formats_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"\.ply"):
        surfaces.load_mesh(tmp_path / "a.ply")


@settings(max_examples=30, deadline=None)
@given(
    st.tuples(*[st.floats(0.05, 2.0)] * 3),
    st.floats(0.001, 0.05),
)
def test_a_padded_box_is_the_box_and_its_padding(
    size: tuple[float, float, float], padding: float
) -> None:
    grown = surfaces.box(np.array(size)).inflated(padding)
    np.testing.assert_allclose(
        np.ptp(grown.vertices, axis=0), np.array(size) + 2 * padding, atol=1e-9
    )


def test_round_bodies_are_padded_all_around() -> None:
    ball = surfaces.sphere(0.3).inflated(0.02)
    assert np.linalg.norm(ball.vertices, axis=1).min() >= 0.32
    tube = surfaces.cylinder(0.1, 1.0).inflated(0.02)
    mesh = trimesh.Trimesh(tube.vertices, tube.faces)
    angle = np.linspace(0, 2 * np.pi, 100)
    around = np.stack([0.1195 * np.cos(angle), 0.1195 * np.sin(angle), 0.5195 + 0 * angle], axis=1)
    assert trimesh.proximity.signed_distance(mesh, around).min() > 0.0


@settings(max_examples=20, deadline=None)
@given(st.floats(0.01, 0.2))
def test_a_simplified_surface_is_as_near_as_it_says(cell: float) -> None:
    ball = surfaces.sphere(0.3)
    coarse, moved = ball.simplified(cell)
    assert moved <= cell * np.sqrt(3.0)
    assert len(coarse.faces) <= len(ball.faces)
    radii = np.linalg.norm(coarse.vertices, axis=1)
    assert radii.min() >= 0.3 - moved - 1e-9
    assert radii.max() <= 0.3 * 1.005 + 1e-9


def test_nothing_stays_nothing() -> None:
    nothing = surfaces.joined([])
    assert len(nothing.inflated(0.1).simplified(0.1)[0].faces) == 0
    assert isinstance(nothing, Surface)
