"""Depth pictures against depths known by hand."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from safe_passage.core.errors import InputError, ParameterError
from safe_passage.robot_model import DepthRenderer, PinholeCamera
from safe_passage.robot_model.surfaces import box, joined, sphere

CAMERA = PinholeCamera(160, 120, 130.0, 125.0, 70.3, 64.8)


def at(x: float, y: float, z: float) -> np.ndarray:
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T


def test_a_plate_has_its_depth_and_its_outline() -> None:
    renderer = DepthRenderer([box(np.array([0.4, 0.2, 0.1]))], CAMERA)
    front, back = renderer.depths(at(0.1, -0.05, 2.0)[None, None])
    np.testing.assert_allclose(front[np.isfinite(front)], 1.95, rtol=1e-5)
    rows, columns = np.nonzero(np.isfinite(front))
    u = np.array([-0.1, 0.3]) / 1.95 * CAMERA.fx + CAMERA.cx
    v = np.array([-0.15, 0.05]) / 1.95 * CAMERA.fy + CAMERA.cy
    assert (columns.min(), columns.max()) == (np.ceil(u[0]), np.floor(u[1]))
    assert (rows.min(), rows.max()) == (np.ceil(v[0]), np.floor(v[1]))
    assert back.max() == pytest.approx(2.05, rel=1e-5)
    assert np.isneginf(back[~np.isfinite(front)]).all()


def test_a_ball_is_round_in_depth() -> None:
    front, back = DepthRenderer([sphere(0.3)], CAMERA).depths(at(0.0, 0.0, 1.5)[None, None])
    points = CAMERA.points(front, np.isfinite(front))
    radii = np.linalg.norm(points - [0.0, 0.0, 1.5], axis=1)
    assert (radii.min(), radii.max()) == pytest.approx((0.3, 0.3), abs=3e-3)
    rows, columns, inside = CAMERA.pixels(points)
    assert inside.all()
    assert np.isfinite(front[rows, columns]).all()


def test_all_poses_are_drawn_into_one_picture() -> None:
    small = box(np.array([0.05, 0.05, 0.05]))
    renderer = DepthRenderer([small, joined([]), small], CAMERA)
    many = np.stack(
        [[at(0.0, 0.0, 1.0), np.eye(4), at(0.4, 0.0, 1.0 + 0.1 * i)] for i in range(20)]
    )
    front, back = renderer.depths(many)
    assert front[65, 70] == pytest.approx(0.975, rel=1e-4)
    assert front[65, 123] == pytest.approx(0.975, rel=1e-4)  # the nearest of the twenty
    assert back.max() == pytest.approx(2.925, rel=1e-4)  # and the farthest
    with pytest.raises(ValueError, match="poses"):
        renderer.depths(many[:, :2])


def test_what_is_behind_the_camera_is_not_seen_and_what_surrounds_it_is() -> None:
    renderer = DepthRenderer([box(np.array([1.0, 1.0, 1.0]))], CAMERA)
    assert not np.isfinite(renderer.depths(at(0.0, 0.0, -2.0)[None, None])[0]).any()
    front, back = renderer.depths(np.eye(4)[None, None])
    np.testing.assert_allclose(back[64, 70], 0.5, rtol=1e-4)


def test_it_may_be_used_from_another_thread() -> None:
    renderer = DepthRenderer([sphere(0.3)], CAMERA)
    seen: list[int] = []

    def look() -> None:
        front, _ = renderer.depths(at(0.0, 0.0, 1.5)[None, None])
        seen.append(int(np.isfinite(front).sum()))

    look()
    thread = threading.Thread(target=look)
    thread.start()
    thread.join()
    look()
    assert seen[0] > 1000
    assert len(set(seen)) == 1 and len(seen) == 3


def test_a_camera_is_checked() -> None:
    with pytest.raises(ParameterError, match="fx"):
        PinholeCamera(160, 120, 0.0, 125.0, 70.0, 60.0)
    with pytest.raises(InputError, match="3 x 3"):
        PinholeCamera.of_matrix(np.full((3, 3), np.nan), 160, 120)
