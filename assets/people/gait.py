"""Standing and walking: where every bone goes. Feet that bear weight do not slip."""

from __future__ import annotations

import math

import numpy as np
from bodies import Body

STANCE = 0.62  # share of the cycle a foot is on the ground
FLAT_AT = 0.25  # phase of a leg at which its foot is under the hip
# Pitch of a foot [deg], toe up, over its own phase (0: heel strikes).
PITCH = np.array(
    [[0.0, 18], [0.05, 9], [0.10, 0], [0.36, 0], [0.46, -12], [0.54, -32], [0.62, -52],
     [0.68, -56], [0.76, -34], [0.84, -8], [0.92, 12], [1.0, 18]]
)  # fmt: skip
LIFT = np.array([[0.62, 0.0], [0.69, 0.03], [0.78, 0.03], [0.88, -0.01], [0.94, 0.0], [1.0, 0.0]])
CURL = 18.0  # [deg] of each joint of the fingers


def skinned(vertices: np.ndarray, weights: np.ndarray, transforms: np.ndarray) -> np.ndarray:
    """Linear blend skinning: (V, 3) rest vertices moved by (B, 4, 4) transforms."""
    blended = np.einsum("vb,bij->vij", weights, transforms)
    return np.einsum("vij,vj->vi", blended[:, :3, :3], vertices) + blended[:, :3, 3]


class Poser:
    """Transforms of a body's bones, for standing and for any phase of the walk.

    Args:
        body: rest pose, its bare soles at z = 0.
        sole: [m] of the shoes under them; poses stand with the shoes' soles at z = 0.
        stride: [m] walked in a cycle of two steps.
    """

    def __init__(self, body: Body, sole: float, stride: float) -> None:
        self.body, self.sole, self.stride = body, sole, stride
        self.hip_height = self._pelvis_curve()

    def standing(self, seed: int = 0) -> np.ndarray:
        """(B, 4, 4), at ease: weight a little on one leg, arms hanging."""
        rng = np.random.default_rng(seed)
        lean = rng.uniform(-1.0, 1.0)
        feet = {}
        for label, side in (("L", 1.0), ("R", -1.0)):
            x = 0.02 * side * lean
            feet[label] = (self._ankle(side * 0.085, x, 0.0, 0.0), 0.0, 0.0, side * 9.0)
        height = min(self._reach(*feet[label][0], label) for label in "LR") - 0.004
        arms = {label: (rng.uniform(-4, 4), 10.0, 14.0 + rng.uniform(-4, 8)) for label in "LR"}
        return self._pose(height, 0.0, 1.5 * lean, feet, arms, 0.0)

    def walking(self, phase: float) -> np.ndarray:
        """(B, 4, 4) at `phase` of the cycle, 0: the left heel strikes."""
        feet = {
            label: self._foot(side, (phase + shift) % 1.0)
            for label, side, shift in (("L", 1.0, 0.0), ("R", -1.0, 0.5))
        }
        height = self.hip_height(phase)
        swing = math.cos(2.0 * math.pi * phase)  # 1: left leg ahead
        vigour = self.stride / (0.75 * self.body.vertices[:, 2].max())
        arms = {}
        for label, sign in (("L", -1.0), ("R", 1.0)):  # arms go against their legs
            ahead = sign * swing * vigour
            arms[label] = (3.0 + 20.0 * ahead, 8.0, 20.0 + 11.0 * ahead)
        return self._pose(height, -4.0 * swing * vigour, 0.0, feet, arms, 7.0 * swing * vigour)

    def _foot(self, side: float, p: float) -> tuple[np.ndarray, float, float, float]:
        """Ankle (3,), pitch, toes' pitch, toe-out [deg] of a leg at its own phase `p`."""
        pitch = float(np.interp(p, PITCH[:, 0], PITCH[:, 1]))
        if p <= STANCE:
            ankle = self._ankle(0.07 * side, self.stride * (FLAT_AT - p), pitch, p)
            toes = max(pitch, 0.0)
        else:
            s = (p - STANCE) / (1.0 - STANCE)
            start = self._foot(side, STANCE)[0]
            end = self._foot(side, 0.0)[0]
            slope = -self.stride * (1.0 - STANCE) * 0.25
            h00, h10 = 2 * s**3 - 3 * s**2 + 1, s**3 - 2 * s**2 + s
            ankle = h00 * start + (1 - h00) * end
            ankle[0] += (h10 + s**3 - s**2) * slope
            ankle[2] += float(np.interp(p, LIFT[:, 0], LIFT[:, 1]))
            toes = max(pitch, 0.0) + min(pitch, 0.0) * min(1.0, 2.0 * s)
        return ankle, pitch, toes, side * 7.0

    def _ankle(self, y: float, x: float, pitch: float, p: float) -> np.ndarray:
        """Ankle over a foot on the ground that is flat at (x, y): it rolls over heel and ball."""
        joint = self.body.joint("foot.L")
        ball = self.body.joint("toe3-1.L")
        feet = self.body.vertices[self.body.dominated("foot")]
        heel = np.array([feet[:, 0].min() - 0.015, 0.0, -self.sole])
        pivot = (heel if pitch > 0.0 else ball) - joint
        pivot[1] = 0.0
        flat = np.array([x, y, joint[2] + self.sole])
        return flat + pivot - _about_y(-pitch) @ pivot

    def _reach(self, x: float, y: float, z: float, label: str, stretch: float = 0.997) -> float:
        """Greatest height of the hip joints [m] at which a leg still reaches its ankle."""
        side = 1.0 if label == "L" else -1.0
        hip_y = side * abs(self.body.joint("upperleg01.L")[1])
        thigh, shank = self._leg()
        return z + math.sqrt(max((stretch * (thigh + shank)) ** 2 - x**2 - (y - hip_y) ** 2, 0.0))

    def _leg(self) -> tuple[float, float]:
        hip, knee, ankle = (self.body.joint(f"{n}.L") for n in ("upperleg01", "lowerleg01", "foot"))
        return float(np.linalg.norm(knee - hip)), float(np.linalg.norm(ankle - knee))

    def _pelvis_curve(self):  # type: ignore[no-untyped-def]
        """Height of the hips over the phase: as high as both legs allow, smooth."""
        phases = np.arange(64) / 64.0
        bound = np.array(
            [
                min(self._reach(*self._foot(1.0, p)[0], "L"),
                    self._reach(*self._foot(-1.0, (p + 0.5) % 1.0)[0], "R"))
                for p in phases
            ]
        )  # fmt: skip
        wave = np.cos(4.0 * np.pi * phases[:, None] + np.array([0.0, -np.pi / 2.0]))
        a, b = 2.0 * (wave * (bound - bound.mean())[:, None]).mean(axis=0)
        scale = min(1.0, 0.03 / math.hypot(a, b))
        curve = scale * (wave @ np.array([a, b]))
        base = float((bound - curve).min())

        def height(phase: float) -> float:
            angle = 4.0 * math.pi * phase
            return base + scale * (a * math.cos(angle) + b * math.sin(angle))

        return height

    def _pose(
        self,
        hip_height: float,
        pelvis_yaw: float,
        lean: float,
        feet: dict[str, tuple[np.ndarray, float, float, float]],
        arms: dict[str, tuple[float, float, float]],
        twist: float,
    ) -> np.ndarray:
        body = self.body
        hips = 0.5 * (body.joint("upperleg01.L") + body.joint("upperleg01.R"))
        pelvis = np.eye(4)
        pelvis[:3, :3] = _about_z(pelvis_yaw)
        pelvis[:3, 3] = np.array([0.0, 0.0, hip_height]) - pelvis[:3, :3] @ hips
        turns = {"spine03": _about_z(0.5 * twist) @ _about_x(-lean), "spine01": _about_z(twist),
                 "neck01": _about_z(0.5 * twist) @ _about_x(lean), "head": np.eye(3)}  # fmt: skip
        ends: dict[str, np.ndarray] = {}
        for label in "LR":
            self._leg_turns(label, pelvis, feet[label], turns, ends)
            self._arm_turns(label, arms[label], twist, turns)
        transforms = np.zeros((len(body.labels), 4, 4))
        for i, (name, parent) in enumerate(zip(body.labels, body.parents)):
            above = pelvis if parent < 0 else transforms[parent]
            transforms[i] = above
            if name in turns:
                place = ends.get(name, above[:3, :3] @ body.joints[i] + above[:3, 3])
                transforms[i] = np.eye(4)
                transforms[i][:3, :3] = turns[name]
                transforms[i][:3, 3] = place - turns[name] @ body.joints[i]
        return transforms

    def _leg_turns(self, label, pelvis, foot, turns, ends) -> None:  # type: ignore[no-untyped-def]
        """Two-link inverse kinematics, the knee forward."""
        ankle, pitch, toes, out = foot
        rest = [self.body.joint(f"{n}.{label}") for n in ("upperleg01", "lowerleg01", "foot")]
        hip = pelvis[:3, :3] @ rest[0] + pelvis[:3, 3]
        thigh, shank = self._leg()
        span = ankle - hip
        reach = min(float(np.linalg.norm(span)), 0.9995 * (thigh + shank))
        along = span / np.linalg.norm(span)
        cosine = (thigh**2 + reach**2 - shank**2) / (2.0 * thigh * reach)
        bend = math.acos(min(1.0, cosine))
        ahead = _about_z(0.7 * out) @ np.array([1.0, 0.0, 0.0])
        ahead = _unit(ahead - (ahead @ along) * along)
        knee = hip + thigh * (math.cos(bend) * along + math.sin(bend) * ahead)
        hinge = _unit(np.cross(along, ahead))
        straight = np.array([0.0, 1.0, 0.0])  # hinge of the rest pose: legs straight, toes forward
        sign = 1.0 if hinge @ straight > 0.0 else -1.0
        for name, a, b, c, d in (
            ("upperleg01", rest[0], rest[1], hip, knee),
            ("lowerleg01", rest[1], rest[2], knee, ankle),
        ):
            turns[f"{name}.{label}"] = _frame(d - c, sign * hinge) @ _frame(b - a, straight).T
        turns[f"foot.{label}"] = _about_z(out) @ _about_y(-pitch)
        ends[f"foot.{label}"] = ankle
        for toe in range(1, 6):
            turns[f"toe{toe}-1.{label}"] = _about_z(out) @ _about_y(-toes)

    def _arm_turns(self, label, arm, twist, turns) -> None:  # type: ignore[no-untyped-def]
        """The arm hangs by (ahead, out, elbow) [deg] from the vertical."""
        ahead, out, elbow = arm
        side = 1.0 if label == "L" else -1.0
        rest = [self.body.joint(f"{n}.{label}") for n in ("upperarm01", "lowerarm01", "wrist")]
        upper, fore = rest[1] - rest[0], rest[2] - rest[1]
        hinge = np.cross(upper, fore)
        lateral = _about_x(side * out)
        down = np.array([0.0, 0.0, -1.0])
        new_hinge = _about_z(twist - side * 18.0) @ lateral @ np.array([0.0, -1.0, 0.0])
        new_upper = lateral @ _about_y(-ahead) @ down
        turned = _frame(new_upper, new_hinge) @ _frame(upper, hinge).T
        turns[f"shoulder01.{label}"] = _about_z(twist) @ _about_x(-side * 6.0)
        turns[f"upperarm01.{label}"] = turned
        angle = math.acos(float(_unit(upper) @ _unit(fore)))
        axis = _frame(new_upper, new_hinge)[:, 1]
        fore_turn = _about(axis, math.radians(elbow) - angle) @ turned
        turns[f"lowerarm01.{label}"] = fore_turn
        knuckles = self.body.joint(f"finger5-1.{label}") - self.body.joint(f"finger2-1.{label}")
        for finger in range(2, 6):  # half closed
            for link in range(1, 4):
                curl = _about(knuckles, -side * math.radians(CURL * link + 2.0 * finger))
                turns[f"finger{finger}-{link}.{label}"] = fore_turn @ curl


def _frame(along: np.ndarray, hinge: np.ndarray) -> np.ndarray:
    """Orthonormal columns (along, hinge without its share along, their product)."""
    x = _unit(along)
    y = _unit(hinge - (hinge @ x) * x)
    return np.stack([x, y, np.cross(x, y)], axis=1)


def _about(axis: np.ndarray, angle: float) -> np.ndarray:
    x, y, z = _unit(axis)
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * k + (1.0 - math.cos(angle)) * (k @ k)


def _about_x(degrees: float) -> np.ndarray:
    return _about(np.array([1.0, 0.0, 0.0]), math.radians(degrees))


def _about_y(degrees: float) -> np.ndarray:
    return _about(np.array([0.0, 1.0, 0.0]), math.radians(degrees))


def _about_z(degrees: float) -> np.ndarray:
    return _about(np.array([0.0, 0.0, 1.0]), math.radians(degrees))


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v)
