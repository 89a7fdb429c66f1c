"""The uncertainty of a calibration against errors that are drawn many times."""

from __future__ import annotations

import numpy as np
import pytest
from safe_passage.calibration.arm_surface import VisibleSurface
from safe_passage.calibration.uncertainty import Offsets, Uncertainty, offsets, uncertainty

PLACE = np.array([1.5, 0.0, 0.3])


def ball(rng: np.random.Generator, middle: np.ndarray, count: int = 400) -> VisibleSurface:
    """Points of a bumpy ball, of whose normals all directions are held."""
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    normals = directions + 0.4 * rng.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return VisibleSurface(middle + 0.3 * directions, normals)


def drawn(
    rng: np.random.Generator, poses: list[VisibleSurface], alike: float, own: float
) -> list[Offsets]:
    """Errors [m] that neighbours on an arm have in common, and those of each point."""
    found = []
    for one in poses:
        part = (one.points > one.points.mean(axis=0)) @ np.array([1, 2, 4])
        error = alike * rng.normal(size=8)[part] + own * rng.normal(size=len(part))
        found.append(Offsets(one.points, one.normals, error))
    return found


def fitted(poses: list[Offsets]) -> np.ndarray:
    """(6,) turn and shift that explain the distances best; the distances without them stay."""
    J = np.concatenate(
        [np.hstack([np.cross(p.points - PLACE, p.normals), p.normals]) for p in poses]
    )
    return np.linalg.lstsq(J, np.concatenate([p.distances for p in poses]), rcond=None)[0]


def left(poses: list[Offsets], x: np.ndarray) -> list[Offsets]:
    return [
        Offsets(
            p.points,
            p.normals,
            p.distances - np.hstack([np.cross(p.points - PLACE, p.normals), p.normals]) @ x,
        )
        for p in poses
    ]


@pytest.mark.parametrize(("alike", "own"), [(0.001, 0.0), (0.0, 0.005), (0.001, 0.005)])
def test_it_is_the_spread_of_results(alike: float, own: float) -> None:
    rng = np.random.default_rng(8)
    poses = [ball(rng, np.array([0.0, 0.2 * k, 0.4 + 0.1 * k])) for k in range(5)]
    errors, said = [], []
    for _ in range(150):
        seen = drawn(rng, poses, alike, own)
        x = fitted(seen)
        errors.append(x)
        found = uncertainty(left(seen, x), PLACE)
        assert found is not None
        said.append(found)
    turns, shifts = np.array(errors)[:, :3], np.array(errors)[:, 3:]
    spread = np.sqrt((shifts**2).sum(axis=1).mean()), np.sqrt((turns**2).sum(axis=1).mean())
    told = [
        np.sqrt(np.mean([getattr(one, name) ** 2 for one in said]))
        for name in ("translation", "rotation")
    ]
    np.testing.assert_allclose(told, spread, rtol=0.35)


def test_a_wall_leaves_directions_of_which_nothing_is_known() -> None:
    rng = np.random.default_rng(1)
    points = np.c_[np.zeros(500), rng.uniform(-1, 1, (500, 2))]
    normals = np.tile([1.0, 0.0, 0.0], (500, 1))
    wall = Offsets(points, normals, 0.001 * rng.normal(size=500))
    assert uncertainty(3 * [wall], PLACE) == Uncertainty(np.inf, np.inf)


def test_the_least_certain_direction_is_named() -> None:
    """Normals that hardly hold the shift upwards, seen from so near that turns are held."""
    rng = np.random.default_rng(2)
    poses = [ball(rng, np.array([0.0, 0.0, 0.4])) for _ in range(5)]
    flat = [VisibleSurface(one.points, one.normals * np.array([1.0, 1.0, 0.05])) for one in poses]
    found = uncertainty(drawn(rng, flat, 0.001, 0.005), np.array([0.0, 0.0, 0.4]))
    assert found is not None
    assert "shift in z" in found.direction
    assert "shift in x" not in found.direction


def test_of_too_few_poses_nothing_is_said() -> None:
    rng = np.random.default_rng(4)
    seen = drawn(rng, [ball(rng, np.zeros(3)) for _ in range(3)], 0.001, 0.005)
    nothing = offsets(np.zeros((3, 3)), VisibleSurface(np.empty((0, 3)), np.empty((0, 3))), 0.03)
    assert len(nothing.points) == 0
    assert uncertainty([*seen[:2], nothing], PLACE) is None
    assert uncertainty(seen, PLACE) is not None


def test_either_of_place_and_rotation_may_be_too_uncertain() -> None:
    allowed = Uncertainty(0.001, 0.002)
    assert not Uncertainty(0.001, 0.002).exceeds(allowed)
    assert Uncertainty(0.0011, 0.0).exceeds(allowed)
    assert Uncertainty(0.0, np.inf).exceeds(allowed)


def test_offsets_are_out_of_the_surface() -> None:
    surface = VisibleSurface(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))
    sensor = np.array([[0.0, 0.0, 0.01], [0.0, 0.0, -0.02], [0.0, 0.0, 0.5]])
    found = offsets(sensor, surface, 0.03)
    np.testing.assert_allclose(found.distances, [0.01, -0.02])
