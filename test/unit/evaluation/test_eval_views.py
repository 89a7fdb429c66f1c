"""Views: the same number, the same view; the truth is that of the picture."""

import dataclasses

import numpy as np
import pytest
from eval_worlds import SETTING
from safe_passage.core.geometry import placed
from safe_passage.evaluation.views import FARTHEST, NEAREST, ViewSampler

SOMEBODY = 4_000_000  # a view with people, see the first test


@pytest.fixture(scope="module")
def view(sampler):
    numbers = (n for n in range(SOMEBODY, SOMEBODY + 50))
    views = (sampler.draw(n) for n in numbers)
    return next(v for v in views if any(p.visible > 0.9 for p in v.persons))


def same(a, b):
    return all(
        np.array_equal(x, y, equal_nan=isinstance(x, np.ndarray) and x.dtype.kind == "f")
        if isinstance(x, np.ndarray)
        else x == y
        for x, y in zip(dataclasses.astuple(a), dataclasses.astuple(b))
    )


def test_a_number_gives_one_view_whatever_was_drawn_before(sampler):
    again = ViewSampler(*SETTING.load())
    again.draw(SOMEBODY + 7)
    try:
        assert same(sampler.draw(SOMEBODY), again.draw(SOMEBODY))
    finally:
        again.close()
    assert not same(sampler.draw(SOMEBODY), sampler.draw(SOMEBODY + 1))


def test_people_stand_where_the_depth_has_them(sampler, view):
    """The person's pixels in the middle of its box lie at its distance."""
    person = max(view.persons, key=lambda p: p.visible)
    x, y, width, height = person.box
    part = view.depth[
        max(int(y + 0.3 * height), 0) : int(y + 0.5 * height),
        max(int(x + 0.4 * width), 0) : int(x + 0.6 * width),
    ]
    assert np.nanmedian(part) == pytest.approx(person.distance, abs=0.6)


def test_distances_are_those_asked_for(sampler):
    views = [sampler.draw(n) for n in range(SOMEBODY, SOMEBODY + 12)]
    persons = [p for v in views for p in v.persons]
    assert any(not v.persons for v in views)
    assert persons
    assert all(NEAREST - 1e-6 <= p.distance <= FARTHEST + 1e-6 for p in persons)


def test_beams_at_a_person_measure_its_distance(sampler, view):
    beams = view.beam_persons >= 0
    assert beams.any()
    known = {p.id: p for p in view.persons}
    angles = sampler.lidar.angles()
    for index in set(view.beam_persons[beams]) & set(known):
        mine = (view.beam_persons == index) & np.isfinite(view.ranges)
        assert mine.any()
        directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)[mine]
        in_base = directions * view.ranges[mine, None] + sampler.lidar.pose_in_base()[:2, 3]
        in_map = placed(in_base, view.pose)
        assert np.hypot(*(in_map - known[index].position).T).max() < 0.7
