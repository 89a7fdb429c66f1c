"""Legs to persons."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.distance import pdist


@dataclass(frozen=True)
class Leg:
    """A segment that the model takes for a leg."""

    position: tuple[float, float]  # [m] mean of its points, scanner's frame
    probability: float  # 0 to 1


@dataclass(frozen=True)
class LegPerson:
    """One or two legs."""

    position: tuple[float, float]  # [m] between the legs, scanner's frame
    probability: float  # of the surer leg
    legs: tuple[Leg, ...]


def pair_legs(legs: list[Leg], max_distance: float, lone_legs: bool) -> list[LegPerson]:
    """Join legs to persons: the nearest two first, each leg in one person at most.

    max_distance: [m] between two legs of a person. lone_legs: whether a leg that is left over is a
    person, too.
    """
    first, second = np.triu_indices(len(legs), k=1)
    distances = pdist(np.array([leg.position for leg in legs]).reshape(-1, 2))
    free = set(range(len(legs)))
    persons = []
    for pair in np.argsort(distances, kind="stable"):
        i, j = int(first[pair]), int(second[pair])
        if distances[pair] <= max_distance and {i, j} <= free:
            free -= {i, j}
            persons.append(_person(legs[i], legs[j]))
    if lone_legs:
        persons += [_person(legs[i]) for i in sorted(free)]
    return persons


def _person(*legs: Leg) -> LegPerson:
    x, y = np.mean([leg.position for leg in legs], axis=0)
    return LegPerson((float(x), float(y)), max(leg.probability for leg in legs), legs)
