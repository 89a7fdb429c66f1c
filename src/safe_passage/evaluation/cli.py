"""evaluate: the paper's tables and closed loop, on simulated data with exact truth."""

from __future__ import annotations

import argparse
import dataclasses
import sys
from pathlib import Path
from typing import Callable, Sequence

import numpy as np

from safe_passage.core.errors import InputError, SafePassageError
from safe_passage.evaluation import (
    closed_loop_table,
    dataset,
    detector_report,
    leg_report,
    plots,
    tracking_real_report,
)
from safe_passage.evaluation.parallel import Workers
from safe_passage.evaluation.report import write_report
from safe_passage.evaluation.setting import Setting
from safe_passage.evaluation.tracking_real import RealRecording

TrackingRecordings = Callable[[Path, Sequence[str]], Sequence[RealRecording]]
Recordings = Callable[[Sequence[Path], Sequence[Path]], leg_report.Recordings]
EPILOG = """
Results do not depend on the number of processes. Each command writes a Markdown table, which it
also prints, JSON with everything in detail, and pictures.
"""


def main(
    config: Path,
    read_recordings: Recordings,
    arguments: Sequence[str] | None = None,
    read_tracking: TrackingRecordings | None = None,
) -> int:
    """Run the command line; returns its exit status.

    Args:
        config: folder of the package's worlds, robots and costmap.
        read_recordings: positive bags, negative bags -> segments and scans; knows ROS's bags.
        read_tracking: folder, parts of names -> what the obstacle tracker is judged by; the same.
    """
    args = _parser(config).parse_args(arguments)
    try:
        if args.command == "recordings":
            _recordings(args, config, read_tracking)
            return 0
        setting = Setting(args.world, args.robot, args.costmap, args.tracker)
        workers = Workers(args.processes, args.dask)
        if args.command == "legs":
            _legs(args, setting, workers, read_recordings)
        else:
            COMMANDS[args.command](args, setting, workers)
    except SafePassageError as error:
        print(f"evaluate: {error}", file=sys.stderr)
        return 1
    return 0


def _dataset(args: argparse.Namespace, setting: Setting, workers: Workers) -> None:
    dataset.write_dataset(args.out, setting, args.first, args.frames, args.clouds, workers)
    print(f"{args.frames} views in {args.out}")


def _detector(args: argparse.Namespace, setting: Setting, workers: Workers) -> None:
    source: Setting | Path = args.dataset or setting
    first, frames = args.first, args.frames
    if args.dataset:
        first, frames = 0, min(len(dataset.Dataset(args.dataset)), args.frames)
    report = detector_report.judge_detectors(source, first, frames, args.methods, workers)
    markdown = detector_report.as_markdown(report)
    write_report(args.out, "detector", markdown, detector_report.as_values(report))
    plots.draw_detectors(report, args.out / "detector.png")
    print(markdown)


def _legs(
    args: argparse.Namespace, setting: Setting, workers: Workers, read_recordings: Recordings
) -> None:
    if args.negative and not args.positive:
        raise InputError("--negative: a model needs positive recordings, too")
    recordings = read_recordings(args.positive, args.negative) if args.positive else None
    report = leg_report.judge_legs(setting, args.first, args.runs, recordings, workers, _say)
    markdown = leg_report.as_markdown(report)
    write_report(args.out, "legs", markdown, leg_report.as_values(report))
    looked_at = next(iter(report.segments.values()))
    plots.draw_legs(leg_report.examples(looked_at), args.out / "legs.png")
    print(markdown)


def _closed_loop(args: argparse.Namespace, setting: Setting, workers: Workers) -> None:
    outcomes = closed_loop_table.run_all(
        setting, args.runs, args.methods, args.first, workers, args.detect_every
    )
    found = closed_loop_table.summaries(outcomes)
    markdown = closed_loop_table.as_markdown(found, outcomes)
    runs = [closed_loop_table.as_values(outcome) for outcome in outcomes]
    values = {"summaries": [dataclasses.asdict(one) for one in found], "runs": runs}
    write_report(args.out, "closed_loop", markdown, values)
    tracks = {f"{o.run.kind}_{o.number}_{o.run.method}": o.run.track for o in outcomes}
    np.savez_compressed(args.out / "tracks.npz", **tracks)
    plots.draw_distances(outcomes, args.out / "distances.png")
    plots.draw_tracks(outcomes, setting, args.out / "tracks.png")
    print(markdown)


def _recordings(
    args: argparse.Namespace, config: Path, read_tracking: TrackingRecordings | None
) -> None:
    if read_tracking is None:
        raise InputError("recordings: nobody here can read bags")
    recordings = read_tracking(args.folder, args.only)
    results = tracking_real_report.judge_all(recordings, config, args.out)
    markdown = tracking_real_report.as_markdown(results)
    write_report(args.out, "recordings", markdown, tracking_real_report.as_values(results))
    print(markdown)


COMMANDS = {"dataset": _dataset, "detector": _detector, "closed-loop": _closed_loop}


def _parser(config: Path) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="evaluate", description=__doc__, epilog=EPILOG)
    commands = parser.add_subparsers(dest="command", required=True)

    def command(name: str, text: str, first: int) -> argparse.ArgumentParser:
        added = commands.add_parser(name, help=text, description=text)
        usual = Setting.of(config)
        for key, path in (
            ("world", usual.world),
            ("robot", usual.robot),
            ("costmap", usual.costmap),
            ("tracker", usual.tracker),
        ):
            added.add_argument(f"--{key}", type=Path, default=path, metavar="YAML")
        added.add_argument("--out", type=Path, default=Path(f"evaluation/{name}"), metavar="FOLDER")
        added.add_argument(
            "--seed",
            dest="first",
            type=_at_least(0),
            default=first,
            metavar="N",
            help="%(default)s",
        )
        added.add_argument("--processes", type=_at_least(1), default=1, metavar="N")
        added.add_argument("--dask", default="", metavar="ADDRESS", help="of a running scheduler")
        return added

    views = command("dataset", "write simulated views with their truth", detector_report.FIRST_VIEW)
    views.add_argument("--frames", type=_at_least(1), default=1000, metavar="N")
    views.add_argument("--clouds", action="store_true", help="write a PCD of each view, too")
    detector = command("detector", "table 3: the person detector", detector_report.FIRST_VIEW)
    detector.add_argument("--frames", type=_at_least(1), default=1000, metavar="N")
    detector.add_argument("--dataset", type=Path, metavar="FOLDER", help="instead of drawing views")
    _add_methods(detector, ("hog", "yolo"))
    legs = command("legs", "tables 1 and 2: persons by their legs", leg_report.FIRST_RUN)
    legs.add_argument("--runs", type=_at_least(2), default=60, metavar="N", help="simulated")
    legs.add_argument("--positive", type=Path, nargs="+", default=[], metavar="BAG")
    legs.add_argument("--negative", type=Path, nargs="+", default=[], metavar="BAG")
    loop = command("closed-loop", "fig. 9: runs among people", closed_loop_table.SEED)
    loop.add_argument("--runs", type=_at_least(1), default=50, metavar="N", help="of each kind")
    loop.add_argument(
        "--detect-every", type=_at_least(1), default=1, metavar="N", help="cycles of 0.1 s"
    )
    _add_methods(loop, closed_loop_table.METHODS)
    text = "the obstacle tracker on real recordings"
    real = commands.add_parser("recordings", help=text, description=text)
    real.add_argument("folder", type=Path, help="with lidar2d_legs and the like in it")
    real.add_argument("--only", nargs="+", default=[], metavar="NAME", help="parts of names")
    real.add_argument("--out", type=Path, default=Path("evaluation/recordings"), metavar="FOLDER")
    return parser


def _add_methods(parser: argparse.ArgumentParser, known: Sequence[str]) -> None:
    def listed(text: str) -> list[str]:
        names = list(dict.fromkeys(text.split(",")))
        if not set(names) <= set(known):
            raise argparse.ArgumentTypeError(f"{text!r}: known are {', '.join(known)}")
        return names

    parser.add_argument("--methods", type=listed, default=list(known), metavar=",".join(known))


def _at_least(least: int) -> Callable[[str], int]:
    def number(text: str) -> int:
        value = int(text)
        if value < least:
            raise argparse.ArgumentTypeError(f"{value} is less than {least}")
        return value

    return number


def _say(text: str) -> None:
    print(f"  {text}", file=sys.stderr, flush=True)
