"""What is said of crossings: contacts that physics would have allowed to avoid, false stops, times.

A robot that stands when somebody walks into it does nobody harm: a touch is a contact if the robot
moves at that moment.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

import numpy as np

from safe_passage.evaluation.separation_crossings import SETTLE, STEP, Crossing
from safe_passage.evaluation.separation_runs import (
    DRIVE,
    FREE,
    Run,
    gaps,
    run_crossing,
    separation_parameters,
    undisturbed,
)
from safe_passage.separation import SeparationParameters
from safe_passage.simulation.drive import Twist, moved
from safe_passage.simulation.walkers import Walker

MOVES = 0.05  # [m/s] a slower robot stands
ARM = 0.7  # [m] from base's origin to the robot's corners, for turns
LOOKED_AT = 1.0  # [s] before a contact
OFTEN, WRONG = 0.3, 0.5  # share of cycles; [m/s]
DELAYS = (*np.arange(0.0, 5.0, 0.2), math.inf)  # [s] after which an oracle may begin to brake


@dataclass(frozen=True)
class Verdict:
    """Of one run."""

    number: int
    contact: bool  # they touched while the robot moved, though that could have been avoided
    bumped: bool  # the person walked into the robot, which stood
    avoidable: bool  # an oracle would have kept from a contact
    speed: float  # [m/s] of the robot when they touched, 0: they did not
    least: float  # [m] to the person's body while it moved
    free: float  # [m] the same if nobody had slowed it down
    stopped: bool
    reaction: float  # [s] from the first danger (by truth) to a slower command, NaN: no danger
    resume: float  # [s] from the last danger to the full command, NaN: no danger, or cut off
    why: str  # a contact or a stop came about, as far as the tracks tell


@dataclass(frozen=True)
class CrossingJob:
    """One crossing, with the monitor and with obstacles taken to stand."""

    crossing: Crossing
    config: Path


@dataclass(frozen=True)
class Outcome:
    """What became of it."""

    monitor: Verdict
    static: Verdict
    milliseconds: np.ndarray  # of the monitor's cycles


def judge_crossing(job: CrossingJob) -> Outcome:
    """Run both and judge them."""
    p = separation_parameters(job.config)
    runs = [run_crossing(job.crossing, job.config, static) for static in (False, True)]
    ours, static = (verdict(run, p) for run in runs)
    return Outcome(ours, static, runs[0].milliseconds)


def verdict(run: Run, p: SeparationParameters) -> Verdict:
    """Judge a run."""
    gap = gaps(run.poses, run.people, p)
    speed = speeds(run.twists)
    at_touch = touch_speed(gap, speed)
    hit = at_touch > MOVES
    avoidable = not hit or could_avoid(run, p)
    free = gaps(*undisturbed(run.crossing, run.crossing.seconds), p)
    reaction, resume = _times(run)
    return Verdict(
        run.crossing.number,
        hit and avoidable,
        bool((gap < 0.0).any()) and not hit,
        avoidable,
        at_touch,
        float(gap[speed > MOVES].min(initial=math.inf)),
        float(free.min()),
        bool((run.scale[run.stamps > SETTLE] <= 0.0).any()),
        reaction,
        resume,
        _why(run, hit),
    )


def touch_speed(gap: np.ndarray, speed: np.ndarray) -> float:
    """[m/s] of the robot when the gap (S,) is first below 0; 0: it never is."""
    touched = np.flatnonzero(gap < 0.0)
    return float(speed[touched[0]]) if len(touched) else 0.0


def speeds(twists: np.ndarray) -> np.ndarray:
    """(S,) [m/s] of the robot's fastest point, roughly."""
    return np.hypot(twists[:, 0], twists[:, 1]) + ARM * np.abs(twists[:, 2])


def could_avoid(run: Run, p: SeparationParameters) -> bool:
    """Whether a robot that knows everything would not have touched the person while it moved.

    From the step in which the person first came into a lidar's sight on, with the state that the
    robot had then, it may go on its way for any time, and then brake as hard as it can, without
    any reaction time.
    """
    crossing, seen = run.crossing, run.seen
    if seen >= len(run.poses):
        return False
    walker = Walker(crossing.person)
    start = tuple(run.poses[seen])
    times = np.arange(0.0, crossing.seconds - seen * STEP, STEP)
    people = np.array([(s.x, s.y) for s in (walker.at((seen + 1) * STEP + t) for t in times)])
    begins = max(0.0, SETTLE - seen * STEP)
    now = float(np.hypot(*run.twists[seen, :2]))
    full = crossing.command.forward
    for delay in DELAYS:
        speed = np.minimum(now + DRIVE.acceleration * np.maximum(times - begins, 0.0), full)
        if begins > 0.0:
            speed = np.where(times < begins, 0.0, speed)
        if math.isfinite(delay):
            at = np.interp(delay, times, speed)
            braked = np.maximum(at - DRIVE.acceleration * (times - delay), 0.0)
            speed = np.where(times < delay, speed, braked)
        way = np.concatenate([[0.0], np.cumsum(speed)[:-1] * STEP])
        curve = crossing.command.turn / full
        arc = Twist(1.0, 0.0, curve)
        poses = np.array([moved(start, arc, s) for s in way])
        if touch_speed(gaps(poses, people, p), speed) <= MOVES:
            return True
    return False


def _why(run: Run, hit: bool) -> str:
    """What was wrong with the person's track before the contact; else at the first stop."""
    stops = np.flatnonzero((run.scale <= 0.0) & (run.stamps > SETTLE))
    if not hit and not len(stops):
        return ""
    if not hit:
        person, deciding = run.track[stops[0], 4], run.deciding[stops[0]]
        return _of_track(run.track[stops[:1]]) if person == deciding else "another track"
    return _of_track(run.track[run.stamps > run.stamps[-1] - LOOKED_AT])


def _of_track(track: np.ndarray) -> str:
    """What is wrong with it (K, 5) most of the time; see Run."""
    if np.isnan(track[:, 0]).mean() > OFTEN:
        return "no track of its own"
    if (track[:, 2] == 0.0).mean() > OFTEN:
        return "not called moving"
    if len(np.unique(track[~np.isnan(track[:, 4]), 4])) > 1:
        return "its number changes"
    return "velocity is wrong" if np.nanmedian(track[:, 1]) > WRONG else "well tracked"


def _times(run: Run) -> tuple[float, float]:
    """Reaction and time to resume [s]."""
    if not run.danger.any():
        return math.nan, math.nan
    first, last = np.flatnonzero(run.danger)[[0, -1]]
    slower = np.flatnonzero(run.scale < 1.0)
    reaction = run.stamps[slower[0]] - run.stamps[first] if len(slower) else math.inf
    full = np.flatnonzero(run.scale[last:] >= FREE)
    resume = run.stamps[last + full[0]] - run.stamps[last] if len(full) else math.nan
    return float(reaction), float(resume)


def false_stops(verdicts: Sequence[Verdict], threshold: float) -> list[Verdict]:
    """Runs in which the robot was stopped, though nobody would have come nearer than so [m]."""
    return [one for one in verdicts if one.stopped and one.free >= threshold]
