"""What the detector must achieve, in the user's terms: real people found, empty rooms empty."""

import numpy as np
import pytest
from safe_passage import _person_detection as detection
from safe_passage.human_safety.models import default_folder
from safe_passage.replay.sources import FileSource
from safe_passage.simulation.analytic_scene import AnalyticScene

from bench import detector as bench

METHODS = ("hog", "yolo")


@pytest.fixture(scope="session", autouse=True)
def model():
    assert (default_folder() / "yolov3-tiny.weights").exists(), "tools/setup puts the model there"


def rows(metrics):
    return {metric["name"]: metric["value"] for metric in metrics}


def test_five_people_are_five(recordings):
    found = rows(bench.five_people())
    for method in METHODS:
        assert found[f"five_people_{method}_true"] == 5
        assert found[f"five_people_{method}_false"] == 0


def test_user_masks_keep_their_baseline(recordings):
    """Measured: HOG F1 0.92, YOLO F1 1.00; the margin is two persons of thirteen."""
    found = rows(bench.user_masks())
    assert found["user_masks_hog_f1"] >= 0.80
    assert found["user_masks_yolo_f1"] >= 0.88


def test_empty_lab_is_empty(recordings):
    """Measured on the frame without anybody, by both methods."""
    source = FileSource(recordings / "rgbd_people" / "vision_utils_depth", seconds_per_frame=1.0)
    index = [file.name for file in source.files].index("empty_lab_rgb.png")
    frame = source.frame(float(index))
    rgbd = detection.RgbdFrame(frame.xyz, frame.bgr, detection.Intrinsics(*frame.intrinsics))
    seed = detection.GroundPlane(frame.R_base_camera[2], frame.p_base_camera[2])
    for method in METHODS:
        found = bench.make_detector(method).detect(rgbd, seed).detections
        assert not any(d.accepted for d in found), method


def test_hog_follows_the_people_of_the_aisle():
    """Measured over one crossing: recall 0.98, one false detection in ten frames."""
    scene = AnalyticScene()
    camera = scene.camera
    intrinsics = detection.Intrinsics(camera.focal, camera.focal, 319.5, 239.5)
    seed = detection.GroundPlane(camera.rotation()[2], camera.z)
    detector = bench.make_detector("hog")
    seen = missed = false = 0
    for time in np.arange(0.4, 7.6, 0.8):
        depth, bgr = scene.render(time)
        result = detector.detect(detection.from_depth(depth, bgr, intrinsics), seed)
        heads = [d.candidate.head for d in result.detections if d.accepted]
        persons = scene.persons(time)
        near = [[np.hypot(h[0] - p.x, h[1] - p.y) < 0.4 for p in persons] for h in heads]
        found = {int(np.argmax(row)) for row in near if any(row)}
        seen += len(found)
        missed += len(persons) - len(found)
        false += sum(not any(row) for row in near)
    assert seen / (seen + missed) >= 0.85
    assert false <= 6
