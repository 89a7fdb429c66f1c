"""When the robot must not move, whatever the obstacles: one reason at a time, the worst first."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np

from safe_passage.separation.parameters import SeparationParameters

SLACK = 0.2  # [s] by which two ages of one track may disagree


class Reason(enum.IntEnum):
    """Why the robot is limited, as in SeparationState.msg."""

    OK = 0
    OBSTACLE = 1  # the distance would not be kept
    ESCAPE = 2  # something is too near already, the command leads away from it
    CLOCK_JUMP = 3
    NO_TRACKS = 4
    STALE_TRACKS = 5
    TRACKER_RESTARTED = 6
    NO_ODOMETRY = 7
    STALE_ODOMETRY = 8
    NO_TF = 9
    BAD_COMMAND = 10
    STALE_COMMAND = 11
    SENSOR_SILENT = 12


@dataclass(frozen=True)
class Inputs:
    """What has come in until now; None: never, or not since the clock jumped."""

    now: float  # [s]
    tracks: float | None  # [s] stamp of the last
    odometry: float | None  # [s] stamp of the last
    placed: bool = True  # tf knows where the robot and its arm are
    all_see: bool = True  # every sensor behind the tracks is alive


class Supervisor:
    """Judges the inputs. It releases by itself: nothing is latched but a tracker's settling."""

    def __init__(self, parameters: SeparationParameters) -> None:
        self._p = parameters
        self._life = _TrackerLife()
        self._jumped = False

    def tune(self, parameters: SeparationParameters) -> None:
        """Other parameters from the next judgement on; what is known of the tracker stays."""
        self._p = parameters

    def saw_tracks(self, stamp: float, ids: np.ndarray, ages: np.ndarray) -> None:
        """A message of tracks: stamp [s], ids (N,), ages (N,) [s]."""
        self._life.saw(stamp, ids, ages)

    def clock_jumped(self) -> None:
        """What came before has no meaning any more."""
        self._life = _TrackerLife()
        self._jumped = True

    def judge(self, inputs: Inputs) -> Reason:
        """OK, or why the robot must stand."""
        p = self._p
        fresh = Reason.OK
        if inputs.tracks is None:
            fresh = Reason.NO_TRACKS
        elif not -p.max_future <= inputs.now - inputs.tracks <= p.tracks_timeout:
            fresh = Reason.STALE_TRACKS
        elif inputs.odometry is None:
            fresh = Reason.NO_ODOMETRY
        elif not -p.max_future <= inputs.now - inputs.odometry <= p.odometry_timeout:
            fresh = Reason.STALE_ODOMETRY
        elif not inputs.placed:
            fresh = Reason.NO_TF
        elif not inputs.all_see:
            fresh = Reason.SENSOR_SILENT
        elif self._life.length < p.settle_time:
            fresh = Reason.TRACKER_RESTARTED
        if fresh is Reason.OK:
            self._jumped = False
        return Reason.CLOCK_JUMP if self._jumped else fresh


class _TrackerLife:
    """For how long the tracker has been at work, as its tracks tell."""

    def __init__(self) -> None:
        self._last: float | None = None
        self._began = self._oldest = 0.0
        self._born: dict[int, float] = {}
        self._newest = 0, 0.0  # highest number, and when that track began

    @property
    def length(self) -> float:
        """[s] at least"""
        return max(self._last - self._began, self._oldest) if self._last is not None else 0.0

    def saw(self, stamp: float, ids: np.ndarray, ages: np.ndarray) -> None:
        if self._last is None or stamp < self._last - SLACK:
            self._restart(stamp)
        self._last = stamp
        if not len(ids):
            return
        born = dict(zip(ids.tolist(), (stamp - ages).tolist()))
        if self._is_another(born):
            self._restart(stamp)
        self._born = born
        newest = max(born)
        if newest > self._newest[0]:
            self._newest = newest, born[newest]
        self._oldest = max(self._oldest, float(ages.max()))

    def _is_another(self, born: dict[int, float]) -> bool:
        """A track that got younger, or a low number on a track younger than a higher one's."""
        younger = any(born[i] > self._born[i] + SLACK for i in born.keys() & self._born.keys())
        highest, its_birth = self._newest
        return younger or any(i < highest and b > its_birth + SLACK for i, b in born.items())

    def _restart(self, stamp: float) -> None:
        self._began, self._oldest = stamp, 0.0
        self._born, self._newest = {}, (0, stamp)
