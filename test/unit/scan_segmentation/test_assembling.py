"""Scan lines put together: equations 1 to 3 at each beam's own angle; what breaks a sweep."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from safe_passage.core.errors import ParameterError
from safe_passage.scan_segmentation.assembling import (
    MOUNT,
    AssemblingParameters,
    Line,
    ScanAssembler,
    Step,
)
from safe_passage.scan_segmentation.scan import to_cartesian

ALPHA = np.radians(np.arange(-90.0, 90.5, 0.5))  # the LMS200's
PERIOD = 1.0 / 37.5  # s


def line(number, step, start=0.0, within=0.0, reach=3.0):
    """Line `number` of a platform that turns by `step` [rad] a line, `within` of it in a line."""
    beta = start + number * step + within * step * np.linspace(0.0, 1.0, len(ALPHA))
    wrapped = (beta + math.pi) % (2 * math.pi) - math.pi  # as encoders report it
    ranges = reach + 0.5 * np.cos(3.0 * ALPHA)
    return Line(number * PERIOD, ALPHA, ranges, 10.0 + ALPHA, wrapped)


def assembled(lines, parameters=None):
    """Steps, and the sweeps that came out."""
    assembler = ScanAssembler(parameters)
    answers = [assembler.add(one) for one in lines]
    return [step for step, _ in answers], [done for _, done in answers if done is not None]


@settings(max_examples=30, deadline=None)
@given(
    st.integers(20, 300),
    st.floats(-7.0, 7.0),
    st.sampled_from([1.0, -1.0]),
    st.floats(0.0, 0.9),
)
def test_a_turn_is_one_cloud_as_the_equations_say(count, start, direction, within):
    p = AssemblingParameters(max_step=0.5)
    step = direction * 2.0 * math.pi / count
    _, done = assembled([line(i, step, start, within) for i in range(2 * count + 1)], p)
    assert len(done) == 2
    scan = done[0].scan
    half = (ALPHA >= -1e-9) & (0.5 * math.pi - 1e-3 > ALPHA)
    assert scan.points.shape == (count, half.sum(), 3)
    for i in (0, count // 2, count - 1):
        one = line(i, step, start, within)
        for column, k in enumerate(np.nonzero(half)[0][::40]):
            exact = to_cartesian(one.ranges[None, [k]], ALPHA[[k]], one.beta[[k]])[0, 0]
            np.testing.assert_allclose(scan.points[i, 40 * column], exact, atol=1e-5)
    steps = np.diff(scan.beta)
    np.testing.assert_allclose(steps, step, atol=1e-9)


def test_lines_that_come_twice_are_taken_once():
    once = [line(i, 0.1, within=0.5) for i in range(70)]
    _, (expected,) = assembled(once)
    _, (done,) = assembled([one for one in once for _ in range(2)])
    np.testing.assert_array_equal(done.scan.points, expected.scan.points)


def test_the_papers_sizes():
    for count in (80, 430):
        _, done = assembled([line(i, 2.0 * math.pi / count) for i in range(count + 1)])
        assert done[0].scan.points.shape[:2] == (count, 180)
        np.testing.assert_allclose(done[0].scan.remission[0], 10.0 + ALPHA[180:-1])


def test_half_a_turn_with_whole_lines_sees_all_around():
    p = AssemblingParameters(math.pi, -0.5 * math.pi, 0.51 * math.pi)
    _, done = assembled([line(i, math.pi / 100) for i in range(101)], p)
    assert done[0].scan.points.shape == (100, 361, 3)


def test_no_return_is_nan():
    lost = [replace(line(i, 0.1), ranges=np.full(len(ALPHA), np.inf)) for i in range(64)]
    _, done = assembled(lost)
    assert np.isnan(done[0].scan.points).all()


def test_a_scanner_beside_the_axis_sees_the_same_wall():
    mount = MOUNT.copy()
    mount[:3, 3] = 0.1, 0.02, 0.05
    beta = 0.3
    c, s = math.cos(beta), math.sin(beta)
    one = Line(0.0, np.zeros(1), np.array([2.0]), None, np.array([beta]), mount)
    x, y = 2.1, 0.02
    np.testing.assert_allclose(one.points()[0], (c * x - s * y, s * x + c * y, 0.05))


def test_a_scanner_that_stands_still_fills_no_memory():
    assembler = ScanAssembler()
    steps = [assembler.add(replace(line(0, 0.1), stamp=i * PERIOD))[0] for i in range(3000)]
    assert len(assembler) == 1
    assert steps[1] is Step.STANDING
    assert Step.PAUSED in steps


def test_one_that_turns_slowly_is_thinned_out():
    p = AssemblingParameters(max_lines=100)
    _, done = assembled([line(i, 2.0 * math.pi / 1000) for i in range(1010)], p)
    assert 80 <= done[0].scan.points.shape[0] <= 100


@pytest.mark.parametrize(
    ("broken", "why"),
    [
        (lambda one: replace(one, beta=one.beta + 0.5), Step.GAP),
        (lambda one: replace(one, stamp=one.stamp + 5.0), Step.PAUSED),
        (lambda one: replace(one, stamp=0.0), Step.PAUSED),
        (lambda one: replace(one, beta=one.beta - 0.2), Step.REVERSED),
        (lambda one: replace(one, alpha=one.alpha + 0.01), Step.CHANGED),
        (lambda one: one.used(0.0, 1.0), Step.CHANGED),
    ],
)
def test_what_breaks_a_sweep_is_told_and_a_new_one_begins(broken, why):
    assembler = ScanAssembler()
    for i in range(20):
        assert assembler.add(line(i, 0.1))[0] is Step.TAKEN
    step, done = assembler.add(broken(line(20, 0.1)))
    assert (step, done, len(assembler)) == (why, None, 1)


def test_lines_without_the_beams_that_are_used():
    assembler = ScanAssembler()
    step, _ = assembler.add(line(0, 0.1).used(-1.0, -0.5))
    assert (step, len(assembler)) == (Step.NO_BEAMS, 0)


@pytest.mark.parametrize(
    "wrong", [{"sweep": 7.0}, {"max_lines": 2}, {"alpha_min": 2.0}, {"max_pause": math.nan}]
)
def test_wrong_parameters_are_refused(wrong):
    with pytest.raises(ParameterError):
        AssemblingParameters(**wrong)
