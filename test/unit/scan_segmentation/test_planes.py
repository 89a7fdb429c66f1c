"""Segments and planes of places that are known exactly."""

import math

import numpy as np
import pytest
from safe_passage.evaluation.segmentation_places import room
from safe_passage.scan_segmentation import (
    OrganisedScan,
    Reason,
    ScanSegmenter,
    SegmentationError,
    SegmentationParameters,
)
from safe_passage.scan_segmentation.lines import find_segments
from safe_passage.scan_segmentation.planes import is_closed
from safe_passage.scan_segmentation.scan import to_cartesian
from safe_passage.simulation.scan_scene import Scanner, scan_place, upright

P = SegmentationParameters()
ALPHA = np.linspace(-0.7, 0.7, 141)


def corner_scan(noise=0.0, seed=0) -> OrganisedScan:
    """Each line sees two walls, u = 2 and v = 1, that meet in a corner."""
    with np.errstate(divide="ignore"):
        ranges = np.minimum(2.0 / np.cos(ALPHA), np.where(ALPHA > 0, 1.0 / np.sin(ALPHA), np.inf))
    ranges = np.tile(ranges, (20, 1))
    ranges += np.random.default_rng(seed).normal(0.0, noise, ranges.shape)
    beta = 0.01 * np.arange(20)
    return OrganisedScan(to_cartesian(ranges, ALPHA, beta), beta)


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_a_corner_makes_two_segments_that_end_in_it(noise):
    segments = find_segments(corner_scan(noise), P)
    assert len(segments) == 40
    assert (np.bincount(segments.row) == 2).all()
    corner = np.hypot(segments.end[::2, 0], segments.end[::2, 1]), segments.end[::2, 2]
    np.testing.assert_allclose(corner[0], 2.0, atol=0.03)
    np.testing.assert_allclose(corner[1], 1.0, atol=0.08)


def test_lost_beams_do_not_part_a_segment_and_gaps_do():
    scan = corner_scan()
    scan.points[:, 30] = np.nan
    assert len(find_segments(scan, P)) == 40
    scan.points[:, 20:50] = np.nan
    assert len(find_segments(scan, P)) == 60


def test_each_point_knows_its_segment():
    scan = corner_scan()
    segments = find_segments(scan, P)
    of = segments.of_points(scan.points.shape[:2])
    for i in (0, 7, 39):
        own = np.argwhere(of == i)
        assert (own[:, 0] == segments.row[i]).all()
        assert own[:, 1].min() == segments.first[i] and own[:, 1].max() == segments.last[i]


def test_whole_and_half_revolutions_are_told_apart():
    whole = 2.0 * math.pi * np.arange(100) / 100
    assert is_closed(whole) and not is_closed(whole[:50]) and is_closed(whole[::-1] + 3.0)


def matched(scanner, seed=3):
    """Normal and offset errors of each plane [deg, mm], and the surfaces met."""
    scan, which = scan_place(room(), scanner, seed)
    planes = ScanSegmenter().find_planes(scan)
    surfaces = room().surfaces()
    errors, met = [], set()
    for k, valid in enumerate(planes.valid):
        truth = np.bincount(which[(planes.labels == k) & (which >= 0)]).argmax()
        patch = surfaces[truth]
        normal = np.cross(patch.along, patch.across)
        normal /= np.linalg.norm(normal)
        found = scanner.rotation() @ valid.plane.normal
        points = scan.points[planes.labels == k] @ scanner.rotation().T + scanner.position
        off = abs(normal @ (points.mean(axis=0) - patch.corner))
        if valid.area > 1.0:
            errors.append((math.degrees(math.acos(min(1.0, abs(normal @ found)))), 1e3 * off))
        met.add(truth)
    return np.array(errors), met


@pytest.mark.parametrize(
    "scanner",
    [
        Scanner(pitch=0.2),
        Scanner(pitch=0.4, roll=2.0, yaw=0.3),
        Scanner(lines=80),
        upright(Scanner()),
    ],
)
def test_planes_of_a_room_are_where_they_are(scanner):
    errors, met = matched(scanner)
    assert len(met) >= 5
    assert (errors <= [0.6, 5.0]).all(), errors
    assert np.median(errors[:, 0]) <= 0.1


def test_planes_that_only_cross_walls_are_not_there():
    scan, which = scan_place(room(), Scanner(pitch=0.2), 1)
    planes = ScanSegmenter().find_planes(scan)
    for k in range(len(planes.valid)):
        counts = np.bincount(which[planes.labels == k] + 1)
        assert counts.max() > 0.9 * counts.sum()  # of one surface, not of several


def test_noise_without_a_place_has_no_plane():
    rng = np.random.default_rng(0)
    beta = np.linspace(0.0, 2.0 * math.pi, 200, endpoint=False)
    points = to_cartesian(rng.uniform(1.0, 8.0, (200, len(ALPHA))), ALPHA, beta)
    with pytest.raises(SegmentationError) as caught:
        ScanSegmenter().find_planes(OrganisedScan(points, beta))
    assert caught.value.reason is Reason.NO_PLANE
