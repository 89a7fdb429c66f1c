"""What the scanners know of a place before something came there."""

import math

import numpy as np
import pytest
from camera_room import body, camera, cloud
from hypothesis import given, settings
from hypothesis import strategies as st
from safe_passage.core.geometry import compose, inverse, placed
from safe_passage.monitoring.aggregation import Measurement, Points
from safe_passage.monitoring.free_space import APART, KEPT, PASSING, FreeSpace
from safe_passage.monitoring.fusion_grid import Fusion
from safe_passage.monitoring.views import CloudView, ScanView

STILL = (0.0, 0.0, 0.0)
ROOM = 5.0  # [m] radius


def room(scanner=(0.0, 0.0), thing=None, radius=0.15) -> np.ndarray:
    """Points (N, 2) [m] of a round room as a scanner sees it, with a round thing in it."""
    angles = np.radians(np.arange(0.0, 360.0, 0.5))
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    along = ways @ np.array(scanner)
    reach = np.sqrt(ROOM**2 - scanner[0] ** 2 - scanner[1] ** 2 + along**2) - along
    if thing is not None:
        to = np.array(thing) - scanner
        off = np.abs(ways[:, 0] * to[1] - ways[:, 1] * to[0])
        hit = (off < radius) & (ways @ to > 0.0)
        front = ways @ to - np.sqrt(np.maximum(radius**2 - off**2, 0.0))
        reach = np.where(hit, np.minimum(reach, front), reach)
    return ways * reach[:, None] + scanner


def scan(stamp, points, pose=STILL, scanner=(0.0, 0.0)) -> Measurement:
    """`points` in the odometry's frame, measured from `scanner` in base."""
    in_base = placed(points, inverse(pose))
    return Measurement("laser", stamp, pose, in_base, ScanView.of(in_base, scanner))


def judged(memory: FreeSpace, places, stamp, pose=STILL):
    """(new, stood) of places [m] in the odometry's frame, in their order."""
    xy = placed(np.array(places, float).reshape(-1, 2), inverse(pose))
    xyz = np.column_stack([xy, np.zeros(len(xy))]).astype(np.float32)
    nothing = np.zeros(len(xyz))
    cloud = Points(xyz, nothing > 0, nothing.astype(int), nothing, nothing == 0)
    grid = Fusion(15.0, 0.1, np.array([False])).fuse(cloud)
    grid = memory.judged(grid, pose, stamp)
    at = np.searchsorted(grid.cell, grid.cells_of(xy))
    return grid.new[at].tolist(), grid.stood[at].tolist()


def test_who_comes_is_new_and_the_wall_has_stood():
    memory = FreeSpace()
    for k in range(4):
        memory.add(scan(0.5 * k, room()))
    new, stood = judged(memory, [(2.0, 1.0), (ROOM, 0.0)], 1.6)
    assert new == [True, False]
    assert stood == [False, True]


def test_of_what_was_hidden_nothing_is_known():
    memory = FreeSpace()
    for k in range(4):
        memory.add(scan(0.5 * k, room(thing=(2.0, 0.0))))
    new, stood = judged(memory, [(3.5, 0.0), (1.9, 0.0)], 1.6)
    assert new == [False, False]
    assert stood == [False, True]


def test_who_stays_is_not_new_for_long():
    memory = FreeSpace()
    memory.add(scan(0.0, room()))
    here, stamps = (2.0, 0.0), np.arange(0.5, 0.5 + KEPT + PASSING, 0.1)
    for stamp in stamps:
        memory.add(scan(float(stamp), room(thing=here)))
        new, _ = judged(memory, [(1.87, 0.0)], float(stamp))
        assert new == [True] or stamp > 0.5 + PASSING
    assert judged(memory, [(1.87, 0.0)], float(stamps[-1])) == ([False], [True])


def test_what_was_seen_long_ago_is_forgotten():
    memory = FreeSpace()
    memory.add(scan(0.0, room()))
    assert judged(memory, [(2.0, 0.0)], KEPT)[0] == [True]
    assert judged(memory, [(2.0, 0.0)], KEPT + 0.01)[0] == [False]


def test_a_thing_that_not_every_scan_meets_is_not_new():
    """A table's leg is thinner than the beams are apart."""
    memory = FreeSpace()
    memory.add(scan(0.0, room(thing=(3.0, 0.0), radius=0.02)))
    memory.add(scan(0.5, room()))
    new, stood = judged(memory, [(2.98, 0.0)], 1.2)
    assert new == [False]
    assert stood == [False]


def test_not_every_scan_is_kept():
    memory = FreeSpace()
    memory.add(scan(0.0, room()))
    memory.add(scan(0.5 * APART, room(thing=(2.0, 0.0))))
    assert judged(memory, [(1.87, 0.0)], 1.5)[1] == [False]


def test_a_scanner_sees_under_a_table_that_only_a_camera_sees():
    memory = FreeSpace()
    for k in range(4):
        memory.add(scan(0.5 * k, room()))
    xyz = np.array([[2.0, 1.0, 0.7], [2.0, -1.0, 0.0]], np.float32)
    sensor, nothing = np.array([1, 0]), np.zeros(2)
    both = Points(xyz, nothing > 0, sensor, nothing, nothing == 0)
    grid = Fusion(15.0, 0.1, np.array([False, True])).fuse(both)
    new = memory.judged(grid, STILL, 1.6).new
    assert new.tolist() == [True, False]  # in rows from the right: what the scanner sees came


def test_a_camera_knows_who_comes_and_what_stood_there():
    memory, T = FreeSpace(), camera()
    for k in range(4):
        points = cloud(T, body(3.0, 1.0))
        memory.add(Measurement("camera", 0.5 * k, STILL, points, CloudView.of(points, T)))
    xyz = np.array([[2.5, -0.5, 0.2], [2.5, -0.5, 1.6], [2.8, 1.0, 0.2], [2.8, 1.0, 1.6]])
    nothing = np.zeros(4)
    seen = Points(xyz.astype(np.float32), nothing > 0, nothing.astype(int), nothing, nothing == 0)
    grid = memory.judged(Fusion(15.0, 0.1, np.array([True])).fuse(seen), STILL, 1.6)
    assert grid.new.tolist() == [True, False]
    assert grid.stood.tolist() == [False, True]
    assert memory.cameras() == {"camera"}


def test_a_scan_out_of_order_is_not_the_last():
    memory = FreeSpace()
    memory.add(scan(0.2, room(thing=(2.0, 0.0))))
    memory.add(scan(0.1, room()))
    stale = Points(
        np.array([[1.87, 0.0, 0.0]], np.float32), *np.zeros((3, 1), int), np.zeros(1, bool)
    )
    grid = Fusion(8.0, 0.1, np.array([False])).fuse(stale)
    assert not memory.judged(grid, STILL, 0.2).left.any()


def test_after_a_reset_nothing_is_known():
    memory = FreeSpace()
    memory.add(scan(0.0, room()))
    memory.reset()
    assert judged(memory, [(2.0, 0.0)], 0.5) == ([False], [False])


def test_an_empty_scan_tells_nothing():
    memory = FreeSpace()
    memory.add(scan(0.0, np.empty((0, 2))))
    assert judged(memory, [(2.0, 0.0)], 0.5) == ([False], [False])


@settings(deadline=None)
@given(
    start=st.tuples(*[st.floats(-2.0, 2.0)] * 2, st.floats(-3.0, 3.0)),
    motion=st.tuples(*[st.floats(-1.0, 1.0)] * 3),
    scanner=st.tuples(*[st.floats(-0.5, 0.5)] * 2),
)
def test_from_wherever_it_is_seen_the_room_is_old_and_its_middle_free(start, motion, scanner):
    memory = FreeSpace()
    poses = [compose(start, tuple(0.5 * k * m for m in motion)) for k in range(4)]
    for k, pose in enumerate(poses):
        at = placed(np.array([scanner]), np.array(pose))[0]
        if math.hypot(*at) > ROOM - 0.5:
            return
        memory.add(scan(0.5 * k, room(tuple(at)), pose, scanner))
    away = math.atan2(-at[1], -at[0])  # across the room from the scanner
    new, stood = judged(
        memory, [(0.98 * ROOM * math.cos(away), 0.98 * ROOM * math.sin(away))], 1.6, poses[-1]
    )
    assert new == [False]
    middle = at + 1.0 * np.array([math.cos(away), math.sin(away)])
    new, stood = judged(memory, [middle], 1.6, poses[-1])
    assert new == [True]
    assert stood == [False]


@pytest.mark.parametrize("step", [-1.0, 1.0])
def test_a_turning_robot_sees_no_newcomer_in_the_wall(step):
    memory = FreeSpace()
    for k in range(6):
        pose = (0.0, 0.0, step * 0.4 * k)
        memory.add(scan(0.4 * k, room(), pose))
    wall = room()[::20] * 0.995
    assert not any(judged(memory, wall, 2.1, pose)[0])


def test_what_the_last_scan_passes_has_left():
    memory = FreeSpace()
    memory.add(scan(0.0, room(thing=(2.0, 0.0))))
    memory.add(scan(0.1, room(thing=(2.0, 1.0))))
    xyz = np.array([[1.87, 0.0, 0.0], [1.87, 0.94, 0.0], [3.5, 1.75, 0.0]], np.float32)
    nothing = np.zeros(3)
    stale = Points(xyz, nothing > 0, nothing.astype(int), nothing + 0.1, nothing > 0)
    grid = memory.judged(Fusion(8.0, 0.1, np.array([False])).fuse(stale), STILL, 0.1)
    left = dict(zip(np.round(grid.position[:, 1], 2).tolist(), grid.left.tolist()))
    assert left == {0.0: True, 0.94: False, 1.75: False}  # gone, here, hidden
    fresh = Points(xyz, nothing > 0, nothing.astype(int), nothing, nothing == 0)
    assert not memory.judged(Fusion(8.0, 0.1, np.array([False])).fuse(fresh), STILL, 0.1).left.any()
