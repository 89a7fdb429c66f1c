"""The detector through its binding: what it finds in the aisle, and that nothing breaks it."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from safe_passage import _person_detection as detection
from safe_passage.simulation.analytic_scene import AnalyticScene

SCENE = AnalyticScene()
INTRINSICS = detection.Intrinsics(SCENE.camera.focal, SCENE.camera.focal, 319.5, 239.5)
SEED = detection.GroundPlane(SCENE.camera.rotation()[2], SCENE.camera.z)


def frame_at(time):
    depth, bgr = SCENE.render(time)
    return detection.from_depth(depth, bgr, INTRINSICS)


def detector(**parameters):
    values = detection.DetectorParameters()
    for name, value in parameters.items():
        setattr(values, name, value)
    return detection.PersonDetector(values)


@pytest.fixture(scope="module")
def result():
    return detector().detect(frame_at(1.6), SEED)


def test_ground_is_the_scenes(result):
    assert result.ground.state == detection.GroundState.TRACKED
    assert result.ground.plane.offset == pytest.approx(SCENE.camera.z, abs=0.01)


def test_everyone_is_a_candidate_where_it_stands_and_as_tall(result):
    for person in SCENE.persons(1.6):
        gaps = [
            np.hypot(d.candidate.head[0] - person.x, d.candidate.head[1] - person.y)
            for d in result.detections
        ]
        nearest = result.detections[int(np.argmin(gaps))].candidate
        assert min(gaps) < 0.2
        assert nearest.head[2] == pytest.approx(person.height, abs=0.06)


def test_stages_are_timed(result):
    assert list(result.times_ms) == [
        "voxel filter",
        "ground plane",
        "ground removal",
        "clusters",
        "head sub-clusters",
        "confidence HOG",
        "candidates of the picture",
    ]


def test_same_frame_same_result():
    first, second = (detector().detect(frame_at(1.6), SEED) for _ in range(2))
    assert [d.confidence for d in first.detections] == [d.confidence for d in second.detections]


def test_no_ground_no_detections():
    result = detector().detect(frame_at(1.6), None)
    assert result.ground.state == detection.GroundState.UNKNOWN
    assert result.detections == []


def test_image_smaller_than_the_cloud_serves_too():
    depth, bgr = SCENE.render(1.6)
    half = detection.Intrinsics(SCENE.camera.focal / 2, SCENE.camera.focal / 2, 159.5, 119.5)
    frame = detection.from_depth(depth, np.ascontiguousarray(bgr[::2, ::2]), half)
    accepted = [d for d in detector().detect(frame, SEED).detections if d.accepted]
    assert len(accepted) >= 2


faults = st.sampled_from([np.nan, np.inf, -np.inf, 0.0, -1.0, 1e-30, 1e30])


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(faults, st.integers(0, 479), st.integers(0, 639), st.integers(1, 480), st.integers(1, 640))
def test_any_hole_in_the_depth_is_survived(fault, row, column, height, width):
    depth, bgr = SCENE.render(1.6)
    depth = depth.copy()
    depth[row : row + height, column : column + width] = fault
    result = detector().detect(detection.from_depth(depth, bgr, INTRINSICS), SEED)
    for found in result.detections:
        candidate = found.candidate
        assert np.isfinite([*candidate.head, *candidate.low, *candidate.high]).all()
        assert not np.isnan(found.confidence)


def test_arrays_of_the_wrong_shape_are_refused():
    with pytest.raises(ValueError, match="shape"):
        detection.RgbdFrame(np.zeros((4, 4), np.float32), np.zeros((4, 4, 3), np.uint8), INTRINSICS)
