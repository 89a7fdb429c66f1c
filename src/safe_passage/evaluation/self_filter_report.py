"""How much of the robot the self-filter takes away, and how much of the people beside it.

Each frame is another one: an arm in any pose, one of its big joints turning, a person's body and a
reaching forearm a given distance off the arm. The camera's pose is off by what a calibration
leaves, its stamps by what drivers do.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from time import perf_counter

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from safe_passage.core.geometry import matrix
from safe_passage.core.progress import Progress
from safe_passage.evaluation.body_filter import BodyFilter
from safe_passage.robot_model import JointHistory, RobotModel
from safe_passage.robot_model.surfaces import Surface, cylinder, joined, sphere
from safe_passage.self_filter import SelfFilter, SelfFilterParameters
from safe_passage.simulation.arm_scene import FLOOR, ArmScene, Owner, View, at, looking_at, room
from safe_passage.simulation.people_assets import list_people, load_person
from safe_passage.simulation.robots import CameraModel

CAMERA = CameraModel(range_min=0.4)
JOINT_PERIOD = 0.01  # [s] between two joint states
FOREARM = 0.4  # [m]


@dataclass(frozen=True)
class Trial:
    """What the frames are made with."""

    frames: int
    seed: int
    speed: float = 1.0  # [rad/s] of one of the arm's big joints
    clearance: float = 0.1  # [m] between people and the arm
    stamp_error: float = 0.01  # [s] of the images, at most
    translation_error: float = 0.003  # [m] of the camera's pose
    rotation_error: float = 0.0035  # [rad] 0.2 degrees


@dataclass
class Score:
    """Of one filter over all frames; pixels by their Owner."""

    pixels: np.ndarray = field(default_factory=lambda: np.zeros(len(Owner), np.int64))
    removed: np.ndarray = field(default_factory=lambda: np.zeros(len(Owner), np.int64))
    seconds: list[float] = field(default_factory=list)  # of each frame
    worst: float = 0.0  # share of a frame's robot pixels left in it, at most

    def add(self, owner: np.ndarray, removed: np.ndarray, seconds: float) -> None:
        """One frame."""
        pixels = np.bincount(owner.ravel(), minlength=len(Owner))
        gone = np.bincount(owner[removed], minlength=len(Owner))
        self.pixels += pixels
        self.removed += gone
        self.seconds.append(seconds)
        if pixels[Owner.ROBOT]:
            self.worst = max(self.worst, 1.0 - gone[Owner.ROBOT] / pixels[Owner.ROBOT])

    def share(self, owner: Owner) -> float:
        """Of the owner's pixels that are removed."""
        return float(self.removed[owner] / max(1, self.pixels[owner]))


def _people() -> list[Surface]:
    bodies = [load_person(name) for name in list_people()]
    arm = joined([cylinder(0.04, FOREARM), sphere(0.045).moved(at(0.0, 0.0, 0.5 * FOREARM))])
    return [Surface(one.standing.astype(float), one.faces) for one in bodies] + [arm]


@dataclass(frozen=True)
class Frame:
    """What a filter is given, and whose each pixel is."""

    view: View
    stamp: float  # [s] as the driver says
    joints: JointHistory
    T_camera_root: np.ndarray  # (4, 4) as it is believed


class Frames:
    """Draws frames with their truth."""

    def __init__(self, model: RobotModel, trial: Trial) -> None:
        self._model, self._trial = model, trial
        self._people = _people()
        self.scene = ArmScene(model, CAMERA, room(), self._people)
        self._limits = {j.name: j.limits for j in model.joints if j.name in model.movable}

    def frame(self, number: int) -> Frame:
        """One of any number of frames."""
        trial = self._trial
        rng = np.random.default_rng((trial.seed, number))
        start = {n: 0.8 * rng.uniform(*limits) for n, limits in self._limits.items()}
        moving = self._model.movable[rng.integers(4)]
        rate = trial.speed * rng.choice([-1.0, 1.0])

        def at_time(time: float) -> dict[str, float]:
            return {n: q + (rate * time if n == moving else 0.0) for n, q in start.items()}

        history = JointHistory(tolerance=0.05)
        phase = rng.uniform(0.0, JOINT_PERIOD)
        for time in np.arange(-0.2, 0.021, JOINT_PERIOD) + phase:
            history.add(float(time), list(start), list(at_time(float(time)).values()))
        azimuth = rng.uniform(-0.3, 1.8)  # into the corner of the two walls
        eye = np.array([1.6 * np.cos(azimuth), 1.6 * np.sin(azimuth), rng.uniform(0.5, 1.3)])
        T_camera_root = np.linalg.inv(looking_at(eye, np.array([0.0, 0.0, 0.55])))
        people = self._placed(at_time(0.0), rng)
        depth, owner = self.scene.exact(T_camera_root, at_time(0.0), people)
        view = self.scene.measured(depth, owner, (trial.seed, number, 1))
        stamp = rng.uniform(-trial.stamp_error, trial.stamp_error)
        return Frame(view, stamp, history, _off(trial, rng) @ T_camera_root)

    def _placed(self, positions: dict[str, float], rng: np.random.Generator) -> np.ndarray:
        """T_root_people (B, 4, 4): one body and the forearm `clearance` off the arm."""
        poses = self._model.poses(positions)
        arm = joined([surface.moved(poses[n]) for n, surface in self._model.links.items()])
        tree = cKDTree(_dense(arm))
        places = np.tile(at(0.0, 0.0, -50.0), (len(self._people), 1, 1))
        body = int(rng.integers(len(self._people) - 1))
        heading, turn = rng.uniform(-np.pi, np.pi, 2)
        upright = np.eye(4)
        upright[:2, :2] = matrix((0.0, 0.0, turn))[:2, :2]
        upright[2, 3] = FLOOR
        towards = np.array([np.cos(heading), np.sin(heading), 0.0])
        clearance = self._trial.clearance
        places[body] = _slid(self._people[body], upright, towards, tree, clearance)
        way = rng.normal(size=3)
        way /= np.linalg.norm(way)
        tip = np.eye(4)
        side = np.cross(way, np.eye(3)[np.argmin(np.abs(way))])
        side /= np.linalg.norm(side)
        tip[:3, :3] = np.stack([side, np.cross(-way, side), -way], axis=1)  # z towards the arm
        tip[:3, 3] = arm.vertices[rng.integers(len(arm.vertices))]
        places[-1] = _slid(self._people[-1], tip, way, tree, clearance)
        return places


def _dense(surface: Surface) -> np.ndarray:
    """Corners and triangles' middles (N, 3): no point of the surface is far from one."""
    return np.concatenate([surface.vertices, surface.vertices[surface.faces].mean(axis=1)])


def _slid(
    body: Surface, T: np.ndarray, way: np.ndarray, tree: cKDTree, clearance: float
) -> np.ndarray:
    """T moved along `way` to where the body is `clearance` off what the tree holds."""
    points = body.moved(T).vertices
    near, far = 0.0, 3.0
    for _ in range(12):
        middle = 0.5 * (near + far)
        distance = tree.query(points + middle * way, distance_upper_bound=clearance)[0].min()
        near, far = (near, middle) if distance > clearance else (middle, far)
    moved = T.copy()
    moved[:3, 3] += far * way
    return moved


def _off(trial: Trial, rng: np.random.Generator) -> np.ndarray:
    """(4, 4) by which a calibrated camera's pose is wrong."""
    axes = rng.normal(size=(2, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec(trial.rotation_error * axes[0]).as_matrix()
    T[:3, 3] = trial.translation_error * axes[1]
    return T


def compare(model: RobotModel, parameters: SelfFilterParameters, trial: Trial) -> dict[str, Score]:
    """The same frames through the self-filter and through the box and sphere filters."""
    frames = Frames(model, trial)
    camera = frames.scene.pinhole
    ours = SelfFilter(model, camera, parameters)
    others = {
        shape: BodyFilter(model, camera, shape, parameters.padding) for shape in ("box", "sphere")
    }
    scores = {name: Score() for name in ("drawn", *others)}
    progress = Progress("self-filter", trial.frames)
    for number in range(trial.frames):
        one = frames.frame(number)
        start = perf_counter()
        filtered = ours.filter(one.view.depth, one.stamp, one.joints, one.T_camera_root)
        scores["drawn"].add(one.view.owner, filtered.removed, perf_counter() - start)
        for shape, other in others.items():
            start = perf_counter()
            gone = other.removed(one.view.depth, one.stamp, one.joints, one.T_camera_root)
            scores[shape].add(one.view.owner, gone, perf_counter() - start)
        progress.show(number + 1)
    return scores
