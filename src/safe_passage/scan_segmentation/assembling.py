"""Scan lines of a 2D scanner that turns, put together to one scan a sweep (paper 003, II)."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

import numpy as np

from safe_passage.core.errors import ParameterError
from safe_passage.core.parameters import check_range
from safe_passage.scan_segmentation.scan import OrganisedScan

# T_turning_laser of equations 1 to 3: a beam at angle 0 is normal to the axis, one at 90 deg on it
MOUNT = np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])


@dataclass(frozen=True)
class AssemblingParameters:
    """What becomes one cloud."""

    sweep: float = 2.0 * math.pi  # [rad] of a cloud; pi where both halves of a line are used
    alpha_min: float = 0.0  # [rad] beams of a line that are used: the paper's half
    alpha_max: float = 0.5 * math.pi  # [rad] the beam at it is not: 180 of half a degree
    max_lines: int = 4000  # of a cloud; what turns more slowly is thinned out
    max_step: float = 0.2  # [rad] between neighbouring lines: more is a gap, the sweep begins anew
    max_pause: float = 1.0  # [s] that it may stand still: later the robot may have moved

    def __post_init__(self) -> None:
        check_range("sweep", self.sweep, 0.1, 2.0 * math.pi, "rad")
        check_range("alpha_min", self.alpha_min, -2.0 * math.pi, 2.0 * math.pi, "rad")
        check_range("alpha_max", self.alpha_max, -2.0 * math.pi, 2.0 * math.pi, "rad")
        if self.alpha_max <= self.alpha_min:
            raise ParameterError(f"alpha_max is {self.alpha_max}, must be above alpha_min")
        check_range("max_lines", self.max_lines, 8, 20_000, "")
        check_range("max_step", self.max_step, 0.001, 1.5, "rad")
        check_range("max_pause", self.max_pause, 0.01, 60.0, "s")


@dataclass(frozen=True)
class Line:
    """One scan of the 2D scanner, and how far it had turned."""

    stamp: float  # [s] of its first beam
    alpha: np.ndarray  # (W,) [rad] of the beams, the scanner's frame
    ranges: np.ndarray  # (W,) [m], NaN: no return
    remission: np.ndarray | None  # (W,) any scale
    beta: np.ndarray  # (W,) [rad] of the platform as each beam was measured
    mount: np.ndarray | None = None  # (4, 4) T_turning_laser; MOUNT without it

    def points(self) -> np.ndarray:
        """(W, 3) [m] equations 1 to 3, z along the axis; NaN: no return."""
        T = MOUNT if self.mount is None else self.mount
        ranges = np.where(np.isfinite(self.ranges), self.ranges, np.nan)
        flat = np.stack([np.cos(self.alpha), np.sin(self.alpha), 0.0 * self.alpha], axis=1)
        turning = (ranges[:, None] * flat) @ T[:3, :3].T + T[:3, 3]
        c, s = np.cos(self.beta), np.sin(self.beta)
        x, y, z = turning.T
        return np.stack([c * x - s * y, s * x + c * y, z], axis=1)

    def used(self, least: float, most: float) -> Line:
        """Its beams from `least` up to and without `most` [rad], to a hundredth of a degree."""
        inside = (self.alpha > least - 2e-4) & (self.alpha < most - 2e-4)
        remission = None if self.remission is None else self.remission[inside]
        return Line(
            self.stamp,
            self.alpha[inside],
            self.ranges[inside],
            remission,
            self.beta[inside],
            self.mount,
        )


class Step(enum.Enum):
    """What became of a line."""

    TAKEN = "taken"
    STANDING = "the scanner does not turn"  # or so slowly that lines are too many
    GAP = "lines are missing: the sweep begins anew"
    PAUSED = "the scanner stood still: the sweep begins anew"
    REVERSED = "the scanner turned back: the sweep begins anew"
    CHANGED = "the lines have other beams: the sweep begins anew"
    NO_BEAMS = "no beam between alpha_min and alpha_max"


@dataclass(frozen=True)
class Assembled:
    """A sweep."""

    scan: OrganisedScan  # a row a line, in the order of time
    beta: np.ndarray  # (H, W) [rad] of each beam, unwrapped along the rows
    first: float  # [s] stamp of its first line
    last: float  # [s] of its last


class ScanAssembler:
    """Gathers lines; of a finished sweep it remembers nothing but the line that begins the next."""

    def __init__(self, parameters: AssemblingParameters | None = None) -> None:
        self._p = parameters or AssemblingParameters()
        self._lines: list[Line] = []
        self._angles: list[float] = []  # [rad] of the lines, unwrapped

    def __len__(self) -> int:
        return len(self._lines)

    def restart(self) -> None:
        """Forget the sweep: the clock has jumped."""
        self._lines, self._angles = [], []

    def add(self, line: Line) -> tuple[Step, Assembled | None]:
        """What became of the line, and the sweep that it ended."""
        line = line.used(self._p.alpha_min, self._p.alpha_max)
        if not len(line.alpha):
            return Step.NO_BEAMS, None
        if not self._lines:
            self._begin(line)
            return Step.TAKEN, None
        pause = line.stamp - self._lines[-1].stamp
        turned = _wrapped(_middle(line) - self._angles[-1])
        broken = self._broken(line, turned, pause)
        if broken is not None:
            self._begin(line)
            return broken, None
        if abs(turned) < self._p.sweep / self._p.max_lines:
            return Step.STANDING, None
        angle = self._angles[-1] + turned
        # half a step short of a whole turn the first line comes again
        if abs(angle - self._angles[0]) + 0.5 * abs(turned) >= self._p.sweep:
            done = self._assembled()
            self._begin(line)
            return Step.TAKEN, done
        self._lines.append(line)
        self._angles.append(angle)
        return Step.TAKEN, None

    def _begin(self, line: Line) -> None:
        self._lines, self._angles = [line], [_middle(line)]

    def _broken(self, line: Line, turned: float, pause: float) -> Step | None:
        """Why the line does not go on with the sweep."""
        last = self._lines[-1]
        if len(line.alpha) != len(last.alpha) or not np.allclose(line.alpha, last.alpha, atol=1e-3):
            return Step.CHANGED
        stands = abs(turned) < self._p.sweep / self._p.max_lines
        twice = pause == 0.0 and stands  # the message came again
        if not (twice or 0.0 < pause <= self._p.max_pause):
            return Step.PAUSED
        if abs(turned) > self._p.max_step:
            return Step.GAP
        swept = self._angles[-1] - self._angles[0]
        back = swept * turned < 0.0 and not stands
        return Step.REVERSED if back else None

    def _assembled(self) -> Assembled:
        points = np.stack([line.points() for line in self._lines])
        angles = np.array(self._angles)
        middles = np.array([_middle(line) for line in self._lines])
        beta = np.stack([np.unwrap(line.beta) for line in self._lines])
        beta += (angles - middles)[:, None]
        remissions = [line.remission for line in self._lines if line.remission is not None]
        remission = np.stack(remissions) if len(remissions) == len(self._lines) else None
        scan = OrganisedScan(points.astype(np.float32), beta.mean(axis=1), remission)
        return Assembled(scan, beta, self._lines[0].stamp, self._lines[-1].stamp)


def _middle(line: Line) -> float:
    """[rad] of the platform in the middle of the line."""
    beta = np.unwrap(line.beta)
    return float(0.5 * (beta[0] + beta[-1]))


def _wrapped(angle: float) -> float:
    """The same in [-pi, pi)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi
