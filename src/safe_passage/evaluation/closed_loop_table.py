"""Fig. 9 of paper 002 in figures: the same random runs with and without safety areas."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, replace
from typing import Sequence

import numpy as np

from safe_passage.core.geometry import compose
from safe_passage.evaluation.closed_loop import RunResult, run_scenario
from safe_passage.evaluation.oracle import KEEP, earliest_arrival
from safe_passage.evaluation.parallel import Workers, run_jobs
from safe_passage.evaluation.report import table
from safe_passage.evaluation.scenarios import KINDS, Scenario, ScenarioMaker
from safe_passage.evaluation.setting import Setting
from safe_passage.navigation import NavigatorParameters
from safe_passage.simulation.robots import Robot
from safe_passage.simulation.static_map import make_map
from safe_passage.simulation.walkers import Walker
from safe_passage.simulation.worlds import World

METHODS = ("none", "hog", "yolo", "tracked")  # tracked: persons of YOLO and of the tracker
SEED = 20_000  # of the scenarios, unless another is given
HOLD_TIME = 5.0  # [s] a person is remembered after the last detection
MOST_SECONDS = 120.0  # [s] a run may take
IN_VIEW = 0.5  # share of a person that is seen, from which on it counts as in view
CAUSES = {
    "not in view": "the camera had not seen half of the person before",
    "not detected": "it had, but no detection came of it",
    "forgotten": "it had been detected, but had no safety area any more",
    "known": "it had its safety area: costmap, navigator or the robot's inertia",
}
CELL = 0.05  # [m] of the costmap: how much nearer is within its resolution


ROWS = {  # of the table: fields of `Summary` and what they are
    "runs": "runs",
    "reached_share": "goals reached",
    "pallet_gap_median": "gap to the pallet, median [m]",
    "pallet_gap_max": "gap to the pallet, largest [m]",
    "min_distance": "least distance to the person [m]",
    "min_distance_median": "least distance of a run, median [m]",
    "min_distance_moving": "least distance while the robot drives [m]",
    "ways_existed": "runs in which 1.2 m could be kept",
    "violations": "of these, nearer than 1.2 m",
    "violations_within_cell": "of these, by less than a cell (0.05 m)",
    "violations_moving": "nearer than 1.2 m while the robot drives",
    "time_median": "time to the goal, median [s]",
    "time_lost_median": "time lost by the areas, median [s]",
    "time_lost_mean": "time lost by the areas, mean [s]",
    "bumps": "steps that ended at an obstacle",
    "seen_share": "person detected, share of cycles",
    "false_share": "false detection, share of cycles",
}


@dataclass(frozen=True)
class Task:
    """One run to be done."""

    setting: Setting
    kind: str  # of scenario, one of KINDS
    number: int  # of the scenario
    method: str  # one of METHODS
    seed: int = SEED
    detect_every: int = 1  # cycles of 0.1 s


@dataclass(frozen=True)
class Outcome:
    """A run, and whether it could have kept its distance."""

    number: int
    run: RunResult
    way_existed: bool  # for a robot that knew how the person would walk

    @property
    def violates(self) -> bool:
        """Nearer than KEEP although there was a way that keeps it."""
        return self.way_existed and self.run.min_distance < KEEP

    @property
    def within_cell(self) -> bool:
        """Whether KEEP is missed by no more than the costmap's resolution."""
        return self.run.min_distance >= KEEP - CELL

    @property
    def cause(self) -> str:
        """What went before the first moment nearer than KEEP; empty without a violation."""
        return why_near(self.run) if self.violates else ""

    @property
    def violates_moving(self) -> bool:
        """The same while it drove: not a person who walked up to it while it stood."""
        return self.way_existed and self.run.min_distance_moving < KEEP


@dataclass(frozen=True)
class Summary:
    """All runs of a kind of scenario by one method; distances from outline to person's middle."""

    kind: str
    method: str
    runs: int
    reached_share: float
    pallet_gap_median: float  # [m] of those that reached the goal
    pallet_gap_max: float  # [m]
    min_distance: float  # [m] of all runs
    min_distance_median: float  # [m] of the runs' least
    min_distance_moving: float  # [m] while the robot drove
    ways_existed: int  # runs in which the distance could be kept
    violations: int
    violations_within_cell: int  # of these, nearer by no more than a cell of the costmap
    violations_moving: int
    time_median: float  # [s] of those that reached the goal
    time_lost_median: float  # [s] against the same run without areas; of those that both finished
    time_lost_mean: float  # [s]
    bumps: int  # steps that ended at an obstacle
    seen_share: float  # of all cycles, the person was detected
    false_share: float  # of all cycles, somebody was detected where nobody was


def do_run(task: Task) -> Outcome:
    """Draw the task's scenario and run it."""
    world, robot = task.setting.load()
    navigator = NavigatorParameters(footprint=robot.footprint)
    scenario = draw_scenario(world, robot, navigator, task)
    run = run_scenario(
        world,
        robot,
        scenario,
        "yolo" if task.method == "tracked" else task.method,
        task.setting.load_costmap(),
        navigator,
        HOLD_TIME,
        task.number,
        MOST_SECONDS,
        task.detect_every,
        task.setting.load_tracker() if task.method == "tracked" else None,
    )
    run = replace(run, method=task.method)
    return Outcome(task.number, run, way_exists(world, robot, navigator, scenario))


def draw_scenario(
    world: World, robot: Robot, navigator: NavigatorParameters, task: Task
) -> Scenario:
    """The scenario of the task's seed, kind and number, whatever the method."""
    rng = np.random.default_rng((task.seed, KINDS.index(task.kind), task.number))
    return ScenarioMaker(world, make_map(world, robot.height), navigator).draw(task.kind, rng)


def way_exists(
    world: World, robot: Robot, navigator: NavigatorParameters, scenario: Scenario
) -> bool:
    """Whether the place before the pallet could be reached at KEEP from everybody."""
    walkers = [Walker(plan) for plan in scenario.people]
    people = [lambda time, w=w: (w.at(time).x, w.at(time).y) for w in walkers]
    before = compose(scenario.goal, (-navigator.approach_distance, 0.0, 0.0))
    arrival = earliest_arrival(
        make_map(world, robot.height),
        scenario.start,
        before,
        people,
        robot.drive.max_speed,
        MOST_SECONDS,
    )
    return math.isfinite(arrival)


def why_near(run: RunResult) -> str:
    """One of CAUSES, from what was seen until the robot first was nearer than KEEP."""
    near = np.flatnonzero(run.column("distance") < KEEP)
    until = int(near[0]) + 1 if len(near) else len(run.track)
    seen = np.flatnonzero(run.column("seen")[:until] > 0)
    if not len(seen):
        in_view = (run.column("visible")[:until] >= IN_VIEW).any()
        return "not detected" if in_view else "not in view"
    return "known" if run.column("remembered")[until - 1] else "forgotten"


def run_all(
    setting: Setting,
    runs: int,
    methods: Sequence[str],
    seed: int,
    workers: Workers,
    detect_every: int = 1,
) -> list[Outcome]:
    """`runs` scenarios of each kind by each method; the slow methods first, so that none waits.

    detect_every: cycles of 0.1 s the detector is asked.
    """
    order = sorted(methods, key=METHODS.index, reverse=True)
    tasks = [
        Task(setting, kind, number, method, seed, detect_every)
        for method in order
        for kind in KINDS
        for number in range(runs)
    ]
    return run_jobs(do_run, tasks, workers, "closed-loop runs")


def summarise(outcomes: Sequence[Outcome], kind: str, method: str) -> Summary:
    """Figures of the runs of this kind and method."""
    chosen = [o for o in outcomes if (o.run.kind, o.run.method) == (kind, method)]
    runs = [o.run for o in chosen]
    reached = [run for run in runs if run.reached]
    near = [o for o in chosen if o.violates]
    lost = time_lost(outcomes, kind, method)
    return Summary(
        kind,
        method,
        len(runs),
        len(reached) / len(runs) if runs else math.nan,
        _median([run.pallet_gap for run in reached]),
        max((run.pallet_gap for run in reached), default=math.nan),
        min((run.min_distance for run in runs), default=math.nan),
        _median([run.min_distance for run in runs]),
        min((run.min_distance_moving for run in runs), default=math.nan),
        sum(o.way_existed for o in chosen),
        len(near),
        sum(o.within_cell for o in near),
        sum(o.violates_moving for o in chosen),
        _median([run.seconds for run in reached]),
        _median(lost),
        float(np.mean(lost)) if lost else math.nan,
        sum(run.bumps for run in runs),
        _share(runs, "seen"),
        _share(runs, "false"),
    )


def time_lost(outcomes: Sequence[Outcome], kind: str, method: str) -> list[float]:
    """[s] that each run took longer than its twin without areas; where both reached the goal."""
    times = {
        (o.run.method, o.number): o.run.seconds
        for o in outcomes
        if o.run.kind == kind and o.run.reached
    }
    numbers = sorted(number for name, number in times if name == method)
    return [times[method, n] - times["none", n] for n in numbers if ("none", n) in times]


def summaries(outcomes: Sequence[Outcome]) -> list[Summary]:
    """Of every kind and method that was run."""
    present = {(o.run.kind, o.run.method) for o in outcomes}
    order = [(kind, method) for kind in KINDS for method in METHODS]
    return [summarise(outcomes, *pair) for pair in order if pair in present]


def as_markdown(found: Sequence[Summary], outcomes: Sequence[Outcome]) -> str:
    """A column for each kind and method; then what went before each violation."""
    header = ["", *(f"{s.kind}, {'no areas' if s.method == 'none' else s.method}" for s in found)]
    rows = [[text, *(getattr(s, key) for s in found)] for key, text in ROWS.items()]
    causes = Counter((o.run.kind, o.run.method, o.cause) for o in outcomes if o.violates)
    kinds = [(s.kind, s.method) for s in found if s.method != "none"]
    reasons = [
        [f"{name}: {text}", *(causes[(*pair, name)] for pair in kinds)]
        for name, text in CAUSES.items()
    ]
    return "\n\n".join(
        [
            "# Closed loop: to a pallet, past a person",
            table(header, rows),
            "Before the robot was nearer than 1.2 m although there was a way that keeps it:",
            table(["", *(f"{kind}, {method}" for kind, method in kinds)], reasons),
        ]
    )


def as_values(outcome: Outcome) -> dict:
    """A run for JSON, without its track."""
    run = outcome.run
    return {
        "kind": run.kind,
        "number": outcome.number,
        "method": run.method,
        "state": run.state.name,
        "seconds": run.seconds,
        "min_distance": run.min_distance,
        "min_distance_moving": run.min_distance_moving,
        "pallet_gap": run.pallet_gap,
        "bumps": run.bumps,
        "way_existed": outcome.way_existed,
        "violates": outcome.violates,
        "cause": outcome.cause,
        "violates_moving": outcome.violates_moving,
    }


def _share(runs: Sequence[RunResult], column: str) -> float:
    """Of all cycles, those in which this column of the track is not 0."""
    cycles = [run.column(column) > 0 for run in runs]
    return float(np.concatenate(cycles).mean()) if cycles else math.nan


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if values else math.nan
