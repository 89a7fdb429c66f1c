"""How well the obstacle tracker tracks: `python3 -m safe_passage.evaluation.tracking_report`.

A line a scenario; with --ablation what each of the paper's extensions adds (paper 000, 6).
"""

from __future__ import annotations

import argparse
import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Sequence

import yaml

from safe_passage.core.errors import SafePassageError
from safe_passage.evaluation.parallel import Workers, run_jobs
from safe_passage.evaluation.tracking_catalogue import TUNING_SEED, Catalogue
from safe_passage.evaluation.tracking_diagnosis import as_text
from safe_passage.evaluation.tracking_metrics import Score, identities, score
from safe_passage.evaluation.tracking_plots import draw_tracks
from safe_passage.evaluation.tracking_recording import merged, recordings
from safe_passage.evaluation.tracking_runs import ABLATION, follow, tracker_parameters
from safe_passage.evaluation.tracking_scenarios import TrackingScenario
from safe_passage.monitoring.parameters import TrackerParameters

CONFIG = Path(__file__).resolve().parents[3] / "config"
EVERY = 2  # the tracker runs at the scanners' rate of 12.5 Hz; 1: whenever one of them has measured
HEADER = (
    "| {:22} | MOTA | MOTP [m] | IDF1 | people | misses | false pos. | switches | ids "
    "| static tracks | false moving |"
)


@dataclass(frozen=True)
class Job:
    """One scenario with one set of parameters."""

    scenario: TrackingScenario
    parameters: TrackerParameters
    every: int = EVERY
    plot: Path | None = None
    why: bool = False


@dataclass(frozen=True)
class Line:
    """What came out."""

    scenario: str
    score: Score
    ids: int  # most that one person had
    diagnosis: str = ""


def judge(job: Job) -> Line:
    """Run the tracker over the scenario's recording, which must be in the cache."""
    scenario = job.scenario
    recording = merged(recordings([scenario], Workers())[0], job.every)
    cycles = follow(recording, job.parameters)
    if job.plot:
        draw_tracks(recording, cycles, job.parameters, job.plot / f"{scenario.name}.png")
    ids = [len(own) for own in identities(recording, cycles).values()]
    diagnosis = as_text(recording, cycles) if job.why else ""
    return Line(scenario.name, score(recording, cycles), max(ids, default=0), diagnosis)


def judge_all(
    scenarios: Sequence[TrackingScenario],
    parameters: TrackerParameters,
    workers: Workers,
    every: int = EVERY,
    plot: Path | None = None,
    why: bool = False,
) -> list[Line]:
    """A line for each scenario."""
    recordings(scenarios, workers)  # fills the cache
    jobs = [Job(scenario, parameters, every, plot, why) for scenario in scenarios]
    return run_jobs(judge, jobs, workers, "tracking")


def total(lines: Sequence[Line]) -> Line:
    """All scenarios as one."""
    return Line(
        "all", sum((line.score for line in lines), Score()), max(line.ids for line in lines)
    )


def as_markdown(lines: Sequence[Line], first: str = "scenario") -> str:
    """A table."""
    header = HEADER.format(first)
    rule = "|---" * (header.count("|") - 1) + "|"
    return "\n".join([header, rule, *map(_row, lines)])


def _row(line: Line) -> str:
    s = line.score
    return (
        f"| {line.scenario:22} | {s.mota:.3f} | {s.motp:.3f} | {s.idf1:.3f} | {s.objects} "
        f"| {s.misses} | {s.false_positives} | {s.switches} | {line.ids} | {s.static_tracks} "
        f"| {s.false_moving} = {s.false_moving_share:.2%} |"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns its exit status."""
    args = _parser().parse_args(arguments)
    workers = Workers(args.processes)
    try:
        catalogue = Catalogue(args.config, args.seed, args.cameras)
        names = [n for n in catalogue.names() if not args.only or any(o in n for o in args.only)]
        scenarios = [catalogue.make(name) for name in names]
        if args.ablation:
            rows = []
            for name, changes in ABLATION.items():
                parameters = tracker_parameters(args.config, {**args.set, **changes})
                found = total(judge_all(scenarios, parameters, workers, args.every))
                rows.append(Line(name, found.score, found.ids))
            print(as_markdown(rows, "tracker"))
        else:
            parameters = tracker_parameters(args.config, args.set)
            lines = judge_all(scenarios, parameters, workers, args.every, args.plot, args.why)
            if args.why:
                print("\n".join(line.diagnosis for line in lines))
            print(as_markdown([*lines, total(lines)]))
    except SafePassageError as error:
        print(f"tracking_report: {error}", file=sys.stderr)
        return 1
    return 0


class _Set(argparse.Action):
    """--set KEY=VALUE ...: a dictionary."""

    def __call__(self, parser: Any, namespace: Any, values: Any, option: Any = None) -> None:
        pairs = dict(text.split("=", 1) for text in values)
        setattr(namespace, self.dest, {key: yaml.safe_load(text) for key, text in pairs.items()})


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="tracking_report", description=__doc__)
    parser.add_argument("--config", type=Path, default=CONFIG, metavar="FOLDER")
    parser.add_argument("--seed", type=int, default=TUNING_SEED, metavar="N", help="%(default)s")
    parser.add_argument(
        "--cameras",
        type=float,
        default=0.0,
        metavar="HZ",
        help="depth cameras, too (default: %(default)s)",
    )
    parser.add_argument("--ablation", action="store_true", help="what each extension adds")
    parser.add_argument("--only", nargs="+", default=[], metavar="NAME", help="parts of names")
    parser.add_argument(
        "--set", nargs="+", action=_Set, default={}, metavar="KEY=VALUE", help="tracker parameters"
    )
    parser.add_argument(
        "--every", type=int, default=EVERY, metavar="N", help="cycles of 0.04 s that are one"
    )
    parser.add_argument("--why", action="store_true", help="say when and why people were missed")
    parser.add_argument("--plot", type=Path, metavar="FOLDER", help="draw a picture a scenario")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1, metavar="N")
    return parser


if __name__ == "__main__":
    sys.exit(main())
