"""People made of capsules: enough of a body for a lidar, a depth camera and a person detector."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

STATURE = 1.75  # [m] the proportions below are those of a person this tall


@dataclass(frozen=True)
class Capsule:
    """All points within `radius` of the segment from `a` to `b`."""

    a: np.ndarray  # [m] (3,)
    b: np.ndarray  # [m] (3,)
    radius: float  # [m]
    colour: tuple[int, int, int]  # BGR


@dataclass(frozen=True)
class Clothes:
    """BGR colours."""

    jacket: tuple[int, int, int] = (60, 60, 200)
    trousers: tuple[int, int, int] = (90, 50, 30)
    skin: tuple[int, int, int] = (140, 170, 220)
    shoes: tuple[int, int, int] = (30, 30, 30)


@dataclass(frozen=True)
class Person:
    """Where a person stands (or is in its walk) and what it looks like."""

    x: float  # [m]
    y: float  # [m]
    yaw: float = 0.0  # [rad] the way it faces
    height: float = STATURE  # [m]
    stride: float = 0.0  # [rad] swing of the forward leg, 0: standing
    clothes: Clothes = field(default_factory=Clothes)

    def capsules(self) -> list[Capsule]:
        """The body in the world's frame."""
        scale = self.height / STATURE
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        place = np.array([self.x, self.y, 0.0])

        def part(
            a: tuple[float, float, float],
            b: tuple[float, float, float],
            radius: float,
            colour: tuple[int, int, int],
        ) -> Capsule:
            ends = [place + rotation @ (scale * np.array(end)) for end in (a, b)]
            return Capsule(ends[0], ends[1], scale * radius, colour)

        wear = self.clothes
        body = [
            part((0.0, 0.0, 1.64), (0.02, 0.0, 1.62), 0.105, wear.skin),  # head
            part((0.0, 0.0, 1.54), (0.0, 0.0, 1.44), 0.055, wear.skin),  # neck
            part((0.0, 0.12, 1.32), (0.0, -0.12, 1.32), 0.12, wear.jacket),  # shoulders
            part((0.0, 0.07, 1.30), (0.0, 0.07, 0.98), 0.125, wear.jacket),  # trunk
            part((0.0, -0.07, 1.30), (0.0, -0.07, 0.98), 0.125, wear.jacket),
            part((0.0, 0.06, 0.93), (0.0, -0.06, 0.93), 0.12, wear.trousers),  # hips
        ]
        for side in (1.0, -1.0):
            swing = side * self.stride
            body += _leg(part, side, swing, wear) + _arm(part, side, -swing, wear)
        return body


def _leg(part, side: float, swing: float, wear: Clothes) -> list[Capsule]:  # type: ignore[no-untyped-def]
    bend = 0.35 * abs(swing) if swing < 0.0 else 0.0  # the trailing knee bends
    knee = (0.45 * math.sin(swing), side * 0.1, 0.93 - 0.45 * math.cos(swing))
    ankle = (
        knee[0] + 0.42 * math.sin(swing - bend),
        side * 0.1,
        knee[2] - 0.42 * math.cos(swing - bend),
    )
    toe = (ankle[0] + 0.15, side * 0.1, ankle[2] - 0.02)
    return [
        part((0.0, side * 0.09, 0.93), knee, 0.08, wear.trousers),
        part(knee, ankle, 0.062, wear.trousers),
        part(ankle, toe, 0.045, wear.shoes),
    ]


def _arm(part, side: float, swing: float, wear: Clothes) -> list[Capsule]:  # type: ignore[no-untyped-def]
    shoulder = (0.0, side * 0.22, 1.36)
    elbow = (0.28 * math.sin(swing), side * 0.26, 1.36 - 0.28 * math.cos(swing))
    hand = (elbow[0] + 0.24 * math.sin(swing + 0.25), side * 0.27, elbow[2] - 0.24)
    return [
        part(shoulder, elbow, 0.055, wear.jacket),
        part(elbow, hand, 0.045, wear.jacket),
        part(hand, (hand[0], hand[1], hand[2] - 0.06), 0.04, wear.skin),
    ]
