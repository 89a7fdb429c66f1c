"""What sensors see around a robot, against what geometry says."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.coverage.field import BANDS, Body, bodies_of, cover
from safe_passage.coverage.report import as_markdown, draw, summary
from safe_passage.simulation.robots import make_robot

FEET, KNEES, HIPS, HEAD = range(len(BANDS))


def robot(lidars=(), cameras=(), parts=()):
    return make_robot(
        {
            "name": "tested",
            "footprint": [[0.3, 0.2], [-0.3, 0.2], [-0.3, -0.2], [0.3, -0.2]],
            "height": 1.0,
            "drive": {},
            "lidars": list(lidars),
            "cameras": list(cameras),
            "parts": list(parts),
        }
    )


def seen(one, radius=3.0):
    return cover(one, bodies_of(one), radius)


def degrees(sectors):
    return [tuple(round(math.degrees(edge)) for edge in sector) for sector in sectors]


def test_a_scanner_of_270_degrees_is_blind_behind_and_above():
    found = seen(robot([{"name": "laser", "z": 0.15}]))
    (start, end), *more = found.blind_sectors(FEET, 1.5)
    assert not more
    assert math.degrees(start) == pytest.approx(135.0, abs=4.0)  # a cell is 10 cm
    assert math.degrees(end) == pytest.approx(-135.0 + 360.0, abs=4.0) or math.degrees(
        end
    ) == pytest.approx(-135.0, abs=4.0)
    assert found.share(FEET, 2.0) == pytest.approx(0.75, abs=0.03)
    assert found.blind_sectors(HEAD, 1.5) == [(-math.pi, math.pi)]


def test_two_scanners_at_opposite_corners_see_all_around():
    corners = [
        {"name": "front", "x": 0.35, "y": 0.25, "z": 0.15, "yaw": math.pi / 4},
        {"name": "rear", "x": -0.35, "y": -0.25, "z": 0.15, "yaw": -3 * math.pi / 4},
    ]
    found = seen(robot(corners))
    assert found.blind_sectors(FEET, 1.5) == []
    assert found.share(FEET, 2.0) > 0.99  # but for the cells that they stand in
    corner = (math.pi + 2.0 * (0.35 + 0.25) + 0.35 * 0.25) / (4.0 * math.pi)  # blind of each
    assert found.share(FEET, 2.0, 2) == pytest.approx(1.0 - 2.0 * corner, abs=0.08)


def test_a_level_camera_sees_its_cone():
    camera = {"name": "camera", "z": 1.0, "range_max": 10.0, "focal": 320.0}
    found = seen(robot(cameras=[camera]))
    x, y = np.moveaxis(found.middles, -1, 0)
    half = math.atan(319.5 / 320.0)
    inside = (np.abs(np.arctan2(y, x)) < half - 0.1) & (x > 0.8)
    outside = np.abs(np.arctan2(y, x)) > half + 0.1
    assert found.count[HIPS][inside].all() and not found.count[HIPS][outside].any()
    assert not found.count[FEET][(x < 0.9)].any()  # under the picture


def test_what_stands_before_a_sensor_hides_what_is_behind_it():
    post = {"x": 1.0, "z": 0.0, "size": [0.2, 0.2, 0.5]}
    found = seen(robot([{"name": "laser", "z": 0.15}], parts=[post]))
    ((start, end),) = (one for one in degrees(found.blind_sectors(FEET, 2.0)) if abs(one[0]) < 90)
    assert -9 <= start <= -4 and 4 <= end <= 9  # 0.1 m to both sides, at 0.9 m
    assert 0.01 < found.hidden[0] < 0.1


def test_a_sensors_own_housing_hides_nothing():
    housing = {"x": 0.0, "z": 0.1, "size": [0.1, 0.1, 0.1]}
    assert seen(robot([{"name": "laser", "z": 0.15}], parts=[housing])).hidden[0] == 0.0


@given(
    x=st.floats(0.5, 2.0), side=st.floats(0.05, 0.6), bearing=st.floats(-3.0, 3.0)
)  # fmt: skip
def test_a_body_hides_only_what_is_farther_in_its_directions(x, side, bearing):
    T = np.eye(4)
    T[:2, 3] = x * math.cos(bearing), x * math.sin(bearing)
    half = np.full(3, 0.5 * side)
    way = np.array([math.cos(bearing), math.sin(bearing), 0.0])
    points = np.outer([0.5 * (x - side), x + side, -1.0], way)
    hidden = Body(T, -half, half).hides(np.zeros(3), points)
    if x - 0.5 * side > 0.06:
        assert hidden.tolist() == [False, True, False]


def test_without_sensors_all_is_blind():
    found = seen(robot())
    assert found.blind_sectors(FEET, 1.5) == [(-math.pi, math.pi)]
    assert found.share(FEET, 2.0) == 0.0


def test_the_report_is_json_a_table_and_a_picture(tmp_path):
    one = robot([{"name": "laser", "z": 0.15}])
    found = seen(one)
    figures = summary(found)
    assert json.loads(json.dumps(figures)) == figures
    text = as_markdown(one.name, figures)
    assert "all around" in text and "laser" in text
    draw(one, found, tmp_path / "coverage.png")
    assert (tmp_path / "coverage.png").stat().st_size > 5000
