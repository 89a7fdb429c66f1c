"""The tracker in behaviour terms, on points whose truth is known."""

import math
from dataclasses import replace

import numpy as np
import pytest
from camera_room import body, camera, cloud
from safe_passage.core.geometry import compose, inverse, placed
from safe_passage.monitoring.aggregation import Measurement
from safe_passage.monitoring.parameters import CLOUD, SourceParameters, TrackerParameters
from safe_passage.monitoring.pipeline import ObstacleTracker
from safe_passage.monitoring.preprocessing import cloud_points
from safe_passage.monitoring.views import CloudView, ScanView

DT = 0.05  # [s]
STILL = (0.0, 0.0, 0.0)
LASER = SourceParameters("laser")
CAMERA = SourceParameters("camera", CLOUD, aggregate=1)
P = TrackerParameters(sources=(LASER, CAMERA))


def disc(x: float, y: float, radius: float = 0.12, count: int = 24) -> np.ndarray:
    """Points (N, 2) [m] on a circle."""
    turn = np.linspace(0.0, 2 * math.pi, count, endpoint=False)
    return np.column_stack([x + radius * np.cos(turn), y + radius * np.sin(turn)])


def wall(x0: float, y0: float, x1: float, y1: float) -> np.ndarray:
    """Points (N, 2) [m], 3 cm apart."""
    count = int(math.hypot(x1 - x0, y1 - y0) / 0.03)
    return np.column_stack([np.linspace(x0, x1, count), np.linspace(y0, y1, count)])


def seen_from(pose, *things: np.ndarray) -> np.ndarray:
    """Points (N, 3) in base of `things` (N, 2) in the odometry's frame."""
    xy = placed(np.concatenate(things) if things else np.empty((0, 2)), inverse(pose))
    return np.column_stack([xy, np.zeros(len(xy))])


class Run:
    """Feeds a tracker and keeps what it said last; noise of 1 cm."""

    def __init__(self, parameters: TrackerParameters = P) -> None:
        self.tracker, self.cycle = ObstacleTracker(parameters), 0
        self._rng = np.random.default_rng(5)

    @property
    def time(self) -> float:
        return self.cycle * DT

    def see(self, *things: np.ndarray, pose=STILL, source: str = "laser"):
        points = seen_from(pose, *things)
        points[:, :2] += self._rng.normal(0.0, 0.01, (len(points), 2))
        return self.go(pose, Measurement(source, self.time, pose, points))

    def scan(self, *things: np.ndarray):
        """As `see`, by a scanner in the robot's middle: only what nothing hides."""
        xy = np.concatenate(things)
        bearing = np.floor(np.degrees(np.arctan2(xy[:, 1], xy[:, 0])) / 0.5)
        order = np.lexsort([np.hypot(*xy.T), bearing])
        first = order[np.unique(bearing[order], return_index=True)[1]]
        points = seen_from(STILL, xy[first])
        points[:, :2] += self._rng.normal(0.0, 0.01, (len(points), 2))
        view = ScanView.of(points, (0.0, 0.0))
        return self.go(STILL, Measurement("laser", self.time, STILL, points, view))

    def go(self, pose, *measurements: Measurement):
        self.last = self.tracker.update(self.time, pose, measurements)
        self.cycle += 1
        return self.last

    def at(self, x: float, y: float, reach: float = 0.3) -> list:
        """Numbers of the tracks near a place in base."""
        tracks = self.last.tracks
        away = np.hypot(*(tracks.position - (x, y)).T)
        return np.flatnonzero(away < reach).tolist()

    def one_at(self, x: float, y: float) -> int:
        (number,) = self.at(x, y)
        return number


def test_a_walker_keeps_its_identity_and_its_speed_is_known():
    run, ids = Run(), set()
    for k in range(80):
        x = -2.0 + 1.2 * k * DT
        run.see(disc(x, 1.0), wall(-3, -2, 3, -2))
        ids.add(int(run.last.tracks.id[run.one_at(x, 1.0)]))
    tracks, i = run.last.tracks, run.one_at(x, 1.0)
    assert len(ids) == 1
    assert tracks.moving[i]
    assert tracks.velocity[i] == pytest.approx([1.2, 0.0], abs=0.1)
    assert tracks.x[i, :2] + tracks.offset[i] == pytest.approx([x, 1.0], abs=0.05)
    assert not tracks.moving[run.one_at(0.0, -2.0)]


def test_what_was_put_together_does_not_lag():
    """The mean of three scans is where the walker was; the estimate is where it is."""
    run = Run(replace(P, sources=(replace(LASER, aggregate=5), CAMERA)))
    for k in range(80):
        x = -2.0 + 1.5 * k * DT
        run.see(disc(x, 1.0))
    tracks = run.last.tracks
    assert tracks.x[run.one_at(x, 1.0), 0] == pytest.approx(x, abs=0.06)


@pytest.mark.parametrize("motion", [(0.8, 0.0, 0.0), (0.0, 0.0, 0.8), (0.5, 0.3, -0.5)])
def test_nothing_moves_but_the_robot(motion):
    run, pose = Run(), STILL
    room = [wall(-4, -3, 4, -3), wall(4, -3, 4, 3), wall(4, 3, -4, 3), disc(2, 1), disc(-1, -2)]
    first = None
    for _ in range(100):
        run.see(*room, pose=pose)
        first = run.last if first is None else first
        pose = compose(pose, tuple(DT * m for m in motion))
    tracks = run.last.tracks
    assert not tracks.moving.any()
    assert set(tracks.id) == set(first.tracks.id)
    assert np.hypot(*tracks.velocity.T).max() < P.moving_speed


def test_a_table_half_of_which_disappears_does_not_move():
    """Something passes in the foreground: the centroid shifts, the table does not."""
    run, table = Run(), [wall(1.0, 1.0, 2.6, 1.0), wall(1.0, 1.0, 1.0, 1.8)]
    for _ in range(20):
        run.see(*table)
    ident = int(run.last.tracks.id[0])
    for k in range(40):
        hidden_to = 1.0 + 0.03 * k
        points = np.concatenate(table)
        run.see(points[points[:, 0] > hidden_to])
        tracks = run.last.tracks
        assert not tracks.moving.any()
    i = int(np.flatnonzero(tracks.id == ident)[0])
    assert np.hypot(*tracks.velocity[i]) < 0.25


def test_without_alignment_that_table_seems_to_move_faster():
    speeds = {}
    for alignment in (True, False):
        run = Run(replace(P, alignment=alignment))
        points = np.concatenate([wall(1.0, 1.0, 2.6, 1.0), wall(1.0, 1.0, 1.0, 1.8)])
        fastest = 0.0
        for k in range(60):
            run.see(points[points[:, 0] > 1.0 + 0.03 * max(0, k - 20)])
            fastest = max(fastest, float(np.hypot(*run.last.tracks.velocity.T).max()))
        speeds[alignment] = fastest
    assert speeds[True] < 0.5 * speeds[False]


def test_two_legs_are_one_person():
    run, ids = Run(), []
    for k in range(100):
        x = -2.5 + 1.0 * k * DT
        swing = 0.25 * math.sin(2 * math.pi * 0.9 * k * DT)
        run.see(disc(x + swing, 1.1, 0.06, 12), disc(x - swing, 0.9, 0.06, 12))
        if k > 30:
            moving = run.last.tracks.moving
            ids.append(tuple(run.last.tracks.id[moving].tolist()))
    assert len(set(ids)) == 1
    assert len(ids[0]) == 1


def test_a_person_who_passes_a_table_and_the_table_stay_two():
    run, table = Run(), wall(-0.6, 1.0, 0.6, 1.0)
    ids = set()
    for k in range(100):
        x = -2.5 + 1.0 * k * DT
        run.see(table, disc(x, 1.18))
        tracks = run.last.tracks
        ids.add(int(tracks.id[np.argmin(np.hypot(*(tracks.position - (x, 1.18)).T))]))
    tables = [i for i in run.at(0.0, 1.0) if tracks.cells[i] > 8]
    assert len(tables) == 1
    assert not tracks.moving[tables[0]]
    assert len(ids) == 1


HALL = np.concatenate([wall(-4, 3, 4, 3), wall(-4, -3, 4, -3), wall(-4, -3, -4, 3)])


def test_who_walks_along_a_wall_is_known_at_once_and_stays_the_same():
    """Close enough to be one cluster with it, from the first moment on."""
    run, ids = Run(), set()
    for k in range(120):
        x = -2.5 + 1.0 * max(k - 20, 0) * DT
        run.scan(HALL, disc(x, 2.8, 0.15))
        if k > 45:
            tracks = run.last.tracks
            near = [i for i in run.at(x, 2.8, 0.35) if tracks.moving[i]]
            ids.update(tracks.id[near].tolist())
            assert near, f"nobody walks at {x:.1f} m"
    assert len(ids) == 1


def test_who_leaves_a_table_moves_and_the_table_does_not():
    run, table = Run(), wall(1.0, -0.6, 1.0, 0.6)
    for k in range(75):
        y = 0.75 + 0.8 * max(k - 40, 0) * DT
        run.scan(HALL, table, disc(1.0, y, 0.15))
    tracks = run.last.tracks
    assert tracks.moving[run.one_at(1.0, y)]
    assert tracks.moving.sum() == 1


def test_who_turns_on_the_spot_stays_the_same():
    run, ids = Run(), set()
    for k in range(140):
        t = k * DT
        x = -1.5 + 1.1 * t if t < 3.0 else 1.8 - 1.1 * (t - 3.0)
        run.scan(HALL, disc(x, 1.5, 0.15))
        if k > 20:
            tracks = run.last.tracks
            ids.update(tracks.id[[i for i in run.at(x, 1.5, 0.5) if tracks.moving[i]]].tolist())
    assert len(ids) == 1


def test_a_walker_who_vanishes_does_not_take_what_stood_there():
    run, post = Run(), disc(1.9, 1.5, 0.1)
    for k in range(60):
        run.scan(HALL, post, disc(-1.5 + 1.1 * k * DT, 1.5, 0.15))
    tracks = run.last.tracks
    (post_id,) = (int(tracks.id[i]) for i in run.at(1.9, 1.5) if not tracks.moving[i])
    for _ in range(60):
        run.scan(HALL, post)
    tracks = run.last.tracks
    (left,) = run.at(1.9, 1.5, 0.5)
    assert int(tracks.id[left]) == post_id
    assert not tracks.moving.any()


def test_a_hidden_person_is_kept_for_so_long_and_found_again():
    run = Run(replace(P, max_unobserved=10 * DT))
    for k in range(40):
        run.see(disc(-1.0 + k * DT, 1.0))
    ident = int(run.last.tracks.id[0])
    for _ in range(9):
        run.see(wall(-3, -2, 3, -2))
    assert ident in run.last.tracks.id
    assert run.last.tracks.misses[run.last.tracks.id == ident] > 0
    x = -1.0 + 49 * DT
    for k in range(3):
        run.see(disc(x + k * DT, 1.0), wall(-3, -2, 3, -2))
    assert run.last.tracks.id[run.one_at(x + 2 * DT, 1.0)] == ident
    for _ in range(LASER.aggregate + 11):
        run.see(wall(-3, -2, 3, -2))
    assert ident not in run.last.tracks.id


def test_moving_is_for_good():
    run = Run()
    for k in range(40):
        run.see(disc(-1.0 + k * DT, 1.0))
    for _ in range(60):
        run.see(disc(-1.0 + 39 * DT, 1.0))
    i = run.one_at(-1.0 + 39 * DT, 1.0)
    assert run.last.tracks.moving[i]
    assert np.hypot(*run.last.tracks.velocity[i]) < 0.2


def test_who_leaves_one_sensor_for_the_other_stays_the_same():
    run, ids = Run(), set()
    for k in range(100):
        x = -2.5 + k * DT
        seen, nothing = seen_from(STILL, disc(x, 1.0)), seen_from(STILL)
        laser, camera = (seen, nothing) if x < 0.0 else (nothing, seen)
        run.go(
            STILL,
            Measurement("laser", run.time, STILL, laser),
            Measurement("camera", run.time, STILL, camera),
        )
        ids.add(int(run.last.tracks.id[run.one_at(x, 1.0)]))
    assert len(ids) == 1


def test_a_silent_sensor_leaves_the_others_at_work():
    run = Run()
    for k in range(40):
        wall_points = seen_from(STILL, wall(-3, -2, 3, -2))
        walker = seen_from(STILL, disc(-1.0 + k * DT, 1.0))
        both = [Measurement("laser", run.time, STILL, walker)]
        if k < 5:
            both.append(Measurement("camera", run.time, STILL, wall_points))
        run.go(STILL, *both)
    assert run.last.sources == ("laser",)
    assert run.last.tracks.moving[run.one_at(-1.0 + 39 * DT, 1.0)]


def test_nothing_seen_is_no_error_and_identities_are_never_used_twice():
    run = Run()
    run.see()
    run.see(disc(1.0, 1.0))
    first = set(run.last.tracks.id.tolist())
    run.tracker.reset()
    run.see(disc(1.0, 1.0))
    assert first and first.isdisjoint(run.last.tracks.id.tolist())


def test_the_robot_is_no_obstacle():
    corners = ((0.5, 0.3), (-0.5, 0.3), (-0.5, -0.3), (0.5, -0.3))
    run = Run(replace(P, footprint=corners))
    run.see(disc(0.2, 0.1), disc(1.5, 0.0))
    assert len(run.last.tracks) == 1


def test_a_new_track_is_told_of_after_some_observations():
    run = Run(replace(P, confirm_cycles=3))
    told = [bool(run.see(disc(1.0, 1.0)).confirmed[0]) for _ in range(3)]
    assert told == [False, False, True]


def test_nothing_that_is_seen_is_lost():
    """Every obstacle cell of a cluster belongs to a track after the cycle."""
    run, rng = Run(), np.random.default_rng(2)
    places = rng.uniform(-4, 4, (40, 2))
    for _ in range(30):
        places += rng.normal(0.0, 0.03, places.shape)
        run.see(*[disc(x, y) for x, y in places])
        snapshot = run.last
        cells = snapshot.grid.position
        gaps = np.hypot(*(cells[:, None] - snapshot.shapes.values).transpose(2, 0, 1)).min(axis=1)
        assert gaps.max() < 0.35


def look(run: Run, *boxes, pose=STILL):
    """As `see`, by a depth camera, noise of 2 cm in range."""
    T, points = camera(), cloud(camera(), *boxes, pose=pose)
    points *= 1.0 + run._rng.normal(0.0, 0.006, (len(points), 1)).astype(np.float32)
    obstacles = cloud_points(points, T, CAMERA)
    view = CloudView.of(points, T)
    return run.go(pose, Measurement("camera", run.time, pose, obstacles, view))


def test_a_camera_alone_knows_a_walker():
    run = Run()
    for k in range(60):
        y = -1.3 + 1.0 * k * DT
        look(run, body(3.0, y), body(2.2, -1.0, height=0.7))
    tracks = run.last.tracks
    assert tracks.moving[run.one_at(2.8, y)]
    assert not tracks.moving[run.at(2.0, -1.0)].any()
    assert run.at(2.0, -1.0)


@pytest.mark.parametrize("turn", [0.5, -0.8])
def test_of_what_comes_into_a_cameras_view_nothing_moves(turn):
    run = Run()
    things = [body(3.0, 1.0, height=0.8), body(2.5, -1.5, 0.8), body(3.5, -0.5, 1.0, 0.8, 0.6)]
    for k in range(100):
        look(run, *things, pose=(0.2 * k * DT, 0.0, turn * math.sin(1.2 * k * DT)))
        assert not run.last.tracks.moving.any()
