"""Replayed files: right frames, or an error that names the file."""

import cv2
import numpy as np
import pytest
from safe_passage.core.errors import InputError
from safe_passage.replay.sources import FileSource, Lidar, SceneSource
from safe_passage.simulation.analytic_scene import AnalyticScene


@pytest.fixture(scope="module")
def scene_images():
    return AnalyticScene(noise=0.0).render(1.6)


@pytest.fixture
def folder(tmp_path, scene_images):
    depth, bgr = scene_images
    for name in ("a", "b"):
        cv2.imwrite(str(tmp_path / f"{name}_rgb.png"), bgr)
        millimetres = np.nan_to_num(depth * 1000.0).astype(np.uint16)
        cv2.imwrite(str(tmp_path / f"{name}_depth.png"), millimetres)
    return tmp_path


def test_folder_is_played_in_order_and_round(folder):
    source = FileSource(folder, seconds_per_frame=1.0)
    assert [source.frame(t).name for t in (0.0, 1.5, 2.0)] == ["a_rgb", "b_rgb", "a_rgb"]


def test_ground_and_camera_height_are_found(folder):
    frame = FileSource(folder).frame(0.0)
    assert frame.p_base_camera[2] == pytest.approx(1.63, abs=0.02)
    assert frame.R_base_camera == pytest.approx(AnalyticScene().camera.rotation(), abs=0.02)


def test_half_view_is_to_the_narrower_side(folder):
    (folder / "intrinsics.yaml").write_text("{fx: 300.0, fy: 300, cx: 300, cy: 240}")
    assert FileSource(folder).frame(0.0).half_view() == pytest.approx(np.pi / 4)


def test_depth_of_8_bits_needs_its_scale(folder, scene_images):
    depth, _ = scene_images
    coded = np.nan_to_num(depth * 25.0 + 35.0).astype(np.uint8)
    cv2.imwrite(str(folder / "a_depth.png"), coded)
    with pytest.raises(InputError, match="a_depth_params.yaml: missing"):
        FileSource(folder).frame(0.0)
    (folder / "a_depth_params.yaml").write_text("%YAML:1.0\nalpha: 2.5e+01\nbeta: 35.\n")
    assert np.nanmedian(FileSource(folder).frame(0.0).xyz[..., 2]) == pytest.approx(
        np.nanmedian(depth), abs=0.1
    )


def test_intrinsics_are_read_and_checked(folder):
    (folder / "intrinsics.yaml").write_text("{fx: 500.0, fy: 500, cx: 320, cy: 240}")
    assert FileSource(folder).frame(0.0).intrinsics == (500.0, 500.0, 320.0, 240.0)
    (folder / "intrinsics.yaml").write_text("{fx: wide}")
    with pytest.raises(InputError, match="intrinsics.yaml: needs numbers"):
        FileSource(folder)


def test_what_cannot_be_played_is_named(tmp_path):
    with pytest.raises(InputError, match="nowhere.pcd"):
        FileSource(tmp_path / "nowhere.pcd")
    with pytest.raises(InputError, match="no \\*_rgb.png"):
        FileSource(tmp_path)
    (tmp_path / "broken.pcd").write_text("not a cloud")
    with pytest.raises(InputError, match="broken.pcd"):
        FileSource(tmp_path / "broken.pcd").frame(0.0)


def test_no_ground_is_said(folder, scene_images):
    depth, _ = scene_images
    cv2.imwrite(str(folder / "a_depth.png"), np.zeros(depth.shape, np.uint16))
    with pytest.raises(InputError, match="no ground plane"):
        FileSource(folder).frame(0.0)


def test_a_broken_file_of_a_folder_does_not_spoil_the_next(folder):
    (folder / "a_depth.png").write_bytes(b"not an image")
    source = FileSource(folder, seconds_per_frame=1.0)
    with pytest.raises(InputError, match="a_depth.png: not a picture"):
        source.frame(0.0)
    assert source.frame(1.0).name == "b_rgb"
    for _ in range(2):  # nor is the frame before it shown in its place
        with pytest.raises(InputError):
            source.frame(2.0)


def test_scene_and_its_cloud_agree_on_the_scan():
    source = SceneSource(AnalyticScene(noise=0.0))
    frame = source.frame(0.0)
    angles = np.linspace(-0.2, 0.2, 41)
    lidar = Lidar(angles, x=0.2, z=0.12, max_range=20.0)
    real = source.scan(lidar, frame, 0.0)
    from_cloud = FileSource.scan(source, lidar, frame, 0.0)
    both = np.isfinite(real) & np.isfinite(from_cloud) & (real < 7.0)
    assert both.sum() > 3
    assert np.median(np.abs(real - from_cloud)[both]) < 0.1
