"""The people of the simulated warehouse: as tall, as wide and as sure of foot as they should be."""

import numpy as np
import pytest
from safe_passage.core.errors import InputError
from safe_passage.simulation.people_assets import list_people, load_person

PEOPLE = list_people()


@pytest.fixture(scope="module", params=PEOPLE)
def body(request):
    return load_person(request.param)


def section(body, pose, z, spacing=0.01):
    """Points (N, 2) [m] along the lines in which the faces of a pose cross the height z."""
    corners = body.vertices[pose][body.faces]
    ends = []
    for i in range(3):
        a, b = corners[:, i], corners[:, (i + 1) % 3]
        rise = np.where(a[:, 2] == b[:, 2], np.inf, b[:, 2] - a[:, 2])
        share = (z - a[:, 2]) / rise
        crosses = ((share > 0.0) & (share < 1.0))[:, None]
        ends.append(np.where(crosses, a[:, :2] + share[:, None] * (b - a)[:, :2], np.nan))
    cut = np.isfinite(np.stack(ends)[:, :, 0]).sum(axis=0) == 2
    points = []
    for edge in np.stack(ends, axis=1)[cut]:
        a, b = edge[np.isfinite(edge[:, 0])]
        steps = np.linspace(0.0, 1.0, 2 + int(np.hypot(*(b - a)) / spacing))
        points.append(a + steps[:, None] * (b - a))
    return np.concatenate(points)


def blobs(points, gap=0.02):
    """Groups of points that no gap separates."""
    groups, left = [], list(range(len(points)))
    while left:
        group, front = [], [left.pop()]
        while front:
            at = front.pop()
            group.append(at)
            near = [i for i in left if np.hypot(*(points[i] - points[at])) < gap]
            left = [i for i in left if i not in near]
            front += near
        groups.append(points[group])
    return groups


def test_there_are_different_people():
    heights = [load_person(name).height_m for name in PEOPLE]
    assert len(PEOPLE) >= 6
    assert min(heights) < 1.60
    assert max(heights) > 1.90
    assert all(1.5 < height < 2.0 for height in heights)


def test_unknown_person_is_refused_by_name():
    with pytest.raises(InputError, match="nobody"):
        load_person("nobody")


def test_arrays_fit_each_other(body):
    poses, count, _ = body.vertices.shape
    assert body.phases.shape == (poses,)
    assert np.isnan(body.phases[0])
    assert np.allclose(body.phases[1:], np.arange(poses - 1) / (poses - 1))
    assert set(body.faces.ravel()) == set(range(count))
    assert body.face_texcoords.shape == body.faces.shape
    assert body.face_texcoords.max() < len(body.texcoords)
    assert body.texcoords.min() >= 0.0 and body.texcoords.max() <= 1.0
    assert body.face_regions.shape == (len(body.faces),)
    assert body.palette.shape == (len(body.region_names), 3)
    assert body.texture.dtype == np.uint8
    assert len(body.faces) < 2600
    assert np.isfinite(body.vertices).all()


def test_stands_on_the_floor_and_is_as_tall_as_said(body):
    for pose in body.vertices:
        assert pose[:, 2].min() == pytest.approx(0.0, abs=0.012)
        assert pose[:, 2].max() == pytest.approx(body.height_m, abs=0.08)
    assert body.standing[:, 2].max() == pytest.approx(body.height_m, abs=0.001)


def test_pelvis_is_over_the_origin_and_arms_hang(body):
    at_hip = np.abs(body.standing[:, 2] - 0.53 * body.height_m) < 0.05 * body.height_m
    trunk = body.standing[at_hip & (np.abs(body.standing[:, 1]) < 0.15)]
    middle = 0.5 * (trunk.min(axis=0) + trunk.max(axis=0))
    assert np.hypot(*middle[:2]) < 0.06
    assert np.ptp(body.standing[:, 1]) < 0.45 * body.height_m


def test_forward_is_x(body):
    shoes, head = (body.standing[body.vertices_of(region)] for region in ("shoes", "head"))
    shank = body.standing[np.abs(body.standing[:, 2] - 0.25) < 0.08]
    assert shoes[:, 0].max() - shank[:, 0].mean() > 0.10  # toes
    nose = head[head[:, 0].argmax()]
    assert abs(nose[1]) < 0.03


def test_every_part_is_closed_and_faces_outwards(body):
    """A ray from outside meets a front face first: all edges have two faces, volume is positive."""
    edges = np.concatenate([body.faces[:, [0, 1]], body.faces[:, [1, 2]], body.faces[:, [2, 0]]])
    directed, counts = np.unique(edges, axis=0, return_counts=True)
    there = {tuple(edge) for edge in directed.tolist()}
    lone = [edge for edge in there if edge[::-1] not in there]
    assert lone == []
    for pose in body.vertices:
        a, b, c = (pose[body.faces[:, i]].astype(float) for i in range(3))
        litres = 1000.0 * np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0
        assert 50.0 < litres < 180.0


def test_legs_are_two_at_a_lidars_height(body):
    for pose in (0, *(i for i, phase in enumerate(body.phases) if phase in (0.0, 0.5))):
        legs = blobs(section(body, pose, 0.12))
        assert len(legs) == 2
        for leg in legs:
            assert 0.06 < np.ptp(leg[:, 1]) < 0.24
            assert 0.08 < np.ptp(leg[:, 0]) < 0.36


def test_supporting_foot_does_not_slip(body):
    """The left foot is flat on the floor from phase 0.1 to 0.35."""
    shoes = body.vertices_of("shoes")
    left = shoes[body.standing[shoes, 1] > 0.0]
    flat = [i for i, phase in enumerate(body.phases) if 0.1 <= phase <= 0.35]
    assert len(flat) >= 2
    for i, j in zip(flat, flat[1:]):
        moved = body.vertices[j][left] - body.vertices[i][left]
        expected = -body.stride_m * (body.phases[j] - body.phases[i])
        assert np.allclose(moved, [expected, 0.0, 0.0], atol=0.002)


def test_arms_swing_against_the_legs(body):
    strike = int(np.nanargmin(np.abs(body.phases - 0.0)))  # left heel
    pose = body.vertices[strike]
    hands, shoes = body.vertices_of("skin"), body.vertices_of("shoes")

    def ahead(of):
        left = body.standing[of, 1] > 0.0
        return pose[of][left, 0].mean() - pose[of][~left, 0].mean()

    assert ahead(shoes) > 0.4
    assert ahead(hands) < -0.1


def test_pose_at_goes_once_through_the_walk_in_a_stride(body):
    poses = [body.pose_at(walked) for walked in np.linspace(0.0, 0.999 * body.stride_m, 200)]
    assert set(poses) == set(range(1, len(body.phases)))
    assert body.pose_at(0.0) == body.pose_at(body.stride_m) == 1
