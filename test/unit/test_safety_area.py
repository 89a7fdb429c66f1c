"""The C++ scan merger against an independent ray-circle intersection, on any scan geometry."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from safe_passage import _safety_area as areas

any_speed = settings(deadline=None)  # no assertion on wall time
NO_RETURN = [math.nan, math.inf, -math.inf, 0.0, -1.0, 0.01, 1e6]


def _f32(value: float) -> float:
    return float(np.float32(value))


RANGE_MIN, RANGE_MAX = _f32(0.1), 30.0  # m


@st.composite
def scans(draw: st.DrawFn) -> areas.Scan:
    """Forward and reversed, partial, wrapped, more than a turn, starting anywhere."""
    beams = draw(st.integers(1, 400))
    turns = draw(st.floats(0.01, 3.0))
    sign = draw(st.sampled_from([-1.0, 1.0]))
    increment = _f32(sign * min(turns * 2 * math.pi / beams, 6.0))
    angle_min = _f32(draw(st.floats(-20.0, 20.0)))
    real = st.one_of(st.floats(RANGE_MIN, RANGE_MAX, width=32), st.sampled_from(NO_RETURN))
    few = draw(st.lists(real, min_size=1, max_size=8))
    ranges = np.resize(np.array(few, np.float32), beams)
    with_intensity = draw(st.booleans())
    return areas.Scan(
        ranges,
        angle_min,
        angle_min + (beams - 1) * increment,
        increment,
        RANGE_MIN,
        RANGE_MAX,
        np.arange(beams, dtype=np.float32) if with_intensity else np.empty(0, np.float32),
    )


coordinate = st.floats(-15.0, 15.0)
circle_lists = st.lists(st.tuples(coordinate, coordinate, st.floats(0.05, 4.0)), max_size=6)


def brute_force(scan: areas.Scan, circles: list, params: areas.MergeParameters) -> np.ndarray:
    """Per beam the nearest circle's range [m], +inf: none, NaN: too near a tangent to say."""
    angles = scan.angle_min + np.arange(len(scan.ranges)) * scan.angle_increment
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    nearest = np.full(len(angles), np.inf)
    for x, y, radius in circles:
        distance = math.hypot(x, y)
        inside = distance <= radius
        if params.inside_policy == areas.InsidePolicy.BLOCK and inside:
            nearest[:] = 0.0
            continue
        body = min(params.body_radius, radius, distance / 2)
        if params.inside_policy == areas.InsidePolicy.SHRINK:
            inside = distance <= radius + params.clearance
            body = max(distance - params.clearance, body)
        radius = body if inside else radius
        if distance == 0.0:
            continue
        # |t u - c|^2 = r^2: t^2 - 2 t (u . c) + |c|^2 - r^2 = 0
        half_b = rays @ np.array([x, y])
        discriminant = half_b**2 - (distance**2 - radius**2)
        hit = (discriminant > 0) & (half_b > 0)
        t = np.where(hit, half_b - np.sqrt(np.abs(discriminant)), np.inf)
        t[(np.abs(discriminant) < 1e-6) & (half_b > -1e-6)] = np.nan
        nearest = np.minimum(nearest, t)  # NaN spreads
    drawn = np.maximum(nearest, RANGE_MIN)
    return np.where(drawn > RANGE_MAX + 1e-4, np.inf, drawn)


def measured(ranges: np.ndarray) -> np.ndarray:
    """True where the sensor measured something."""
    low, high = np.float32(RANGE_MIN), np.float32(RANGE_MAX)
    return np.isfinite(ranges) & (ranges >= low) & (ranges <= high)


@st.composite
def parameters(draw: st.DrawFn) -> areas.MergeParameters:
    params = areas.MergeParameters()
    policies = list(areas.InsidePolicy.__members__.values())
    params.inside_policy = draw(st.sampled_from(policies))
    params.clearance = draw(st.floats(0.0, 1.0))
    params.body_radius = draw(st.floats(0.05, 0.5))
    params.intensity = 777.0
    return params


@any_speed
@given(scans(), circle_lists, parameters())
def test_circles_are_drawn_where_rays_meet_them(scan, circles, params):
    merged = areas.merge(scan, np.array(circles), params)
    expected = brute_force(scan, circles, params)
    known = ~np.isnan(expected) & (np.abs(expected - RANGE_MAX) > 1e-3)
    np.testing.assert_allclose(merged.safety_ranges[known], expected[known], rtol=1e-5, atol=1e-4)


@any_speed
@given(scans(), circle_lists, parameters())
def test_merged_range_is_the_nearer_of_measurement_and_circle(scan, circles, params):
    merged = areas.merge(scan, np.array(circles), params)
    real = measured(scan.ranges)
    assert np.all(merged.ranges[real] <= scan.ranges[real])
    expected = np.where(real, np.fmin(scan.ranges, merged.safety_ranges), merged.safety_ranges)
    drawn = np.isfinite(merged.safety_ranges)
    np.testing.assert_array_equal(merged.ranges[drawn], expected[drawn])


@any_speed
@given(scans(), circle_lists, parameters())
def test_beams_outside_every_circle_keep_every_bit(scan, circles, params):
    merged = areas.merge(scan, np.array(circles), params)
    outside = np.isinf(merged.safety_ranges)
    assert merged.ranges[outside].tobytes() == scan.ranges[outside].tobytes()
    if len(scan.intensities):
        assert merged.intensities[outside].tobytes() == scan.intensities[outside].tobytes()
        written = merged.ranges.view(np.uint32) != scan.ranges.view(np.uint32)
        assert np.all(merged.intensities[written] == 777.0)
        assert np.all(merged.intensities[~written] == scan.intensities[~written])
    else:
        assert len(merged.intensities) == 0


@any_speed
@given(scans(), circle_lists, parameters())
def test_every_drawn_range_is_one_a_costmap_accepts(scan, circles, params):
    drawn = areas.merge(scan, np.array(circles), params).safety_ranges
    drawn = drawn[np.isfinite(drawn)]
    assert np.all((drawn >= np.float32(RANGE_MIN)) & (drawn <= np.float32(RANGE_MAX)))


@any_speed
@given(scans(), circle_lists, parameters())
def test_order_of_circles_does_not_matter(scan, circles, params):
    forward = areas.merge(scan, np.array(circles), params)
    backward = areas.merge(scan, np.array(circles[::-1]), params)
    assert forward.ranges.tobytes() == backward.ranges.tobytes()


@any_speed
@given(scans(), circle_lists)
def test_reversing_the_scan_reverses_the_result(scan, circles):
    mirrored = areas.Scan(
        scan.ranges[::-1],
        scan.angle_min + (len(scan.ranges) - 1) * scan.angle_increment,
        scan.angle_min,
        -scan.angle_increment,
        RANGE_MIN,
        RANGE_MAX,
    )
    there = areas.merge(scan, np.array(circles)).safety_ranges
    back = areas.merge(mirrored, np.array(circles)).safety_ranges[::-1]
    same = np.isclose(there, back, rtol=1e-3, atol=1e-2)  # inf equals inf
    # A beam along a circle's tangent may touch it in one direction and miss it in the other: two
    # tangents a circle, on both sides of which rounding may fall, in up to three turns.
    assert np.sum(~same) <= 2 * 2 * 3 * len(circles)


@any_speed
@given(st.floats(0.0, 1.3), st.floats(-math.pi, math.pi))
def test_shrinking_never_traps_the_robot(distance, bearing):
    """A person may come as near as a touch: half of all directions and the clearance stay free."""
    params = areas.MergeParameters()
    angles = np.linspace(-math.pi, math.pi, 361)
    scan = areas.Scan(
        np.full(361, 10.0), -math.pi, math.pi, angles[1] - angles[0], RANGE_MIN, RANGE_MAX
    )
    circle = [distance * math.cos(bearing), distance * math.sin(bearing), 1.2]
    drawn = areas.merge(scan, np.array([circle]), params).safety_ranges
    away = np.cos(angles - bearing) < -1e-6
    assert np.all(np.isinf(drawn[away]))
    if distance >= params.clearance + params.body_radius:
        assert np.all(drawn >= params.clearance - 1e-5)
    if distance > 0.2:
        assert np.any(np.isfinite(drawn)), "the person must not vanish"


def to_rectangle(points):
    """[m] from points (N, 2) to ROBOT."""
    low, high = ROBOT.min(axis=0), ROBOT.max(axis=0)
    return np.linalg.norm(np.maximum(np.maximum(low - points, points - high), 0.0), axis=-1)


# An omni-directional robot, as a scanner on its front left corner has it.
ROBOT = np.array([[0.0, 0.0], [-1.2, 0.0], [-1.2, -0.72], [0.0, -0.72]])


@any_speed
@given(st.floats(-4.0, 3.0), st.floats(-3.0, 3.0), st.floats(0.3, 1.5), st.booleans())
def test_areas_are_cut_back_to_the_robots_outline(x, y, radius, turned):
    params = areas.MergeParameters()
    params.clearance = 0.1
    angles = np.linspace(-math.pi, math.pi, 721)
    empty = (np.full(721, 10.0), -math.pi, math.pi, angles[1] - angles[0], RANGE_MIN, RANGE_MAX)
    outline = ROBOT[::-1] if turned else ROBOT
    circle = np.array([[x, y, radius]])
    merged = areas.merge(areas.Scan(*empty), circle, params, outline)
    hit = np.isfinite(merged.safety_ranges)
    beams = np.stack([np.cos(angles), np.sin(angles)], axis=1)[hit]
    room = to_rectangle(np.array([x, y])) - params.clearance
    if radius < room - 1e-9:  # it does not reach the robot: nothing is taken from it
        assert merged.inside == 0
        assert np.abs(np.hypot(x, y) - merged.safety_ranges[hit].min() - radius) < 0.01
    elif room > params.body_radius:
        assert merged.inside == 1
        met = merged.safety_ranges[hit, None] * beams
        assert hit.any() and to_rectangle(met).min() > params.clearance - 1e-4
        assert np.abs(np.hypot(*(met - (x, y)).T) - room).max() < 1e-3  # no more than it must
    else:
        assert merged.inside == 1  # the person touches the robot: the body stays


def test_without_an_outline_the_robot_is_where_the_laser_is():
    scan = areas.Scan(np.full(181, 10.0), -1.57, 1.57, 3.14 / 180, RANGE_MIN, RANGE_MAX)
    circle, params = np.array([[1.2, 0.0, 1.2]]), areas.MergeParameters()
    plain = areas.merge(scan, circle, params).safety_ranges
    assert plain.min() == pytest.approx(params.clearance, abs=1e-6)
    around = [[0.5, 0.3], [-0.5, 0.3], [-0.5, -0.3], [0.5, -0.3]]  # 0.5 m before the laser
    drawn = areas.merge(scan, circle, params, around).safety_ranges
    assert drawn.min() == pytest.approx(0.5 + params.clearance, abs=1e-6)


@any_speed
@given(
    st.lists(
        st.tuples(*[st.floats(allow_nan=True, allow_infinity=True, width=32)] * 3), max_size=5
    ),
    scans(),
)
def test_any_circle_at_all_is_survived(circles, scan):
    merged = areas.merge(scan, np.array(circles))
    real = measured(scan.ranges)
    assert np.all(merged.ranges[real] <= scan.ranges[real])


@any_speed
@given(
    *[st.floats(allow_nan=True, allow_infinity=True, width=32)] * 5,
    st.lists(st.floats(width=32), max_size=20),
)
def test_any_scan_at_all_is_survived(angle_min, angle_max, increment, low, high, ranges):
    scan = areas.Scan(np.array(ranges, np.float32), angle_min, angle_max, increment, low, high)
    merged = areas.merge(scan, np.array([[2.0, 1.0, 1.2]]))
    assert len(merged.ranges) == len(merged.safety_ranges) == len(ranges)
    if merged.fault in (areas.ScanFault.EMPTY, areas.ScanFault.BAD_GEOMETRY):
        assert merged.ranges.tobytes() == scan.ranges.tobytes()


@any_speed
@given(
    st.floats(0.3, 10.0),
    st.floats(-math.pi, math.pi),
    st.floats(0.0, 0.2),
    st.floats(-1.0, 1.0),
    st.floats(-1.0, 1.0),
    st.floats(-math.pi, math.pi),
)
def test_a_late_pose_still_covers_the_person(distance, bearing, age, speed, turn_rate, heading):
    """Wherever the robot has driven since, the widened circle contains the true one."""
    person = np.array([distance * math.cos(bearing), distance * math.sin(bearing), 0.0])
    params = areas.AreaParameters()
    params.max_growth = 10.0
    (old,) = areas.safety_areas(
        [areas.Person(0.0, person)], 0.0, areas.LaserPose(np.eye(4), age), params
    )
    moved = person[:2] - speed * age * np.array([math.cos(heading), math.sin(heading)])
    turn = -turn_rate * age
    rotation = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    gap = np.linalg.norm(rotation @ moved - old[:2])
    # Turning moves the point by its distance after driving: a second-order surplus.
    assert gap + params.radius <= old[2] + age**2 + 1e-9


@any_speed
@given(scans(), st.lists(st.tuples(*[st.floats(-6.0, 6.0)] * 4), max_size=3), parameters(),
       st.floats(0.0, 2.0))  # fmt: skip
def test_a_stretched_area_makes_no_range_longer_and_holds_the_round_one(
    scan, people, params, ahead
):
    stretch = areas.AreaParameters()
    stretch.velocity_stretch = ahead
    pose, persons = areas.LaserPose(np.eye(4)), []
    for x, y, vx, vy in people:
        persons.append(areas.Person(0.0, [x, y, 0.0], [vx, vy, 0.0]))
    merged = []
    for area in (areas.AreaParameters(), stretch):
        pipeline = areas.PipelineParameters()
        pipeline.area, pipeline.merge = area, params
        chain = areas.Pipeline(pipeline)
        chain.remember(persons)
        merged.append(np.asarray(chain.merge(scan, 0.0, pose).scan.safety_ranges))
    assert np.all(merged[1] <= merged[0])


@any_speed
@given(*[st.floats(-3.0, 3.0)] * 2, st.floats(0.0, 3.0), st.floats(0.0, 1.0))
def test_a_stretched_area_covers_the_way_ahead(vx, vy, stretch, share):
    """Along it a margin of 2 % at most is missing on both sides."""
    params = areas.AreaParameters()
    params.velocity_stretch = stretch
    person = areas.Person(0.0, [5.0, 1.0, 0.0], [vx, vy, 0.0])
    rows = areas.safety_areas([person], 0.0, areas.LaserPose(np.eye(4)), params)
    velocity = np.array([vx, vy])
    middle = np.array([5.0, 1.0]) + share * stretch * velocity
    across = np.array([-vy, vx]) / max(np.hypot(vx, vy), 1e-9)
    for side in (-1.0, 1.0):
        point = middle + side * 0.98 * params.radius * across
        assert (np.hypot(*(rows[:, :2] - point).T) <= rows[:, 2] + 1e-6).any()


detections = st.lists(
    st.tuples(
        st.floats(0.0, 5.0),  # s between arrays
        st.lists(st.tuples(coordinate, coordinate, st.integers(0, 3)), max_size=5),
    ),
    max_size=8,
)


@any_speed
@given(detections)
def test_memory_holds_the_latest_detections_and_nothing_old(arrays):
    memory, time = areas.PersonMemory(), 100.0
    for pause, seen in arrays:
        time += pause
        memory.update([areas.Person(time, [x, y, 0.0], id=id) for x, y, id in seen])
        held = memory.at(time)
        assert all(time - person.stamp <= 1.0 for person in held)
        for x, y, _ in seen:
            assert any(np.allclose(person.position, [x, y, 0.0]) for person in held)
    assert memory.at(time + 1.001) == []


@any_speed
@given(st.permutations(range(6)))
def test_memory_ends_the_same_for_any_order_of_arrival(order):
    memory = areas.PersonMemory()
    for step in order:
        memory.update([areas.Person(10.0 + 0.1 * step, [1.0 + 0.05 * step, 0.0, 0.0], id=4)])
    (person,) = memory.at(10.5)
    assert person.stamp == pytest.approx(10.5)


def test_wrong_shapes_are_refused():
    scan = areas.Scan(np.ones(3), 0.0, 0.2, 0.1, RANGE_MIN, RANGE_MAX)
    with pytest.raises(ValueError, match="circles"):
        areas.merge(scan, np.ones((2, 2)))
    with pytest.raises(ValueError, match="shape"):
        areas.Scan(np.ones((3, 3)), 0.0, 0.2, 0.1, RANGE_MIN, RANGE_MAX)
