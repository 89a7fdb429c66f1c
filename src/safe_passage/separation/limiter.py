"""How fast the robot may go: the largest scale of its command that keeps the distance."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from safe_passage.separation.distances import Table
from safe_passage.separation.parameters import SeparationParameters
from safe_passage.separation.robot_motion import Motion
from safe_passage.separation.zones import stopping_time

COARSE = np.linspace(0.0, 1.0, 11)
FINE = 10  # steps between two of those
LEAST = 0.02  # smaller scales are none
SAME = 1e-4  # [m] distances that differ by less are the same
TURNED = 0.5  # cosine between two commands from which on they are different motions


class Courses:
    """u (S, T) [s] at scales (S,) of a command, for a robot that now goes at the scale `now`."""

    def __init__(
        self, motion: Motion, now: float, times: np.ndarray, p: SeparationParameters
    ) -> None:
        self._t, self._now, self._reaction = times, now, p.reaction_time
        self._horizon = p.horizon + 0.5 * p.step
        self._braking = max(stopping_time(motion.speed, motion.turn, p), 1e-9)
        rising = motion.speed / p.acceleration, motion.turn / p.angular_deceleration
        self._speeding = max(*rising, 1e-9)

    @property
    def now(self) -> np.ndarray:
        """(1,) the scale at which the robot goes."""
        return np.array([self._now])

    @property
    def brake(self) -> np.ndarray:
        """(1, T) stops as soon as it can."""
        return self.stop(self.now)

    def stop(self, scale: np.ndarray) -> np.ndarray:
        """Goes on at the scale for the reaction time, then brakes and stands."""
        before = np.minimum(self._t, self._reaction)
        rate = scale[:, None]
        braked = np.clip(self._t - self._reaction, 0.0, rate * self._braking)
        return rate * before + rate * braked - 0.5 * braked**2 / self._braking

    def go_on(self, scale: np.ndarray) -> np.ndarray:
        """Goes on at the scale, once it has slowed down or sped up to it."""
        more = np.maximum(self._now - scale, 0.0)
        less = np.maximum(scale - self._now, 0.0)[:, None]
        rising = np.minimum(self._t, less * self._speeding)
        missed = less * rising - 0.5 * rising**2 / self._speeding
        return scale[:, None] * self._t + self.stop(more) - missed

    @property
    def half_speed(self) -> float:
        """[s] of braking until half of its speed is lost."""
        return 0.5 * self._now * self._braking

    def stands(self, scale: np.ndarray) -> np.ndarray:
        """(S,) [s] when it has stopped."""
        return self._reaction + scale * self._braking

    @property
    def reach(self) -> np.ndarray:
        """(T,) largest u; beyond the horizon only of who stops."""
        fastest = max(1.0, self._now)
        stopped = self.stop(np.array([fastest]))[0]
        return np.where(self._t <= self._horizon, fastest * self._t, stopped)


@dataclass(frozen=True)
class Allowed:
    """Scales in [0, 1]."""

    scale: float
    with_margin: float  # if the robot kept release_margin more
    inside: bool = False  # something is nearer than the distance to be kept
    hurry: bool = False  # stopping is in somebody's way: no time for a slow release


def largest_scale(
    table: Table,
    courses: Courses,
    times: np.ndarray,
    motion: Motion,
    hurries: bool,
    p: SeparationParameters,
) -> Allowed:
    """The largest scale at which the robot may go.

    A scale may be chosen if the robot, going on so, keeps the distance over the whole horizon; or
    if it does so by stopping after the next cycle; or if the way leads out of what is too near
    already; or if stopping is in somebody's way and going on leaves more room. Who `hurries` on so
    already needs a better reason to stop. What is too near only because it may have strayed from
    its way by then does not stop the robot, but makes it slow.
    """
    if motion.stands or not len(table.distance):
        return Allowed(1.0, 1.0)
    judge = _Judge(table, courses, times, motion, p)
    largest, with_margin = (_largest(judge, kept) for kept in (p.kept, p.kept + p.release_margin))
    cautious = _slow_scale(motion, p.cautious_speed, p)
    if largest < cautious:
        largest = max(largest, _cautiously(judge.without_growth(), cautious, p.kept))
    through = judge.best_way_through(p.kept, hurries) if largest <= 0.0 else 0.0
    scale = max(largest, through)
    return Allowed(scale, max(with_margin, through), judge.inside(p.kept), through > 0.0)


def _largest(judge: _Judge, kept: float) -> float:
    """The largest scale that may be chosen."""
    coarse = float(COARSE[judge.may(COARSE, kept)].max())
    if coarse >= 1.0:
        return coarse
    fine = np.linspace(coarse, coarse + COARSE[1], FINE, endpoint=False)
    found = float(fine[judge.may(fine, kept)].max(initial=coarse))
    return found if found >= LEAST else 0.0


def _cautiously(judge: _Judge, most: float, kept: float) -> float:
    """The largest of a few scales up to `most` that may be chosen."""
    scales = np.linspace(0.0, most, 5)
    return float(scales[judge.may(scales, kept)].max())


def _slow_scale(motion: Motion, speed: float, p: SeparationParameters) -> float:
    """The scale at which the robot has `speed` [m/s], and turns no faster than to escape."""
    return min(speed / max(motion.speed, 1e-9), p.escape_turn / max(motion.turn, 1e-9), 1.0)


class _Judge:
    """Whether scales may be chosen."""

    def __init__(
        self,
        table: Table,
        courses: Courses,
        times: np.ndarray,
        motion: Motion,
        p: SeparationParameters,
    ) -> None:
        self._table, self._courses, self._times, self._p = table, courses, times, p
        self._ahead = int(np.sum(times <= p.horizon + 0.5 * p.step))  # moments in the horizon
        self._brake = table.along(courses.brake)[:, 0]
        touched = self._brake + table.growth <= 0.0
        touched[touched[:, 0]] = False  # a robot in touch may leave
        self._touches = touched.any(axis=1)
        last = self._ahead - 1
        self._end = np.where(self._touches, np.minimum(touched.argmax(axis=1), last), last)
        self._escape = _slow_scale(motion, p.escape_speed, p)
        self._motion = motion
        plain = self._brake + table.growth
        # [m] less counts as a touch; but a robot in touch may leave
        half = 0.5 * plain[:, 0]
        self._clear = np.where(half > 0.0, np.minimum(p.clearance, half), -np.inf)
        # who is touched before half of its speed is gone had better get away
        self._braking_helps = bool(np.all(plain[:, times < courses.half_speed] > 0.0))

    def without_growth(self) -> _Judge:
        """The same if uncertainty stayed as it is; those who may come from anywhere still may."""
        table = self._table
        more = np.where(table.unknown[:, None], 0.0, table.growth - table.growth[:, :1])
        now = replace(table, growth=table.growth - more, distance=table.distance + more[:, None])
        return _Judge(now, self._courses, self._times, self._motion, self._p)

    def inside(self, kept: float) -> bool:
        """Whether something is too near already."""
        return bool((self._table.distance[:, 0, 0] < kept).any())

    def may(self, scale: np.ndarray, kept: float) -> np.ndarray:
        """(S,) bool; standing, 0, always may be chosen."""
        on = self._on(scale)
        stop = self._table.along(self._courses.stop(scale))
        # who may come from anywhere must be kept off until the robot stands, by stopping
        step = self._times[1]
        over = self._times > self._courses.stands(scale)[:, None] + step - 1e-9
        any_way = self._table.unknown
        stop[any_way] = np.where(over, np.inf, stop[any_way])
        enough = stop >= kept
        free = _all((on >= kept) | any_way[:, None, None]) & _all(enough[any_way])
        free |= _all(enough)
        out = self._leads_out(on, kept)
        if self.inside(kept):
            out &= (scale <= self._escape) | self._must_hurry(on.min(axis=(0, 2)))
        if self._braking_helps:
            out &= self._touches_nobody(on) | self._stands_before_a_touch(scale)
        return free | out | (scale == 0.0)

    def _leads_out(self, on: np.ndarray, kept: float) -> np.ndarray:
        """Never nearer than by braking, but for a little on the way; what is free stays free.

        If braking leads to a touch, it must be better until then; after that nothing is compared.
        """
        brake = self._brake[:, : self._ahead]
        floor = np.where(brake < kept, brake - self._p.tolerance, kept)
        n, end = np.arange(len(on)), self._end
        last = np.minimum(brake[n, end] + np.where(self._touches, SAME, -SAME), kept)
        after = np.arange(on.shape[2]) > end[:, None]
        better = (on >= floor[:, None]) | after[:, None]
        return _all(better) & (on[n, :, end] >= last[:, None]).all(axis=0)

    def _touches_nobody(self, on: np.ndarray) -> np.ndarray:
        """(S,) bool, if everybody keeps his way; on: (n, S, T) [m]."""
        plain = on + self._table.growth[:, None, : self._ahead]
        return _all(plain > self._clear[:, None, None])

    def _stands_before_a_touch(self, scale: np.ndarray) -> np.ndarray:
        """(S,) bool: who walks into a robot that stops after the next cycle finds it standing."""
        plain = self._table.along(self._courses.stop(scale)) + self._table.growth[:, None]
        stands = self._times >= self._courses.stands(scale)[:, None] + self._times[1]
        return _all((plain > self._clear[:, None, None]) | stands)

    def best_way_through(self, kept: float, hurries: bool) -> float:
        """The scale with most room if stopping is in somebody's way, 0: there is no better one.

        Growth is left out: it is the same for all of them.
        """
        growth = self._table.growth
        stopped = (self._brake + growth).min()
        if stopped >= kept or self._table.unknown.any():
            return 0.0
        on = self._on(COARSE) + growth[:, None, : self._ahead]
        least = on.min(axis=(0, 2))
        most = min(least.max(), kept)
        gain = -self._p.advantage if hurries else self._p.advantage
        if most <= max(self._p.clearance, stopped + gain):
            return 0.0
        return float(COARSE[least >= most - SAME].max())

    def _must_hurry(self, least: np.ndarray) -> np.ndarray:
        """Going out slowly would let somebody come nearer."""
        return least > self._on(np.array([self._escape])).min() + SAME

    def _on(self, scale: np.ndarray) -> np.ndarray:
        """(n, S, T) [m] going on, within the horizon."""
        return self._table.along(self._courses.go_on(scale)[:, : self._ahead])


class Release:
    """Falls at once; rises only after a while of more room than needed, and not all at once."""

    def __init__(self, p: SeparationParameters) -> None:
        self._p = p
        self.scale, self.hurries = 1.0, False
        self._good_since: float | None = None
        self._last: float | None = None
        self._command: np.ndarray | None = None

    def update(self, stamp: float, command: np.ndarray, allowed: Allowed) -> float:
        """The scale from now on, at most what is allowed.

        A command in another direction is another motion: what was held back does not hold it back.
        """
        elapsed = stamp - self._last if self._last is not None else 0.0
        self._last = stamp
        if self._is_other(command):
            self.scale, self._good_since = 1.0, None
        self.hurries = allowed.hurry
        better = min(allowed.with_margin, allowed.scale)
        if better <= self.scale:
            self._good_since = None
        elif allowed.hurry:
            self.scale = better
        elif self._good_since is None:
            self._good_since = stamp
        elif stamp - self._good_since >= self._p.release_time:
            self.scale = min(better, self.scale + self._p.rise_rate * elapsed)
        self.scale = min(self.scale, allowed.scale)
        return self.scale

    def tune(self, parameters: SeparationParameters) -> None:
        """Go on from the scale there is."""
        self._p = parameters

    def stop(self, stamp: float) -> None:
        """Start again from standing."""
        self.hurries = False
        self.scale, self._good_since, self._last, self._command = 0.0, None, stamp, None

    def _is_other(self, command: np.ndarray) -> bool:
        if not command.any():
            return False
        last, self._command = self._command, command
        if last is None:
            return False
        lengths = math.hypot(*last) * math.hypot(*command)
        return float(last @ command) < TURNED * lengths


def _all(true: np.ndarray) -> np.ndarray:
    """(S,) whether all of (n, S, T) are."""
    return true.all(axis=(0, 2))
