import math

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st
from safe_passage.core.geometry import compose, inverse, rotation
from safe_passage.monitoring.motion import (
    move_frame,
    predict,
    process_noise,
    squared_mahalanobis,
    transition,
    update,
)


def random_tracks(seed: int, count: int = 7):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(count, 4, 4))
    return rng, rng.normal(size=(count, 4)), root @ root.transpose(0, 2, 1) + 0.1 * np.eye(4)


def random_covariances(rng, count: int):
    root = rng.normal(size=(count, 2, 2))
    return root @ root.transpose(0, 2, 1) + 0.01 * np.eye(2)


def test_noise_along_one_axis_is_that_axis_alone():
    Q = process_noise(0.5, np.diag([0.6, 0.0])[None])[0]
    assert Q[1] == pytest.approx(np.zeros(4)) and Q[3] == pytest.approx(np.zeros(4))
    assert Q[[0, 0, 2], [0, 2, 2]] == pytest.approx(0.6 * np.array([0.5**3 / 3, 0.5**2 / 2, 0.5]))


@settings(max_examples=30)
@given(st.integers(0, 10**6), st.floats(0.001, 2.0), st.floats(0.0, 0.5))
def test_many_filters_at_once_agree_with_filterpy(seed, dt, age):
    rng, x, P = random_tracks(seed)
    R, agility = random_covariances(rng, len(x)), random_covariances(rng, len(x))
    z = rng.normal(size=(len(x), 2))
    x1, P1 = predict(x, P, dt, agility)
    x2, P2 = update(x1, P1, z, R, np.full(len(x), age))
    for i in range(len(x)):
        one = KalmanFilter(dim_x=4, dim_z=2)
        one.x, one.P = x[i].copy(), P[i].copy()
        one.F, one.Q = transition(dt), process_noise(dt, agility[i : i + 1])[0]
        one.H = np.array([[1.0, 0.0, -age, 0.0], [0.0, 1.0, 0.0, -age]])
        one.R = R[i]
        one.predict()
        assert x1[i] == pytest.approx(one.x, rel=1e-9, abs=1e-9)
        assert P1[i] == pytest.approx(one.P, rel=1e-9, abs=1e-9)
        one.update(z[i])
        assert x2[i] == pytest.approx(one.x, rel=1e-9, abs=1e-9)
        assert P2[i] == pytest.approx(one.P, rel=1e-9, abs=1e-9)


def test_speed_is_as_uncertain_after_a_second_whatever_the_rate():
    for steps in (1, 10, 40):
        P = np.zeros((1, 4, 4))
        for _ in range(steps):
            _, P = predict(np.zeros((1, 4)), P, 1.0 / steps, 0.6 * np.eye(2)[None])
        assert P[0, 2, 2] == pytest.approx(0.6)
        assert P[0, 0, 0] == pytest.approx(0.6 / 3.0)


@given(*[st.tuples(*[st.floats(-3, 3)] * 3)] * 2)
def test_what_stands_still_stands_still_however_the_robot_moves(start, end):
    place = np.array([1.0, -2.0])
    seen = compose(inverse(start), (*place, 0.0))[:2]
    x = np.array([[*seen, 0.0, 0.0]])
    moved, _ = move_frame(x, np.eye(4)[None], compose(inverse(start), end), 0.0)
    assert moved[0, :2] == pytest.approx(compose(inverse(end), (*place, 0.0))[:2], abs=1e-9)
    assert moved[0, 2:] == pytest.approx([0.0, 0.0])


def test_velocity_over_ground_turns_with_the_robot_and_keeps_its_length():
    x, P = np.array([[1.0, 0.0, 0.5, 0.0]]), np.diag([1.0, 1.0, 4.0, 1.0])[None]
    moved, covariance = move_frame(x, P, (0.0, 0.0, math.pi / 2), 0.0)
    assert moved[0] == pytest.approx([0.0, -1.0, 0.0, -0.5])
    assert covariance[0, 3, 3] == pytest.approx(4.0)


def test_odometry_drift_grows_the_covariance_as_by_monte_carlo():
    rng = np.random.default_rng(3)
    x, P = np.array([[4.0, 1.0, 0.5, -0.2]]), np.zeros((1, 4, 4))
    motion, drift = (0.5, 0.0, 0.2), 0.1
    _, covariance = move_frame(x, P, motion, drift)
    errors = []
    for _ in range(20000):
        way, turn = drift * 0.5 * rng.normal(size=2), drift * 0.2 * rng.normal()
        base = x[0, :2] - motion[:2]
        R = rotation(-motion[2] - turn)
        errors.append(np.concatenate([R @ base + way, R @ x[0, 2:]]))
    assert covariance[0] == pytest.approx(np.cov(np.array(errors).T), abs=3e-4)


def test_mahalanobis_agrees_with_its_definition():
    rng = np.random.default_rng(1)
    root = rng.normal(size=(5, 2, 2))
    S = root @ root.transpose(0, 2, 1) + 0.01 * np.eye(2)
    d = rng.normal(size=(5, 2))
    expected = [d[i] @ np.linalg.inv(S[i]) @ d[i] for i in range(5)]
    assert squared_mahalanobis(d, S) == pytest.approx(expected)


def test_no_tracks_at_all():
    x, P = predict(np.empty((0, 4)), np.empty((0, 4, 4)), 0.1, np.empty((0, 2, 2)))
    x, P = update(x, P, np.empty((0, 2)), np.empty((0, 2, 2)), np.empty(0))
    assert len(x) == 0
