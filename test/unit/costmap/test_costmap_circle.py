"""A person's safety circle comes and goes with the person, also among beams without return."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from safe_passage.costmap import (
    LocalCostmap,
    Observation,
    load_costmap_parameters,
    project_scan,
    transform_points,
    yaw_quaternion,
)

BEAMS, ANGLE_MIN, INCREMENT = 1081, -2.356194, 0.00436332
RADIUS = 1.2  # m
LETHAL = 254


def costmap(inf_is_valid=True):
    scan = {
        "data_type": "LaserScan", "clearing": True, "marking": True, "inf_is_valid": inf_is_valid,
        "obstacle_range": 5.0, "raytrace_range": 6.0,
    }  # fmt: skip
    parameters = {
        "rolling_window": True, "width": 8, "height": 8, "resolution": 0.05,
        "plugins": [
            {"name": "obstacle_layer", "type": "costmap_2d::ObstacleLayer"},
            {"name": "inflation_layer", "type": "costmap_2d::InflationLayer"},
        ],
        "obstacle_layer": {"observation_sources": "scan", "scan": scan},
        "inflation_layer": {"inflation_radius": 0.05},
    }  # fmt: skip
    return LocalCostmap(load_costmap_parameters(parameters).parameters), inf_is_valid


def scan_with_circle(distance, bearing, behind):
    """Ranges to the near side of a circle; `behind` where it is not seen."""
    angles = ANGLE_MIN + np.arange(BEAMS) * INCREMENT - bearing
    offset = distance * np.sin(angles)
    seen = (np.abs(offset) < RADIUS) & (np.cos(angles) > 0)
    depth = np.sqrt(np.where(seen, RADIUS**2 - offset**2, 0.0))
    return np.where(seen, np.minimum(distance * np.cos(angles) - depth, behind), behind)


def update(both, ranges, pose=(0.0, 0.0, 0.0)):
    local, inf_is_valid = both
    points = project_scan(ranges, ANGLE_MIN, INCREMENT, 0.05, 20.0, inf_is_valid)
    origin = (pose[0], pose[1], 0.12)
    points = transform_points(points, origin, yaw_quaternion(pose[2]))
    seen = {("obstacle_layer", "scan"): [Observation(0.0, origin, points)]}
    return local.update(pose, seen, now=0.0), points


open_space = np.full(BEAMS, np.inf)
room = np.full(BEAMS, 3.5)


def cells_of(points, local_update):
    columns = np.floor((points[:, 0] - local_update.origin[0]) / 0.05).astype(int)
    rows = np.floor((points[:, 1] - local_update.origin[1]) / 0.05).astype(int)
    inside = (columns >= 0) & (columns < 160) & (rows >= 0) & (rows < 160)
    return rows[inside], columns[inside]


@settings(max_examples=40, deadline=None)
@given(
    distance=st.floats(1.8, 4.0),  # nearer ones reach the footprint, which is always free
    bearing=st.floats(-2.2, 2.2),
    behind=st.sampled_from([open_space, room]),
)
def test_appears_whole_within_one_update_and_is_gone_within_one(distance, bearing, behind):
    both = costmap()
    empty = update(both, behind)[0].costs.copy()
    ranges = scan_with_circle(distance, bearing, behind)
    with_person, points = update(both, ranges)
    hits = cells_of(points[ranges < behind], with_person)
    assert len(hits[0]) and (with_person.costs[hits] == LETHAL).all()
    after, _ = update(both, behind)
    assert np.argwhere(after.costs != empty).tolist() == []


def test_leaves_a_trail_only_where_it_hides_it():
    both = costmap()
    for bearing in np.linspace(-1.5, 1.5, 31):
        ranges = scan_with_circle(3.0, bearing, open_space)
        trail = update(both, ranges)[0]
        alone = update(costmap(), ranges)[0]
        rows, columns = np.nonzero((trail.costs == LETHAL) & (alone.costs != LETHAL))
        x = trail.origin[0] + (columns + 0.5) * 0.05
        y = trail.origin[1] + (rows + 0.5) * 0.05
        beam = np.round((np.arctan2(y, x) - ANGLE_MIN) / INCREMENT).astype(int)
        assert (np.hypot(x, y) > ranges[beam] - 0.05).all()
    assert not (update(both, open_space)[0].costs == LETHAL).any()


def test_is_gone_although_the_robot_turned_meanwhile():
    both = costmap()
    update(both, scan_with_circle(2.5, 0.0, open_space))
    after, _ = update(both, open_space, pose=(0.02, 0.01, 0.1))
    assert not (after.costs == LETHAL).any()


@pytest.mark.parametrize("inf_is_valid, ghost", [(True, False), (False, True)])
def test_the_ghost_of_beams_that_do_not_clear(inf_is_valid, ghost):
    both = costmap(inf_is_valid)
    update(both, scan_with_circle(2.5, 0.0, open_space))
    after, _ = update(both, open_space)
    assert (after.costs == LETHAL).any() == ghost
