"""Other software on the same scans: PCL and Open3D for planes, Patchwork++ for the ground."""

from __future__ import annotations

import importlib
import math
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from typing import Any
from unittest.mock import MagicMock

import numpy as np
from safe_passage.scan_segmentation import OrganisedScan, ScanSegmenter
from safe_passage.scan_segmentation.scan import Level
from safe_passage.simulation.scan_scene import Place, Scanner

LEAST_POINTS = 300  # of a plane that PCL and Open3D are asked for: our smallest have as many
RUNS = 5
MATCH = (5.0, 50.0)  # [deg], [mm] within which a plane is a true surface's
DRAWING = ("plotly", "plotly.graph_objects", "plotly.subplots", "dash", "flask")


@dataclass(frozen=True)
class Found:
    """Planes of one method on one scan."""

    seconds: float  # median
    planes: np.ndarray  # (P, 4) normal and offset, the scanner's frame
    areas: np.ndarray | None = None  # (P,) [m^2] where the method tells


@dataclass(frozen=True)
class Score:
    """Against the truth."""

    surfaces: int  # true surfaces that a plane was found of
    wrong: int  # planes that are no surface
    normal: np.ndarray  # [deg] of those found
    offset: np.ndarray  # [mm]


def ours(scan: OrganisedScan) -> Found:
    """Line segments to validated planes."""
    segmenter, times = ScanSegmenter(), []
    for _ in range(RUNS):
        start = time.perf_counter()
        planes = segmenter.find_planes(scan)
        times.append(time.perf_counter() - start)
    rows = [[*valid.plane.normal, valid.plane.offset] for valid in planes.valid]
    return Found(float(np.median(times)), np.array(rows))


def pcl(scan: OrganisedScan) -> Found | None:
    """None: the program was not built."""
    points = scan.points[scan.valid].astype("<f4")
    header = (
        "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
        f"WIDTH {len(points)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(points)}\n"
        "DATA binary\n"
    )
    with tempfile.NamedTemporaryFile(suffix=".pcd") as file:
        file.write(header.encode() + points.tobytes())
        file.flush()
        command = ["rosrun", "safe_passage", "pcl_planes_bench", file.name]
        run = subprocess.run(
            [*command, str(RUNS), "0.04", str(LEAST_POINTS)],
            capture_output=True,
            text=True,
            check=False,
        )
    if run.returncode != 0:
        return None
    times, *planes = run.stdout.strip().splitlines()
    rows = [[float(v) for v in line.split()[:4]] for line in planes]
    return Found(1e-3 * float(np.median([float(v) for v in times.split()])), np.array(rows))


def open3d(scan: OrganisedScan) -> Found | None:
    """None: it is not installed (pip install --no-deps open3d-cpu: 100 MB, a bench extra).

    With its documentation's example's parameters; normals, which it needs, count.
    """
    library = import_open3d()
    if library is None:
        return None
    points = library.utility.Vector3dVector(scan.points[scan.valid].astype(float))
    times = []
    for _ in range(3):
        start = time.perf_counter()
        cloud = library.geometry.PointCloud(points)
        nearest = library.geometry.KDTreeSearchParamKNN(knn=30)
        cloud.estimate_normals(nearest)
        boxes = cloud.detect_planar_patches(
            normal_variance_threshold_deg=60,
            coplanarity_deg=75,
            outlier_ratio=0.75,
            min_plane_edge_length=0.0,
            min_num_points=LEAST_POINTS,
            search_param=nearest,
        )
        times.append(time.perf_counter() - start)
    rows = [[*box.R[:, 2], -float(box.R[:, 2] @ box.center)] for box in boxes]
    return Found(float(np.median(times)), np.array(rows))


def import_open3d() -> Any:
    """The module without its drawing, whose packages are not wanted; None: not installed."""
    for name in DRAWING:
        sys.modules.setdefault(name, MagicMock())
    try:
        return importlib.import_module("open3d")
    except (ImportError, OSError):
        return None


def score(found: Found, place: Place, scanner: Scanner, which: np.ndarray) -> Score:
    """Each plane against the true surfaces that have points enough; each surface's best counts."""
    surfaces, R, origin = place.surfaces(), scanner.rotation(), np.array(scanner.position)
    counts = np.bincount(which[which >= 0], minlength=len(surfaces))
    planes = found.planes.reshape(-1, 4)
    best: dict[int, tuple[float, float]] = {}
    matched = np.zeros(len(planes), bool)
    for i in np.flatnonzero(counts >= LEAST_POINTS):
        patch = surfaces[i]
        normal = np.cross(patch.along, patch.across)
        normal = normal / np.linalg.norm(normal)
        middle = np.array(patch.corner) + 0.5 * (np.array(patch.along) + np.array(patch.across))
        in_scan = (middle - origin) @ R
        for k, plane in enumerate(planes):
            angle = math.degrees(math.acos(min(1.0, abs(float(normal @ R @ plane[:3])))))
            off = 1e3 * abs(float(in_scan @ plane[:3] + plane[3]))
            if angle <= MATCH[0] and off <= MATCH[1]:
                matched[k] = True
                if i not in best or angle < best[i][0]:
                    best[int(i)] = (angle, off)
    errors = np.array(list(best.values())).reshape(-1, 2)
    return Score(len(best), int((~matched).sum()), errors[:, 0], errors[:, 1])


def ground_of_patchwork(scan: OrganisedScan, height: float) -> tuple[np.ndarray, float] | None:
    """(N,) bool of the scan's points, and [s]; None: not installed."""
    try:
        library = importlib.import_module("pypatchworkpp")
    except ImportError:
        return None
    parameters = library.Parameters()
    parameters.sensor_height = height
    parameters.min_range, parameters.max_range = 0.3, 30.0  # a room, no road
    points = Level.of(scan).points(scan.points[scan.valid].astype(float))
    cloud = np.column_stack([points, np.ones(len(points))]).astype(np.float32)
    quiet, kept = os.open(os.devnull, os.O_WRONLY), os.dup(1)
    os.dup2(quiet, 1)  # it greets on every start
    try:
        filter_ = library.patchworkpp(parameters)
        start = time.perf_counter()
        filter_.estimateGround(cloud)
        took = time.perf_counter() - start
    finally:
        os.dup2(kept, 1)
        os.close(quiet)
        os.close(kept)
    found = np.zeros(len(points), bool)
    found[np.asarray(filter_.getGroundIndices(), int)] = True
    return found, took
