"""segment_scan: where a robot fits, of files with scans; no roscore."""

from __future__ import annotations

import argparse
import functools
import math
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Mapping, Sequence

import cv2
import numpy as np

from safe_passage.core.errors import InputError, SafePassageError
from safe_passage.evaluation.parallel import Workers, run_jobs
from safe_passage.scan_segmentation.configuration import read_configuration
from safe_passage.scan_segmentation.organise import organise
from safe_passage.scan_segmentation.parameters import RobotConfiguration, SegmentationParameters
from safe_passage.scan_segmentation.picture import draw
from safe_passage.scan_segmentation.pipeline import ScanSegmenter, Segmentation
from safe_passage.scan_segmentation.reading import ENDINGS, read_cloud
from safe_passage.scan_segmentation.scan import SegmentationError, Vector
from safe_passage.scan_segmentation.visualisation import pictured
from safe_passage.scan_segmentation.writing import as_values, write_json, write_map, write_ply

EPILOG = """
For each FILE a folder of its name under --out: planes.json (planes, doors, stairs), drivable.png
and .pgm + .yaml (for map_server) for the robot's centre, basic.* for what stands where,
result.ply, picture.png. A scan that does not support a result is refused with its reason: then
the folder holds refused.json alone. The exit status is 0 where every file was segmented or
refused, 1 where one could not be read.
"""


@dataclass(frozen=True)
class Job:
    """One file."""

    file: Path
    out: Path
    robot: str
    robots: Mapping[str, RobotConfiguration]
    parameters: SegmentationParameters
    up: Vector
    axis: Vector | None
    origin: Vector | None
    walls: bool


def main(config: Path, arguments: Sequence[str] | None = None) -> int:
    """The command line.

    Args:
        config: folder with scan_segmentation.yaml.
    """
    args = _parser(config).parse_args(arguments)
    try:
        robots, parameters = read_configuration(args.config)
        if args.robot and args.robot not in robots:
            raise InputError(f"--robot {args.robot}: known are {', '.join(robots)}")
        robot = args.robot or next(iter(robots))
        jobs = [
            Job(
                f.absolute(),
                out,
                robot,
                robots,
                parameters,
                args.up,
                args.axis,
                args.origin,
                args.walls,
            )
            for f, out in zip(args.files, _folders(args.files, args.out.absolute()))
        ]
        workers = Workers(min(args.jobs, len(jobs)), args.dask)
        lines = run_jobs(segment_file, jobs, workers, "scans")
    except SafePassageError as error:
        print(f"segment_scan: {error}", file=sys.stderr)
        return 1
    for _, line in lines:
        print(line)
    return int(not all(well for well, _ in lines))


def segment_file(job: Job) -> tuple[bool, str]:
    """Whether the file could be read, and a line about it."""
    try:
        scan = organise(read_cloud(job.file), job.up, job.axis, job.origin)
        job.out.mkdir(parents=True, exist_ok=True)
        for old in job.out.glob("*"):
            if old.name in WRITTEN:
                old.unlink()  # a refused scan must not stand beside an older result
        found = ScanSegmenter(job.parameters).segment(scan, job.robots[job.robot], job.robots)
    except SegmentationError as refused:
        values = {"file": job.file.name, "reason": refused.reason.name, "detail": str(refused)}
        write_json(job.out / "refused.json", values)
        return True, f"{job.file}: REFUSED, {refused}"
    except (SafePassageError, OSError) as error:
        return False, f"{job.file}: cannot be used, {error}"
    _write(job, found)
    return True, f"{job.file}: {summary(found)}"


WRITTEN = frozenset(
    ["planes.json", "result.ply", "picture.png", "refused.json"]
    + [f"{stem}.{end}" for stem in ("basic", "drivable") for end in ("png", "pgm", "yaml")]
)


def summary(found: Segmentation) -> str:
    """One line."""
    drivable = np.isin(found.drivable.cells, (1, 2)).sum() * found.drivable.resolution**2
    parts = [
        f"{len(found.planes.valid)} planes, {len(found.ground)} of them ground",
        f"{drivable:.1f} m^2 drivable",
        f"{len(found.doors)} doors ({sum(bool(d.passable_by) for d in found.doors)} passable)",
        f"{len(found.stairs)} stairs",
        f"{sum(found.seconds.values()):.2f} s",
    ]
    return ", ".join([*parts, *found.planes.notes])


def _write(job: Job, found: Segmentation) -> None:
    shapes = pictured(found)
    values: dict[str, Any] = {"file": job.file.name, "robot": job.robot, **as_values(found)}
    write_json(job.out / "planes.json", values)
    write_map(job.out / "drivable", found.drivable)
    write_map(job.out / "basic", found.basic)
    write_ply(job.out / "result.ply", found, shapes, job.walls)
    title = f"{job.file.name}, robot '{job.robot}': {summary(found)}"
    cv2.imwrite(str(job.out / "picture.png"), draw(found, shapes, title))


def _folders(files: Sequence[Path], out: Path) -> list[Path]:
    """A folder of each file's name; files of the same name get numbers."""
    found: list[Path] = []
    for file in files:
        folder, number = out / file.stem, 2
        while folder in found:
            folder, number = out / f"{file.stem}_{number}", number + 1
        found.append(folder)
    return found


def _vector(text: str, unit: bool) -> Vector:
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r}: must be three numbers x,y,z") from None
    length = math.sqrt(x * x + y * y + z * z)
    if not math.isfinite(length) or (unit and length < 1e-9):
        raise argparse.ArgumentTypeError(f"{text!r}: is no direction")
    return (x / length, y / length, z / length) if unit else (x, y, z)


def _positive(text: str) -> int:
    if int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text} is less than 1")
    return int(text)


def _parser(config: Path) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="segment_scan", description=__doc__, epilog=EPILOG)
    direction = functools.partial(_vector, unit=True)
    add = parser.add_argument
    add("files", type=Path, nargs="+", metavar="FILE", help=f"{', '.join(ENDINGS)}")
    add("--out", type=Path, default=Path("segmentation"), metavar="FOLDER", help="%(default)s")
    add("--jobs", type=_positive, default=1, metavar="N", help="files at once")
    add("--dask", default="", metavar="ADDRESS", help="of a scheduler, whose workers see the files")
    add("--robot", default="", metavar="NAME", help="configuration; the first one without it")
    add("--config", type=Path, default=config / "scan_segmentation.yaml", metavar="YAML")
    add("--up", type=direction, default=(0.0, 0.0, 1.0), metavar="X,Y,Z", help="against gravity")
    add("--axis", type=direction, metavar="X,Y,Z", help="of the rotation; estimated without it")
    place = functools.partial(_vector, unit=False)
    add("--origin", type=place, metavar="X,Y,Z", help="[m] of the scanner; as the file has it")
    add("--walls", action="store_true", help="outlines of walls in result.ply, too")
    return parser
