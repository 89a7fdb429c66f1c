"""The person detector: five_people.pcd, frames with user masks, speed, PCL beside it."""

from __future__ import annotations

import os
import statistics
import subprocess
from pathlib import Path

import cv2
import numpy as np
from safe_passage import _person_detection as detection
from safe_passage.evaluation.detection_metrics import DetectionCounts
from safe_passage.evaluation.user_masks import judge, persons_in
from safe_passage.human_safety.models import default_folder
from safe_passage.replay.sources import FileSource
from safe_passage.simulation.analytic_scene import AnalyticScene

from bench.metric import metric

DATA = Path(os.environ.get("SAFE_PASSAGE_DATA", "../shared/data")) / "rgbd_people"
FIVE_PEOPLE_GROUND = detection.GroundPlane(np.array([0.0103586, -0.997011, -0.0765573]), 1.26614)
METHODS = ("hog", "yolo")


def make_detector(method: str) -> detection.PersonDetector:
    """The detector as the node runs it with its defaults."""
    parameters = detection.DetectorParameters()
    parameters.method = getattr(detection.Method, method.upper())
    parameters.yolo.model = str(default_folder() / "yolov3-tiny.weights")
    return detection.PersonDetector(parameters)


def run(quick: bool) -> list[dict]:
    """All rows."""
    return [*five_people(), *user_masks(), *speed(5 if quick else 100)]


def five_people() -> list[dict]:
    """True and false detections; the five bodies are all that stands free in that cloud."""
    rows = []
    for method in METHODS:
        true = false = None
        if DATA.exists():
            frame = detection.load_pcd(str(DATA / "five_people.pcd"))
            result = make_detector(method).detect(frame, FIVE_PEOPLE_GROUND)
            on_person = [_is_one_of_five(d.candidate) for d in result.detections if d.accepted]
            true = len(set(on_person) - {None})
            false = len(on_person) - true  # a second one on the same person too
        rows.append(metric(f"five_people_{method}_true", true, "persons", "= 5"))
        rows.append(metric(f"five_people_{method}_false", false, "persons", "= 0"))
    return rows


# Columns [px] of the five heads, read off the image of five_people.pcd by eye.
FIVE_HEADS = (80, 195, 330, 412, 540)


def _is_one_of_five(candidate: detection.Candidate) -> int | None:
    x, _, width, _ = candidate.roi
    distances = [abs(x + 0.5 * width - head) for head in FIVE_HEADS]
    nearest = int(np.argmin(distances))
    return nearest if distances[nearest] < 45 else None


def user_masks() -> list[dict]:
    """The paper's figures on the frames with user masks."""
    rows = []
    for method in METHODS:
        counts = _count_masks(method) if DATA.exists() else None
        for name in ("precision", "recall", "f1", "accuracy", "fp_rate"):
            value = getattr(counts, name) if counts else None
            rows.append(metric(f"user_masks_{method}_{name}", value, ""))
    return rows


def _count_masks(method: str) -> DetectionCounts:
    counts = DetectionCounts()
    folder = DATA / "vision_utils_depth"
    source = FileSource(folder, seconds_per_frame=1.0)
    for time, file in enumerate(source.files):
        if file.name.startswith("inside1"):
            continue  # its depth does not belong to its picture
        mask = cv2.imread(str(file).replace("_rgb", "_user_mask"), cv2.IMREAD_GRAYSCALE)
        frame = source.frame(time)
        rgbd = detection.RgbdFrame(frame.xyz, frame.bgr, detection.Intrinsics(*frame.intrinsics))
        seed = detection.GroundPlane(frame.R_base_camera[2], frame.p_base_camera[2])
        result = make_detector(method).detect(rgbd, seed)
        order = sorted(result.detections, key=lambda d: -d.confidence)
        pixels = [_pixels(result, d.candidate, frame.intrinsics) for d in order]
        counts += judge(order, pixels, persons_in(mask))
    return counts


def _pixels(
    result: detection.DetectionResult, candidate: detection.Candidate, intrinsics: tuple
) -> np.ndarray:
    points = result.camera_points(candidate)
    fx, fy, cx, cy = intrinsics
    columns = fx * points[:, 0] / points[:, 2] + cx
    rows = fy * points[:, 1] / points[:, 2] + cy
    return np.rint(np.stack([columns, rows], axis=1)).astype(int)


def _speed_input() -> tuple[str, detection.RgbdFrame, detection.GroundPlane]:
    if DATA.exists():
        frame = detection.load_pcd(str(DATA / "five_people.pcd"))
        return "five_people.pcd", frame, FIVE_PEOPLE_GROUND
    scene = AnalyticScene()
    depth, bgr = scene.render(1.6)
    camera = scene.camera
    intrinsics = detection.Intrinsics(
        camera.focal, camera.focal, (camera.width - 1) / 2, (camera.height - 1) / 2
    )
    seed = detection.GroundPlane(camera.rotation()[2], camera.z)
    return "the analytic aisle", detection.from_depth(depth, bgr, intrinsics), seed


def speed(runs: int) -> list[dict]:
    """Median times of the whole chain; stage by stage on standard output."""
    name, frame, seed = _speed_input()
    medians = {}
    for method in METHODS:
        detector = make_detector(method)
        times = [detector.detect(frame, seed).times_ms for _ in range(runs + 3)][3:]
        medians[method] = statistics.median(sum(t.values()) for t in times)
        print(f"{method} on {name}, median of {runs} [ms]:")
        for stage in times[0]:
            print(f"  {stage:<20} {statistics.median(t[stage] for t in times):7.2f}")
        print(f"  {'all':<20} {medians[method]:7.2f}", flush=True)
    pcl = _pcl_ms(max(5, runs // 4))
    return [
        metric("detector_hog_ms", medians["hog"], "ms", "<= 30"),
        metric("detector_yolo_hz", 1e3 / medians["yolo"], "Hz", ">= 15"),
        metric("pcl_ms", pcl, "ms"),
        metric("pcl_over_ours", pcl and pcl / medians["hog"], "", ">= 2"),
    ]


def _pcl_ms(runs: int) -> float | None:
    """Median time of PCL's own detector on five_people.pcd, in this run, on this machine."""
    if not DATA.exists():
        return None
    svm = DATA / "trainedLinearSVMForPeopleDetectionWithHOG.yaml"
    command = [
        "rosrun",
        "safe_passage",
        "pcl_people_bench",
        DATA / "five_people.pcd",
        svm,
        str(runs + 2),
    ]
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    times, confidences = output.split("ms", 1)[1].split(" confidences")
    accepted = [float(c) for c in confidences.split() if float(c) > -1.5]
    print(f"PCL's own detector: {len(accepted)} of {len(confidences.split())} candidates accepted")
    return statistics.median(float(t) for t in times.split()[2:])
