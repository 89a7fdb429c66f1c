"""Legs are paired to persons: the nearest first, none twice, none lost."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.leg_detection.persons import Leg, pair_legs

coordinate = st.floats(-5.0, 5.0)
some_legs = st.lists(st.builds(Leg, st.tuples(coordinate, coordinate), st.floats(0.5, 1.0)))


def legs_at(*places):
    return [Leg(place, 0.5 + 0.01 * i) for i, place in enumerate(places)]


def test_two_legs_are_a_person_between_them():
    (person,) = pair_legs(legs_at((1.0, 0.0), (1.2, 0.4)), 0.8, lone_legs=True)
    assert person.position == pytest.approx((1.1, 0.2))
    assert person.probability == 0.51
    assert len(person.legs) == 2


def test_the_nearest_are_joined_first():
    legs = legs_at((0.0, 0.0), (0.5, 0.0), (0.7, 0.0), (1.4, 0.0))
    joined = pair_legs(legs, 0.8, lone_legs=False)
    assert [{leg.position[0] for leg in person.legs} for person in joined] == [{0.5, 0.7}]


def test_far_legs_are_two_persons_or_none():
    legs = legs_at((1.0, 0.0), (2.0, 0.0))
    assert len(pair_legs(legs, 0.8, lone_legs=True)) == 2
    assert pair_legs(legs, 0.8, lone_legs=False) == []


def test_no_legs_no_person():
    assert pair_legs([], 0.8, lone_legs=True) == []
    assert len(pair_legs(legs_at((1.0, 0.0)), 0.8, lone_legs=True)) == 1


@given(some_legs, st.floats(0.0, 2.0))
def test_every_leg_is_in_one_person(legs, distance):
    persons = pair_legs(legs, distance, lone_legs=True)
    used = [id(leg) for person in persons for leg in person.legs]
    assert sorted(used) == sorted(map(id, legs))
    for person in persons:
        if len(person.legs) == 2:
            apart = np.subtract(person.legs[0].position, person.legs[1].position)
            assert np.linalg.norm(apart) <= distance + 1e-9


@given(some_legs, st.floats(0.0, 2.0))
def test_two_persons_with_lone_legs_are_not_one(legs, distance):
    alone = [p for p in pair_legs(legs, distance, lone_legs=True) if len(p.legs) == 1]
    for i, one in enumerate(alone):
        for other in alone[i + 1 :]:
            assert np.linalg.norm(np.subtract(one.position, other.position)) > distance - 1e-9
