from __future__ import annotations

import math

import numpy as np
import pytest
from costmap_scene import HERE, SCAN, make_costmap, seen
from hypothesis import given, settings
from hypothesis import strategies as st
from safe_passage.costmap import FootprintParameters

LETHAL, FREE, UNKNOWN = 254, 0, 255


def lethal_cells(update):
    return [tuple(cell) for cell in np.argwhere(update.costs == LETHAL)]


def test_one_ray_to_a_wall():
    costmap = make_costmap(
        layer={"track_unknown_space": True, "footprint_clearing_enabled": False},
        track_unknown_space=True,
    )
    update = costmap.update(HERE, {SCAN: [seen((0.55, 0.05, 0.2))]}, now=0.0)
    # sensor in cell (10, 10), wall five cells ahead
    assert update.costs[10, 9:17].tolist() == [255, 0, 0, 0, 0, 0, 254, 255]
    assert (update.costs != UNKNOWN).sum() == 6


def test_a_longer_ray_clears_what_a_shorter_one_marked():
    costmap = make_costmap()
    costmap.update(HERE, {SCAN: [seen((0.55, 0.05, 0.2))]}, now=0.0)
    update = costmap.update(HERE, {SCAN: [seen((0.95, 0.05, 0.2))]}, now=0.1)
    assert lethal_cells(update) == [(10, 19)]


def test_rays_leaving_the_window_clear_up_to_its_edge():
    costmap = make_costmap(source={"obstacle_range": 5.0, "raytrace_range": 6.0})
    edge = [(0.95, 0.05, 0.2), (-0.95, 0.05, 0.2), (0.05, 0.95, 0.2), (0.05, -0.95, 0.2)]
    assert len(lethal_cells(costmap.update(HERE, {SCAN: [seen(*edge)]}, now=0.0))) == 4
    far = [(4.0, 0.05, 0.2), (-4.0, 0.05, 0.2), (0.05, 4.0, 0.2), (0.05, -4.0, 0.2)]
    assert not lethal_cells(costmap.update(HERE, {SCAN: [seen(*far)]}, now=0.1))


def test_marks_below_obstacle_range_and_clears_up_to_raytrace_range():
    costmap = make_costmap(source={"obstacle_range": 0.6, "raytrace_range": 0.3})
    costmap.update(HERE, {SCAN: [seen((0.35, 0.05, 0.2), (0.55, 0.05, 0.2))]}, now=0.0)
    update = costmap.update(HERE, {SCAN: [seen((0.75, 0.05, 0.2))]}, now=0.1)
    assert lethal_cells(update) == [(10, 15)]  # 0.75 is too far to mark, 0.55 too far to clear


def test_a_source_may_only_mark_or_only_clear():
    marks = make_costmap(source={"clearing": False})
    marks.update(HERE, {SCAN: [seen((0.55, 0.05, 0.2))]}, now=0.0)
    update = marks.update(HERE, {SCAN: [seen((0.95, 0.05, 0.2))]}, now=0.1)
    assert lethal_cells(update) == [(10, 15), (10, 19)]
    clears = make_costmap(source={"marking": False})
    assert not lethal_cells(clears.update(HERE, {SCAN: [seen((0.55, 0.05, 0.2))]}, now=0.0))


def test_points_outside_the_height_band_neither_mark_nor_clear():
    costmap = make_costmap(source={"min_obstacle_height": 0.1, "max_obstacle_height": 1.0})
    costmap.update(HERE, {SCAN: [seen((0.55, 0.05, 0.2))]}, now=0.0)
    update = costmap.update(HERE, {SCAN: [seen((0.95, 0.05, 1.1), (0.95, 0.05, 0.0))]}, now=0.1)
    assert lethal_cells(update) == [(10, 15)]


def test_points_above_the_layers_height_clear_only():
    costmap = make_costmap(layer={"max_obstacle_height": 1.0})
    costmap.update(HERE, {SCAN: [seen((0.55, 0.05, 0.2))]}, now=0.0)
    assert not lethal_cells(costmap.update(HERE, {SCAN: [seen((0.95, 0.05, 1.5))]}, now=0.1))


def test_footprint_is_free():
    square = FootprintParameters(((0.15, 0.15), (0.15, -0.15), (-0.15, -0.15), (-0.15, 0.15)), 0, 0)
    points = seen((0.15, 0.15, 0.2), (0.55, 0.05, 0.2))
    update = make_costmap(footprint=square).update(HERE, {SCAN: [points]}, now=0.0)
    assert lethal_cells(update) == [(10, 15)]
    kept = make_costmap(footprint=square, layer={"footprint_clearing_enabled": False})
    assert len(lethal_cells(kept.update(HERE, {SCAN: [points]}, now=0.0))) == 2


def test_obstacle_keeps_its_place_while_the_window_rolls():
    costmap = make_costmap(rolling_window=True)
    costmap.update(HERE, {SCAN: [seen((0.55, 0.05, 0.2))]}, now=0.0)
    update = costmap.update((0.35, 0.05, 0.0), {SCAN: [seen(origin=(0.35, 0.05, 0.2))]}, now=0.1)
    (row, column), = lethal_cells(update)  # fmt: skip
    assert update.origin[0] + (column + 0.5) * 0.1 == pytest.approx(0.55)
    assert update.origin[1] + (row + 0.5) * 0.1 == pytest.approx(0.05)


def test_observations_persist_as_long_as_told():
    costmap = make_costmap(source={"observation_persistence": 1.0, "clearing": False})
    old, new = seen((0.55, 0.05, 0.2), stamp=0.0), seen((0.95, 0.05, 0.2), stamp=0.9)
    costmap.update(HERE, {SCAN: [old]}, now=0.0)
    costmap.update(HERE, {SCAN: [new]}, now=0.9)
    costmap._layers[0].grid.cells.fill(FREE)  # only what is remembered marks again
    assert len(lethal_cells(costmap.update(HERE, {}, now=0.9))) == 2
    costmap.update(HERE, {SCAN: [seen((0.05, 0.55, 0.2), stamp=1.5)]}, now=1.5)
    costmap._layers[0].grid.cells.fill(FREE)
    assert lethal_cells(costmap.update(HERE, {}, now=1.5)) == [(10, 19), (15, 10)]


def test_unknown_space_stays_unknown_until_seen():
    costmap = make_costmap(layer={"track_unknown_space": True}, track_unknown_space=True)
    update = costmap.update(HERE, {SCAN: [seen((0.55, 0.05, 0.2))]}, now=0.0)
    assert update.costs[0, 0] == UNKNOWN
    assert update.costs[10, 12] == FREE


@pytest.mark.parametrize("method, lethal", [(0, 1), (1, 1), (99, 0)])
def test_combination_methods(method, lethal):
    costmap = make_costmap(layer={"combination_method": method})
    update = costmap.update(HERE, {SCAN: [seen((0.55, 0.05, 0.2))]}, now=0.0)
    assert len(lethal_cells(update)) == lethal


def test_a_disabled_layer_does_nothing():
    costmap = make_costmap(layer={"enabled": False})
    with pytest.raises(KeyError):
        costmap.update(HERE, {SCAN: [seen((0.55, 0.05, 0.2))]}, now=0.0)
    assert not costmap.update(HERE, {}, now=0.0).costs.any()


def test_reset_forgets_observations_and_costs():
    costmap = make_costmap()
    costmap.update(HERE, {SCAN: [seen((0.55, 0.05, 0.2))]}, now=5.0)
    costmap.reset()
    assert not costmap.update(HERE, {}, now=0.0).costs.any()


def test_sensor_outside_the_window_marks_but_does_not_clear():
    costmap = make_costmap(source={"obstacle_range": 9.0})
    costmap.update(HERE, {SCAN: [seen((0.55, 0.05, 0.2))]}, now=0.0)
    outside = seen((0.95, 0.05, 0.2), origin=(-3.0, 0.05, 0.2))
    update = costmap.update(HERE, {SCAN: [outside]}, now=0.1)
    assert lethal_cells(update) == [(10, 15), (10, 19)]


def test_a_pose_that_is_not_finite_is_refused():
    with pytest.raises(ValueError, match="finite"):
        make_costmap().update((math.nan, 0.0, 0.0), {}, now=0.0)


anything = st.floats(width=32)


@settings(max_examples=60, deadline=None)
@given(
    points=st.lists(st.tuples(anything, anything, anything), max_size=15),
    origin=st.tuples(*[st.floats(-3, 3)] * 3),
    pose=st.tuples(*[st.floats(-3, 3)] * 3),
)
def test_any_points_are_survived(points, origin, pose):
    costmap = make_costmap(
        source={"max_obstacle_height": 1e3, "min_obstacle_height": -1e3}, rolling_window=True
    )
    update = costmap.update(pose, {SCAN: [seen(*points, origin=origin)]}, now=0.0)
    assert update.costs.shape == (20, 20)
    assert set(np.unique(update.costs)) <= {FREE, LETHAL}


inside = st.floats(-0.99, 0.99)


@settings(max_examples=60, deadline=None)
@given(points=st.lists(st.tuples(inside, inside, st.just(0.2)), min_size=1, max_size=15))
def test_a_marked_cell_stays_unless_cleared(points):
    costmap = make_costmap(layer={"footprint_clearing_enabled": False})
    before = lethal_cells(costmap.update(HERE, {SCAN: [seen(*points)]}, now=0.0))
    after = lethal_cells(costmap.update(HERE, {SCAN: [seen()]}, now=0.1))
    assert before and after == before
