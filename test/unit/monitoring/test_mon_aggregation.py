import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.core.geometry import compose, inverse
from safe_passage.monitoring.aggregation import Aggregator, Measurement
from safe_passage.monitoring.parameters import SourceParameters

STILL = (0.0, 0.0, 0.0)


def measured(source: str, stamp: float, pose=STILL, points=((1.0, 0.0, 0.0),)) -> Measurement:
    return Measurement(source, stamp, pose, np.array(points, float).reshape(-1, 3))


@given(st.tuples(*[st.floats(-5, 5)] * 3), st.tuples(*[st.floats(-5, 5)] * 3), st.floats(-9, 9))
def test_a_place_stays_where_it_is_however_the_robot_drives(before, now, x):
    place = (x, 2.0)
    seen = compose(inverse(before), (*place, 0.0))
    aggregator = Aggregator([SourceParameters("laser")])
    aggregator.add(measured("laser", 0.0, before, [(seen[0], seen[1], 0.3)]))
    expected = compose(inverse(now), (*place, 0.0))
    assert aggregator.points(0.1, now).xyz[0] == pytest.approx([*expected[:2], 0.3], abs=1e-4)


def test_the_last_measurements_of_each_source_are_put_together():
    aggregator = Aggregator([SourceParameters("a", aggregate=2), SourceParameters("b")])
    for stamp in (0.0, 0.1, 0.2):
        aggregator.add(measured("a", stamp))
    aggregator.add(measured("b", 0.15))
    points = aggregator.points(0.2, STILL)
    assert points.sensor.tolist() == [0, 0, 1]
    assert points.age == pytest.approx([0.1, 0.0, 0.05], abs=1e-6)


def test_a_silent_sensor_is_dropped_and_the_others_go_on():
    aggregator = Aggregator([SourceParameters("a", timeout=0.5), SourceParameters("b")])
    aggregator.add(measured("a", 0.0))
    aggregator.add(measured("b", 0.6))
    assert aggregator.points(0.6, STILL).sensor.tolist() == [1]
    assert aggregator.alive() == ("b",)


def test_what_comes_late_or_twice_is_ignored():
    aggregator = Aggregator([SourceParameters("a")])
    aggregator.add(measured("a", 0.1))
    aggregator.add(measured("a", 0.1))
    aggregator.add(measured("a", 0.05))
    assert len(aggregator.points(0.1, STILL).xyz) == 1


def test_an_empty_measurement_says_that_nothing_is_there():
    aggregator = Aggregator([SourceParameters("a", aggregate=1)])
    aggregator.add(measured("a", 0.0))
    aggregator.add(measured("a", 0.1, points=()))
    assert len(aggregator.points(0.1, STILL).xyz) == 0
    assert aggregator.alive() == ("a",)


def test_nothing_at_all():
    points = Aggregator([]).points(0.0, STILL)
    assert points.xyz.shape == (0, 3)
    assert math.isfinite(points.age.sum())
