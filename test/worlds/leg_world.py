"""A scanner in a room with round legs, exactly; for tests of what learns and what judges."""

import math

import numpy as np
from safe_passage.leg_detection.scan import Scan
from safe_passage.leg_detection.training_data import LabelledScan, LegRecording

BEAMS, STEP = 541, math.radians(0.5)
ANGLES = -math.radians(135) + STEP * np.arange(BEAMS)
LEG_RADIUS = 0.06  # m


def circle_ranges(x, y, radius):
    """Distance (BEAMS,) m to a circle; inf where it is missed."""
    along = x * np.cos(ANGLES) + y * np.sin(ANGLES)
    across = x * np.sin(ANGLES) - y * np.cos(ANGLES)
    hit = (np.abs(across) < radius) & (along > 0)
    return np.where(hit, along - np.sqrt(np.maximum(radius**2 - across**2, 0.0)), np.inf)


def look(legs, rng=None, pillars=(), stamp=0.0, room=3.5):
    """A labelled scan of legs [(x, y) m] and pillars [(x, y, radius) m] in a square room."""
    walls = room / np.maximum(np.abs(np.cos(ANGLES)), np.abs(np.sin(ANGLES)))
    others = np.min([walls, *(circle_ranges(*pillar) for pillar in pillars)], axis=0)
    of_legs = np.min(
        [np.full(BEAMS, np.inf), *(circle_ranges(x, y, LEG_RADIUS) for x, y in legs)], axis=0
    )
    ranges = np.minimum(others, of_legs)
    if rng is not None:
        ranges = ranges + rng.normal(0.0, 0.005, BEAMS)
    scan = Scan(ranges, ANGLES[0], STEP, 0.05, 20.0, stamp)
    return LabelledScan(scan, of_legs < others)


def walk(name, seed, steps=40):
    """A recording: somebody walks about with 0.3 m between the legs, beside two pillars."""
    rng = np.random.default_rng(seed)
    pillars = [(*rng.uniform((-1.0, -3.0), (3.0, -2.0)), 0.3), (2.0, 2.5, 0.25)]
    at = rng.uniform((1.0, -1.0), (2.0, 1.0))
    scans, legs = [], []
    for i in range(steps):
        at = np.clip(at + rng.normal(0.0, 0.15, 2), (0.7, -1.5), (2.7, 1.5))
        legs.append(at + np.array([(0.0, -0.15), (0.0, 0.15)]))
        scans.append(look(legs[-1], rng, pillars, stamp=0.1 * i))
    return LegRecording(name, [one.scan for one in scans], legs), scans
