#!/usr/bin/env python3
"""How well do the project's own detectors see the simulated people?

Every person is drawn alone in the simulated warehouse, as a camera 1.63 m over the floor sees it:
all poses (or `--poses`), eight directions, five distances. Scored are YOLOv3-tiny on the whole
picture at 256 x 192 and 416 x 416 (a box of probability >= 0.25 that overlaps the person, IoU >=
0.4) and the whole detector with depth, by HOG and by YOLO (an accepted candidate on the person).
Run it inside the built workspace; all poses take half an hour:

    python3 assets/people/check_people.py [--poses 0 1 3] [--pictures FOLDER] [NAME ...]
"""

from __future__ import annotations

import argparse
import itertools
import math
from collections import defaultdict
from pathlib import Path

import cv2
import numpy as np
from safe_passage import _person_detection as detection
from safe_passage.human_safety.models import default_folder
from safe_passage.simulation import people_assets, robots, scene, walkers, worlds

ROOT = Path(__file__).resolve().parents[2]
DISTANCES = (2.0, 3.0, 4.0, 6.0, 8.0)  # [m]
YAWS = tuple(range(0, 360, 45))  # [deg], 0: the person walks away from the camera
VIEWS = ((-7.8, -2.05, 0.0), (8.2, 2.05, math.pi), (8.5, -4.6, 1.65))  # of the robot: x, y, yaw
PITCH = 0.14  # [rad]
MAX_RANGE = 8.5  # [m] of depth
JUDGES = ("yolo 256x192", "yolo 416x416", "detector yolo", "detector hog")


class Judge:
    """The detectors, one answer each for a picture of one person."""

    def __init__(self) -> None:
        self._yolo = [self._network(256, 192), self._network(416, 416)]
        self._methods = []
        for method in (detection.Method.YOLO, detection.Method.HOG):
            parameters = detection.DetectorParameters()
            parameters.method = method
            parameters.yolo.model = str(default_folder() / "yolov3-tiny.weights")
            self._methods.append(detection.PersonDetector(parameters))

    @staticmethod
    def _network(width: int, height: int) -> detection.YoloConfidence:
        parameters = detection.YoloParameters()
        parameters.model = str(default_folder() / "yolov3-tiny.weights")
        parameters.input_width, parameters.input_height = width, height
        return detection.YoloConfidence(parameters)

    def sees(self, bgr: np.ndarray, depth: np.ndarray, box: np.ndarray, camera) -> list[bool]:  # type: ignore[no-untyped-def]
        """Whether each of JUDGES finds the person at `box` (x0, y0, x1, y1) [px]."""
        answers = []
        for network in self._yolo:
            found = [(b[:4], b[4]) for b in network.detect(bgr)]
            answers.append(any(p >= 0.25 and iou(b, box) >= 0.4 for b, p in found))
        frame = detection.from_depth(depth, bgr, detection.Intrinsics(*camera.intrinsics))
        T = camera.pose_in_base()
        seed = detection.GroundPlane(T[2, :3], T[2, 3])
        for detector in self._methods:
            detector.reset()
            accepted = [d for d in detector.detect(frame, seed).detections if d.accepted]
            answers.append(any(covers(d.candidate.roi, box) for d in accepted))
        return answers


def iou(rectangle: tuple, box: np.ndarray) -> float:
    """Overlap of (x, y, width, height) with (x0, y0, x1, y1)."""
    x, y, width, height = rectangle
    wide = min(x + width, box[2]) - max(x, box[0])
    high = min(y + height, box[3]) - max(y, box[1])
    both = max(wide, 0.0) * max(high, 0.0)
    return both / (width * height + (box[2] - box[0]) * (box[3] - box[1]) - both)


def covers(roi: tuple, box: np.ndarray) -> bool:
    """Whether a candidate's column is the person's."""
    middle = roi[0] + 0.5 * roi[2]
    slack = 0.25 * (box[2] - box[0])
    return box[0] - slack <= middle <= box[2] + slack


class Studio:
    """The warehouse with one person in front of the camera."""

    def __init__(self, names: list[str]) -> None:
        self.bodies = [people_assets.load_person(name) for name in names]
        world = worlds.load_world(ROOT / "config/worlds/warehouse.yaml")
        self.camera = robots.CameraModel(pitch=PITCH)
        robot = robots.Robot(
            "tripod", ((0, 0), (1, 0), (0, 1)), 1.0, robots.DriveModel(), (), (), (self.camera,)
        )
        self.scene = scene.Scene(world, robot, self.bodies)
        self.rng = np.random.default_rng(0)

    def picture(
        self, person: int, pose: int, distance: float, yaw: float, view: int
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Picture, depth [m] and the person's box (x0, y0, x1, y1) [px]."""
        x, y, heading = VIEWS[view % len(VIEWS)]
        states: list[walkers.PersonState | None] = [None] * len(self.bodies)
        body = self.bodies[person]
        walked = 0.0 if pose == 0 else float(body.phases[pose]) * body.stride_m
        side = 0.25 * math.sin(3.7 * view)  # not always in the middle of the picture
        states[person] = walkers.PersonState(
            x + distance * math.cos(heading) - side * math.sin(heading),
            y + distance * math.sin(heading) + side * math.cos(heading),
            heading + math.radians(yaw),
            (0.0, 0.0) if pose == 0 else (1.0, 0.0),
            walked,
        )
        self.scene.place_robot((x, y, heading))
        self.scene.place_people(states)
        self.scene.settle()
        bgr, depth = self.scene.render(self.camera)
        noisy = bgr + self.rng.normal(0.0, 2.5, bgr.shape)
        depth = np.where(depth <= MAX_RANGE, depth, np.nan).astype(np.float32)
        box = self._box(body.vertices[pose], distance, side, math.radians(yaw))
        return np.clip(noisy, 0, 255).astype(np.uint8), depth, box

    def _box(self, vertices: np.ndarray, distance: float, side: float, yaw: float) -> np.ndarray:
        c, s = math.cos(yaw), math.sin(yaw)
        points = vertices @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        points = points + np.array([distance, side, 0.0])
        T = self.camera.pose_in_base()
        seen = (points - T[:3, 3]) @ T[:3, :3]
        fx, fy, cx, cy = self.camera.intrinsics
        pixels = np.stack(
            [fx * seen[:, 0] / seen[:, 2] + cx, fy * seen[:, 1] / seen[:, 2] + cy], axis=1
        )
        size = [self.camera.width, self.camera.height]
        return np.concatenate(
            [np.maximum(pixels.min(axis=0), 0), np.minimum(pixels.max(axis=0), size)]
        )


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("names", nargs="*")
    options.add_argument("--poses", type=int, nargs="*")
    options.add_argument("--people", type=Path, help="other npz files than the package's")
    options.add_argument("--pictures", type=Path, help="keep the first pose and every miss here")
    chosen = options.parse_args()
    if chosen.people:
        people_assets.FOLDER = chosen.people
    names = chosen.names or list(people_assets.list_people())
    studio, judge = Studio(names), Judge()
    seen: dict[str, dict[float, list]] = defaultdict(lambda: defaultdict(list))
    views = itertools.count()
    print(f"{'':14}" + "".join(f"{judge:<27}" for judge in JUDGES))
    print(
        f"{'share seen at':14}" + ("".join(f"{d:3.0f} m" for d in DISTANCES) + "  ") * len(JUDGES)
    )
    for person, name in enumerate(names):
        poses = chosen.poses or range(len(studio.bodies[person].vertices))
        for pose, distance, yaw in itertools.product(poses, DISTANCES, YAWS):
            bgr, depth, box = studio.picture(person, pose, distance, yaw, next(views))
            answers = judge.sees(bgr, depth, box, studio.camera)
            for row in (name, f"yaw {yaw:3d} deg", f"pose {pose:2d}", "all"):
                seen[row][distance].append(answers)
            if chosen.pictures and (pose == poses[0] or not all(answers)):
                _keep(
                    chosen.pictures / f"{name}_{distance:.0f}m_{yaw:03d}_{pose}.png", bgr, answers
                )
        _report(name, seen[name])
    for row in sorted(set(seen) - set(names)):
        _report(row, seen[row])


def _keep(path: Path, bgr: np.ndarray, answers: list[bool]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    mark = "".join("+" if answer else "-" for answer in answers)
    cv2.putText(bgr, mark, (5, 20), cv2.FONT_HERSHEY_SIMPLEX, 0.7, (0, 0, 255), 2)
    cv2.imwrite(str(path), bgr)


def _report(row: str, seen: dict[float, list]) -> None:
    """Shares of pictures in which each of JUDGES found the person."""
    shares = np.array([np.mean(seen[distance], axis=0) for distance in DISTANCES]).T
    cells = ("".join(f"{share:5.2f}" for share in judge) for judge in shares)
    print(f"{row:14}" + "  ".join(cells), flush=True)


if __name__ == "__main__":
    main()
