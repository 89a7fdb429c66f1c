"""Whole scans: the paper's garage and hallway, holes, lost ground, a caller that gives up."""

import dataclasses
import math

import numpy as np
import pytest
from safe_passage.evaluation.segmentation_places import (
    blocked_at,
    garage,
    hallway,
    in_world,
    random_case,
    room,
)
from safe_passage.scan_segmentation import (
    Colour,
    Reason,
    RobotConfiguration,
    ScanSegmenter,
    SegmentationError,
)
from safe_passage.simulation.scan_scene import Scanner, scan_place

SMALLEST = RobotConfiguration(length=1.2, width=0.85, height=1.4)
SCANNER = Scanner(pitch=0.2)


@pytest.fixture(scope="module")
def garage_scan():
    return scan_place(garage(), SCANNER, 1)[0]


@pytest.fixture(scope="module")
def hallway_scan():
    return scan_place(hallway(), SCANNER, 1)[0]


def door_cells(found) -> np.ndarray:
    """Colours along the middle of the garage's door, a strip a half metre to both sides."""
    y, x = np.meshgrid(np.linspace(-0.1, 0.9, 101), np.linspace(3.95, 4.2, 26))
    return found.drivable.at(np.column_stack([x.ravel(), y.ravel()])).reshape(x.shape)


def is_passable(found) -> bool:
    return bool(np.isin(door_cells(found), (Colour.GREEN, Colour.ORANGE)).any(axis=1).all())


def test_the_garages_door_is_narrow_for_the_smallest_configuration(garage_scan):
    found = ScanSegmenter().segment(garage_scan, SMALLEST)
    assert is_passable(found)
    assert not (door_cells(found) == Colour.GREEN).any()


@pytest.mark.parametrize("change", [{"width": 0.95}, {"height": 2.1}, {"margin": 0.05}])
def test_and_closed_for_wider_and_higher_ones(garage_scan, change):
    robot = dataclasses.replace(SMALLEST, **change)
    assert not is_passable(ScanSegmenter().segment(garage_scan, robot))


def test_the_garages_door_is_measured(garage_scan):
    wide = dataclasses.replace(SMALLEST, width=0.95)
    robots = {"smallest": SMALLEST, "wide": wide}
    (door,) = ScanSegmenter().segment(garage_scan, SMALLEST, robots).doors
    assert door.width == pytest.approx(0.90, abs=0.02)
    assert door.height == pytest.approx(2.0, abs=0.03)
    assert door.thickness == pytest.approx(0.15, abs=0.02)
    assert door.yaw == pytest.approx(0.0, abs=0.02)
    assert door.middle == pytest.approx((4.0, 0.4, -1.2), abs=0.03)
    assert door.passable_by == ("smallest",)


def test_the_hallway_has_two_ground_planes_and_both_are_green(hallway_scan):
    found = ScanSegmenter().segment(hallway_scan, SMALLEST)
    angles = sorted(plane.angle for plane in found.ground)
    assert angles[0] == pytest.approx(0.0, abs=0.01)
    assert angles[-1] == pytest.approx(math.atan(0.12), abs=0.01)
    for at in ((0.5, 0.0), (3.6, 1.3)):
        assert found.drivable.at(np.array([at])) == Colour.GREEN


@pytest.mark.parametrize("steps, rise, run", [(6, 0.16, 0.30), (4, 0.18, 0.26), (8, 0.17, 0.28)])
def test_stairs_are_counted_and_measured(steps, rise, run):
    scanner = Scanner(position=(0.0, -0.3, 1.4), pitch=0.1)
    scan, _ = scan_place(hallway(steps, rise, run), scanner, 5)
    (flight,) = ScanSegmenter().segment(scan, SMALLEST).stairs
    assert flight.steps == steps
    assert (flight.rise, flight.run) == pytest.approx((rise, run), abs=0.015)
    assert flight.yaw == pytest.approx(0.0, abs=0.05)
    assert flight.width == pytest.approx(1.6, abs=0.45)
    assert flight.foot[0] == pytest.approx(2.5, abs=0.05)


@pytest.mark.parametrize("number", range(4))
def test_nothing_that_is_no_floor_is_drivable(number):
    case = random_case(number, 31)
    scan, _ = scan_place(case.place, case.scanner, number)
    found = ScanSegmenter().segment(scan, SMALLEST)
    row, column = np.nonzero(np.isin(found.drivable.cells, (Colour.GREEN, Colour.ORANGE)))
    assert len(row) > 1000
    cells = np.stack([column, row], axis=1) + 0.5
    at = found.drivable.origin + cells * found.drivable.resolution
    assert not blocked_at(case.place, in_world(case.scanner, at), 0.2, 1.4).any()


def test_there_are_no_doors_and_stairs_where_there_are_none():
    found = ScanSegmenter().segment(scan_place(room(), SCANNER, 2)[0], SMALLEST)
    assert found.doors == [] and found.stairs == []


def reason_of(scan) -> Reason:
    with pytest.raises(SegmentationError) as caught:
        ScanSegmenter().segment(scan, SMALLEST)
    return caught.value.reason


def test_a_scan_without_ground_is_refused_with_its_reason(garage_scan):
    upside_down = dataclasses.replace(garage_scan, up=tuple(-v for v in garage_scan.up))
    points = garage_scan.points.copy()
    height = points @ np.array(garage_scan.up)
    ceiling_only = np.where((height > 0.2)[..., None], points, np.nan)
    walls_only = np.where((np.abs(height) < 0.8)[..., None], points, np.nan)
    assert reason_of(dataclasses.replace(garage_scan, points=ceiling_only)) is (
        Reason.SCANNER_BELOW_GROUND
    )
    assert reason_of(dataclasses.replace(garage_scan, points=walls_only)) is Reason.NO_GROUND
    # what was the ceiling is taken for the ground then: no scan tells where gravity points
    assert ScanSegmenter().segment(upside_down, SMALLEST).ground


def test_little_ground_is_too_little(garage_scan):
    points = garage_scan.points.copy()
    low = points @ np.array(garage_scan.up) < -1.1
    forward = points @ np.array(garage_scan.axis)
    far = low & ~((forward > 1.0) & (forward < 1.7) & (np.abs(points[..., 0]) < 0.4))
    points[far] = np.nan
    assert reason_of(dataclasses.replace(garage_scan, points=points)) is Reason.FEW_GROUND_POINTS


def test_progress_is_told_and_stops_it(garage_scan):
    told = []
    ScanSegmenter().segment(garage_scan, SMALLEST, progress=lambda *at: told.append(at) or True)
    shares = [share for _, share in told]
    assert shares == sorted(shares) and shares[0] == 0.0 and shares[-1] < 1.0
    with pytest.raises(SegmentationError) as caught:
        ScanSegmenter().segment(garage_scan, progress=lambda stage, _: stage != "ground")
    assert caught.value.reason is Reason.CANCELLED


def test_planes_are_given_before_the_rest(garage_scan):
    order = []
    ScanSegmenter().segment(
        garage_scan,
        SMALLEST,
        progress=lambda stage, _: order.append(stage) or True,
        on_planes=lambda planes: order.append(len(planes.valid)),
    )
    assert order.index("planes") < order.index("ground")
    assert isinstance(order[order.index("planes") + 1], int)


def test_the_orientation_of_the_scanner_does_not_matter():
    """The same place from a scanner on an arm that holds it askew."""
    askew = Scanner(position=(0.1, 0.1, 1.0), yaw=0.3, pitch=0.5, roll=1.0)
    found = ScanSegmenter().segment(scan_place(garage(), askew, 3)[0], SMALLEST)
    (door,) = found.doors
    assert door.width == pytest.approx(0.90, abs=0.03)
    at = in_world(askew, np.array([door.middle[:2]]))[0]
    np.testing.assert_allclose(at, [4.0, 0.4], atol=0.03)


def spoilt(points: np.ndarray, how: str) -> np.ndarray:
    rng = np.random.default_rng(len(how))
    some = rng.random(points.shape[:2]) < 0.3
    return {
        "noise": lambda: rng.normal(0.0, 1e4, (60, 40, 3)),
        "holes": lambda: np.where(some[..., None], np.nan, points),
        "infinite": lambda: np.where(some[..., None], np.inf, points),
        "huge": lambda: np.where(some[..., None], 1e30, points),
        "doubles": lambda: np.repeat(np.repeat(points, 2, axis=0), 2, axis=1),
        "large": lambda: points * 1e3,
        "small": lambda: points * 1e-3,
        "flat": lambda: points * [1.0, 1.0, 0.0],
        "coarse": lambda: np.round(points, 1),
        "shaken": lambda: points + rng.normal(0.0, 0.2, points.shape),
        "narrow": lambda: points[:, :10],
    }[how]()


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("width", [0.05, 20.0])
@pytest.mark.parametrize(
    "how",
    "noise holes infinite huge doubles large small flat coarse shaken narrow".split(),
)
def test_a_spoilt_scan_is_segmented_or_refused_with_a_reason(how, width):
    scan, _ = scan_place(garage(), Scanner(pitch=0.3, lines=100), 1)
    points = spoilt(scan.points.astype(float), how)
    beta = np.linspace(0.0, 2.0 * math.pi, len(points), endpoint=False)
    bad = dataclasses.replace(scan, points=points, beta=beta, remission=None)
    robot = RobotConfiguration(length=width, width=width, max_obstacle=0.0)
    try:
        found = ScanSegmenter().segment(bad, robot)
    except SegmentationError as refused:
        assert refused.reason in Reason
    else:
        assert found.ground and found.drivable.cells.max() <= Colour.RED
