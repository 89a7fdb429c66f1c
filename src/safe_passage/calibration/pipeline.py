"""Calibration of a depth camera with the robot's arm as the target (paper 000, 2.2)."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Callable, Mapping, Sequence

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from safe_passage.calibration.arm_surface import ArmSurface, VisibleSurface
from safe_passage.calibration.edges import away_from_edges
from safe_passage.calibration.parameters import CalibrationParameters
from safe_passage.calibration.quality import (
    Observability,
    Residual,
    observability,
    residual,
)
from safe_passage.calibration.registration import Cloud, register
from safe_passage.calibration.start import agreement, around, laid_on, moving
from safe_passage.calibration.uncertainty import Uncertainty, offsets, uncertainty
from safe_passage.robot_model import PinholeCamera, RobotModel

OUTLINE_STEP = 6  # [px] of what the start is looked for by
SKETCH_STEP = 2  # [px] a registration needs no denser reference than its voxels


class Verdict(enum.Enum):
    """Whether a result is one."""

    OK = "ok"
    NOT_SEEN = "hardly anything of the arm has been seen"
    NOT_CONVERGED = "the registration did not settle"
    FEW_INLIERS = "too little of the model has been seen where it should be"
    LARGE_RMS = "the sensor's points do not lie on the model"
    UNOBSERVABLE = "the poses leave a direction undetermined"
    UNCERTAIN = "the poses determine a direction too weakly"


@dataclass(frozen=True)
class ArmView:
    """The arm in one pose, as the camera has seen it."""

    depth: np.ndarray  # (H, W) float32 [m], NaN = none: a temporal median
    positions: Mapping[str, float]  # [rad] or [m] of the joints


@dataclass(frozen=True)
class Calibration:
    """A result, or why there is none: only where `verdict` is OK may T_root_camera be used."""

    verdict: Verdict
    why: str  # the verdict with its figures
    T_root_camera: np.ndarray  # (4, 4) camera's optical frame in the robot's root frame
    T_initial: np.ndarray  # (4, 4) the guess
    rms: float  # [m] of the sensor's points near the model, all poses
    inliers: float  # share of the model's visible points that have been seen
    residuals: tuple[Residual, ...]  # of each pose
    observability: Observability | None
    uncertainty: Uncertainty | None = None  # None: of too few poses

    @property
    def T_align(self) -> np.ndarray:  # noqa: N802
        """(4, 4), T_extrinsic = T_align T_initial."""
        return self.T_root_camera @ np.linalg.inv(self.T_initial)


class ArmCalibrator:
    """Calibrates one camera against one robot."""

    def __init__(
        self, model: RobotModel, camera: PinholeCamera, parameters: CalibrationParameters
    ) -> None:
        self._p, self._camera = parameters, camera
        p = parameters
        self._surface = ArmSurface(model, camera, 1, p.edge, p.edge_jump)
        thin = -(-p.edge // SKETCH_STEP)
        self._sketch = ArmSurface(model, camera, SKETCH_STEP, thin, SKETCH_STEP * p.edge_jump)
        self._outline = ArmSurface(model, camera, OUTLINE_STEP)

    def calibrate(
        self,
        views: Sequence[ArmView],
        T_initial: np.ndarray,
        check: Callable[[], None] = lambda: None,
    ) -> Calibration:
        """The camera's pose.

        Args:
            views: of the arm in one pose or, better, several.
            T_initial: (4, 4) T_root_camera, a guess.
            check: called between registrations; what it raises ends the calibration.
        """
        p = self._p
        clouds = self._clouds(views)
        T = self._start(views, T_initial, check) if p.start_search else T_initial
        for distance in p.distances:
            check()
            T = self._aligned(views, clouds, T, distance)
        settled = False
        for _ in range(p.rounds):
            check()
            before, T = T, self._aligned(views, clouds, T, p.last_distance)
            settled = self._same(before, T)
            if settled:
                break
        return self._judged(views, clouds, T, T_initial, settled)

    def evaluate(self, views: Sequence[ArmView], T_root_camera: np.ndarray) -> list[Residual]:
        """How well other poses agree with a calibration."""
        pairs = zip(self._clouds(views), self._surfaces(views, T_root_camera))
        return [self._residual(cloud, one, T_root_camera) for cloud, one in pairs]

    def close(self) -> None:
        """Give the graphics memory back."""
        for surface in (self._surface, self._sketch, self._outline):
            surface.close()

    def _start(
        self, views: Sequence[ArmView], T_initial: np.ndarray, check: Callable[[], None]
    ) -> np.ndarray:
        """T_root_camera (4, 4) from which the registration converges, if from any."""
        p, outline = self._p, self._outline
        step = OUTLINE_STEP
        seen = [np.where(v.depth <= p.range_max, v.depth, np.nan)[::step, ::step] for v in views]
        arm = [outline.camera.points(one) for one in moving(seen)]

        def drawn(T: np.ndarray) -> list[np.ndarray]:
            return [outline.depth(view.positions, T) for view in views]

        def model(T: np.ndarray) -> list[np.ndarray]:
            points = [outline.camera.points(one) for one in moving(drawn(T))]
            return [_moved(T, one) for one in points]

        starts = around(T_initial)
        laid = laid_on(arm, model(T_initial))
        if laid is not None:
            starts.append(laid)
        found = []
        for T in starts:
            for distance in p.start_distances:
                check()
                T = self._laid(model(T), [_moved(T, one) for one in arm], T, distance)
            found.append((agreement(seen, drawn(T), p.start_agreement), T))
        return max(found, key=lambda one: one[0])[1]

    def _clouds(self, views: Sequence[ArmView]) -> list[np.ndarray]:
        """Each view's points (N, 3), camera frame."""
        p = self._p
        return [
            self._camera.points(
                view.depth,
                (view.depth <= p.range_max) & away_from_edges(view.depth, p.edge, p.edge_jump),
            )
            for view in views
        ]

    def _surfaces(self, views: Sequence[ArmView], T: np.ndarray) -> list[VisibleSurface]:
        return [self._surface.visible(view.positions, T) for view in views]

    def _sketches(self, views: Sequence[ArmView], T: np.ndarray) -> list[VisibleSurface]:
        return [self._sketch.visible(view.positions, T) for view in views]

    def _aligned(
        self, views: Sequence[ArmView], clouds: list[np.ndarray], T: np.ndarray, distance: float
    ) -> np.ndarray:
        """T_root_camera after one registration of all poses' clouds together."""
        p = self._p
        voxel = p.fine_voxel if distance < p.fine_below else p.coarse_voxel
        reference, sensor = [], []
        for cloud, surface in zip(clouds, self._sketches(views, T)):
            if len(surface.points):
                reference.append(surface.points)
                sensor.append(_cropped(_moved(T, cloud), surface.points, distance + voxel))
        return self._laid(reference, sensor, T, distance)

    def _laid(
        self, reference: list[np.ndarray], sensor: list[np.ndarray], T: np.ndarray, distance: float
    ) -> np.ndarray:
        """T_root_camera corrected by what lays the sensor's points on the reference's."""
        p = self._p
        voxel = p.fine_voxel if distance < p.fine_below else p.coarse_voxel
        if min(sum(map(len, reference)), sum(map(len, sensor))) < 2 * p.neighbours:
            return T
        model = Cloud(np.concatenate(reference), voxel, p.neighbours)
        seen = Cloud(np.concatenate(sensor), voxel, p.neighbours)
        T_seen_model = register(model, seen, p.method, distance, p.iterations)
        return np.linalg.inv(T_seen_model) @ T

    def _same(self, a: np.ndarray, b: np.ndarray) -> bool:
        change = np.linalg.inv(a) @ b
        turn = np.linalg.norm(Rotation.from_matrix(change[:3, :3]).as_rotvec())
        p = self._p
        return bool(
            np.linalg.norm(change[:3, 3]) < p.settled_translation and turn < p.settled_rotation
        )

    def _residual(self, cloud: np.ndarray, one: VisibleSurface, T: np.ndarray) -> Residual:
        p = self._p
        sensor = _cropped(_moved(T, cloud), one.points, p.last_distance)
        return residual(sensor, one, p.last_distance, p.inlier_distance)

    def _uncertainty(
        self, clouds: list[np.ndarray], surfaces: list[VisibleSurface], T: np.ndarray
    ) -> Uncertainty | None:
        near = self._p.last_distance
        pairs = [(_cropped(_moved(T, c), s.points, near), s) for c, s in zip(clouds, surfaces)]
        return uncertainty([offsets(sensor, s, near) for sensor, s in pairs], T[:3, 3])

    def _judged(
        self,
        views: Sequence[ArmView],
        clouds: list[np.ndarray],
        T: np.ndarray,
        T_initial: np.ndarray,
        settled: bool,
    ) -> Calibration:
        p = self._p
        surfaces = self._surfaces(views, T)
        residuals = tuple(self._residual(c, s, T) for c, s in zip(clouds, surfaces))
        weights = np.array([one.points for one in residuals], float)
        shown = np.array([len(one.points) for one in surfaces], float)
        points = int(weights.sum())
        if points < p.least_points:
            why = f"{Verdict.NOT_SEEN.value}: {points} points, least_points is {p.least_points}"
            return Calibration(Verdict.NOT_SEEN, why, T, T_initial, np.nan, 0.0, residuals, None)
        rms = float(np.sqrt(np.nansum(weights * [one.rms**2 for one in residuals]) / points))
        inliers = float((shown * [one.inliers for one in residuals]).sum() / shown.sum())
        held = observability([one for one in surfaces if len(one.points)])
        spread = self._uncertainty(clouds, surfaces, T)
        allowed = Uncertainty(p.most_translation, p.most_rotation)
        figures = f"rms {1e3 * rms:.1f} mm, pose +- {spread or 'unknown'}"
        verdict, why = Verdict.OK, f"{Verdict.OK.value}: {figures}"
        for wrong, reason, figures in (
            (not settled, Verdict.NOT_CONVERGED, f"after {p.rounds} rounds"),
            (inliers < p.least_inliers, Verdict.FEW_INLIERS, f"{inliers:.2f}"),
            (rms > p.most_rms, Verdict.LARGE_RMS, f"rms {1e3 * rms:.1f} mm"),
            (
                held.eigenvalues[0] < p.least_observability,
                Verdict.UNOBSERVABLE,
                f"{held.weakest}: {held.eigenvalues[0]:.4f}",
            ),
            (
                spread is not None and spread.exceeds(allowed),
                Verdict.UNCERTAIN,
                f"{spread and spread.direction}: pose +- {spread}, "
                f"allowed +- {allowed}; take more poses",
            ),
        ):
            if wrong:
                verdict, why = reason, f"{reason.value}: {figures}"
                break
        return Calibration(verdict, why, T, T_initial, rms, inliers, residuals, held, spread)


def _moved(T: np.ndarray, points: np.ndarray) -> np.ndarray:
    return points @ T[:3, :3].T + T[:3, 3]


def _cropped(points: np.ndarray, around: np.ndarray, distance: float) -> np.ndarray:
    """The points within `distance` [m] of those in `around`."""
    if not len(points) or not len(around):
        return points[:0]
    low, high = around.min(axis=0) - distance, around.max(axis=0) + distance
    points = points[((points >= low) & (points <= high)).all(axis=1)]
    found = cKDTree(around[::7]).query(points, distance_upper_bound=distance + 0.01)[0]
    return points[np.isfinite(found)]
