"""Labels of persons: evidence raises them, time lowers them, no detection is lost."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mon_people import Thing, scene
from safe_passage.core.errors import ParameterError
from safe_passage.monitoring.person_looks import Look, View
from safe_passage.monitoring.persons import PersonLabelParameters, PersonLabels
from safe_passage.monitoring.ragged import Ragged
from test_mon_pipeline import DT, Run, disc

AHEAD = View((0.0, 0.0), 0.0, 1.0, 0.5, 6.0)  # from the origin along x
AWAY = View((0.0, 0.0), math.pi, 1.0, 0.5, 6.0)


def look(stamp, *places, probability=0.9, view=None, said=()):
    positions = np.array(places, float).reshape(-1, 2)
    return Look(stamp, positions, np.full(len(positions), probability), view, said)


def labels(**values):
    return PersonLabels(PersonLabelParameters(**values))


def seen_at(*places, things, probability=0.9, repeat=1):
    """Labels after `repeat` detections at `places`, and what they say then."""
    judge = labels()
    for i in range(repeat):
        now = 0.1 * i
        persons = judge.update(scene(now, *things), [look(now, *places, probability=probability)])
    return judge, persons


def after(judge, stamp, *things, looks=(), every=0.1, start=0.0):
    """What is said at `stamp` [s], with a cycle `every` [s] until then."""
    for now in np.arange(start + every, stamp + 0.5 * every, every):
        persons = judge.update(scene(now, *things), [one(now) for one in looks])
    return persons


def test_a_detection_labels_the_track_on_which_it_falls():
    _, persons = seen_at((2.1, 0.1), things=[Thing(1, 2.0), Thing(2, 4.0)])
    assert persons.labelled.tolist() == [True, False]
    assert math.isnan(persons.probability[1])
    assert persons.unattached == ()


def test_a_detection_is_older_than_the_track():
    """At 2 m/s and 0.3 s the person is 0.6 m farther on, and another stands where it was."""
    things = [Thing(1, 2.6, vx=2.0, moving=True), Thing(2, 2.4, 0.3)]
    persons = labels().update(scene(5.0, *things), [look(4.7, (2.0, 0.0))])
    assert persons.labelled.tolist() == [True, False]


def test_the_robot_may_be_anywhere():
    pose = (3.0, -1.0, 2.0)
    things = [Thing(1, 2.6, vx=2.0, moving=True), Thing(2, 2.4, 0.3)]
    persons = labels().update(scene(5.0, *things, pose=pose), [look(4.7, (2.0, 0.0))])
    assert persons.labelled.tolist() == [True, False]


def test_every_detection_raises_it_up_to_a_limit():
    said = [
        seen_at((2, 0), things=[Thing(1, 2.0)], repeat=n)[1].probability[0] for n in range(1, 9)
    ]
    assert all(a < b for a, b in zip(said, said[1:3]))
    assert said[-1] == pytest.approx(0.99)


def test_one_weak_detection_is_enough():
    _, persons = seen_at((2.0, 0.0), things=[Thing(1, 2.0)], probability=0.0)
    assert persons.labelled[0]


def test_time_lowers_it_less_while_it_walks():
    standing, walking = Thing(1, 2.0), Thing(1, 2.0, vx=1.0, moving=True)
    judges = [seen_at((2.0, 0.0), things=[standing], repeat=9)[0] for _ in range(2)]
    still, walks = (
        after(judge, 30.0, thing, start=0.9) for judge, thing in zip(judges, (standing, walking))
    )
    assert 0.6 < still.probability[0] < walks.probability[0] < 0.99
    assert not after(judges[0], 100.0, standing, start=30.0, every=1.0).labelled[0]
    assert after(judges[1], 100.0, walking, start=30.0, every=1.0).labelled[0]


def test_time_does_not_depend_on_the_rate():
    thing = Thing(1, 2.0)
    said = [
        after(seen_at((2, 0), things=[thing])[0], 20.0, thing, every=every).probability[0]
        for every in (0.1, 2.0)
    ]
    assert said[0] == pytest.approx(said[1])


def test_a_wall_is_not_labelled_and_the_detection_is_passed_on():
    _, persons = seen_at((2.0, 0.1), things=[Thing(1, 2.0, size=4.0)])
    assert not persons.labelled.any()
    assert [one.position for one in persons.unattached] == [(2.0, 0.1)]


def test_who_stands_before_a_wall_is_preferred_to_it():
    _, persons = seen_at((2.0, 0.1), things=[Thing(1, 2.0, 0.1, size=4.0), Thing(2, 2.0, -0.2)])
    assert persons.labelled.tolist() == [False, True]
    assert persons.unattached == ()


def test_of_two_persons_in_one_track_the_second_is_passed_on():
    _, persons = seen_at((2.0, 0.2), (2.0, -0.4), things=[Thing(1, 2.0)])
    assert persons.labelled.tolist() == [True]
    assert [one.position for one in persons.unattached] == [(2.0, -0.4)]


def test_what_is_not_told_is_not_labelled():
    """Else the detection would be swallowed by a track that nobody hears of."""
    _, persons = seen_at((2.0, 0.0), things=[Thing(1, 2.0, confirmed=False)])
    assert not persons.labelled.any()
    assert len(persons.unattached) == 1


def test_what_the_detector_says_is_handed_through_while_it_is_fresh():
    judge, thing = labels(), Thing(1, 2.0)
    looks = [look(0.0, (2.0, 0.0), (5.0, 0.0), said=("first", "second"))]
    persons = judge.update(scene(0.0, thing), looks)
    assert persons.said == ("first",)
    assert [one.said for one in persons.unattached] == ["second"]
    persons = judge.update(scene(1.0, thing), [])
    assert persons.said == (None,)
    assert persons.labelled[0]
    assert persons.unattached == ()  # once is enough


def looking(view):
    return lambda now: look(now, view=view)


def test_a_camera_that_sees_nobody_there_ends_the_label_soon():
    thing = Thing(1, 3.0)
    asked, elsewhere = (
        after(seen_at((3.0, 0.0), things=[thing], repeat=9)[0], 6.0, thing, looks=[looking(view)],
              start=0.8)
        for view in (AHEAD, AWAY)
    )  # fmt: skip
    assert not asked.labelled[0]
    assert elsewhere.labelled[0]


def test_a_detection_waits_for_its_track():
    """A camera sees over the boxes that hide the person from the lidar."""
    judge = labels()
    judge.update(scene(0.0, Thing(1, 5.0)), [look(0.0, (2.0, 0.0))])
    after(judge, 3.0, Thing(1, 5.0))
    here = Thing(2, 2.1)
    assert not after(judge, 3.2, Thing(1, 5.0), replace(here, confirmed=False), start=3.0).labelled[
        1
    ]
    assert after(judge, 3.4, Thing(1, 5.0), here, start=3.2).labelled.tolist() == [False, True]


@pytest.mark.parametrize(
    "late", [Thing(2, 3.0), Thing(2, 2.1, size=4.0)], ids=["elsewhere", "a wall"]
)
def test_what_appears_is_not_the_person_who_was_detected(late):
    judge = labels()
    judge.update(scene(0.0), [look(0.0, (2.0, 0.0))])
    assert not after(judge, 1.0, late).labelled.any()


def test_nobody_waits_for_long():
    judge, here = labels(), Thing(2, 2.1)
    judge.update(scene(0.0), [look(0.0, (2.0, 0.0))])
    after(judge, 5.1)
    assert not after(judge, 6.0, here, start=5.1).labelled.any()


def test_however_often_one_is_seen_one_track_that_appears_is_the_person():
    judge, here, other = labels(), Thing(2, 2.1), Thing(3, 2.0, 0.4)
    for now in (0.0, 0.1, 0.2):
        judge.update(scene(now), [look(now, (2.0, 0.0))])
    assert after(judge, 0.3, here, start=0.2).labelled.tolist() == [True]
    assert after(judge, 4.0, here, other, start=0.3).labelled.tolist() == [True, False]


def test_what_stood_there_before_is_not_the_person():
    judge, post = labels(), Thing(2, 2.1, size=4.0)
    judge.update(scene(0.0, post), [look(0.0, (2.0, 0.0))])
    assert not after(judge, 1.0, replace(post, size=0.3)).labelled.any()


WALKER = Thing(1, 3.0, vx=0.8, moving=True)


def after_walking(*things, looks=(), stamp=6.0):
    return after(labels(walker_probability=0.9), stamp, *things, looks=looks).labelled.tolist()


def test_by_default_who_walks_is_nobody_until_a_detector_says_so():
    assert not after(labels(), 1.0, WALKER).labelled.any()


def test_who_walks_where_no_camera_looks_may_be_taken_for_a_person():
    standing, long, unproved = (
        Thing(2, 4.0),
        Thing(3, 2.0, 3.0, vx=0.8, moving=True, size=4.0),
        Thing(4, 2.0, -3.0, vx=0.8, moving=True, confirmed=False),
    )
    found = after_walking(WALKER, standing, long, unproved, looks=[looking(AWAY)])
    assert found == [True, False, False, False]


def test_who_walks_for_long_stays_a_person():
    assert after_walking(WALKER, stamp=300.0) == [True]


def test_a_walker_whom_a_camera_does_not_see_as_a_person_is_none_for_good():
    judge = labels(walker_probability=0.9)
    assert not after(judge, 6.0, WALKER, looks=[looking(AHEAD)]).labelled[0]
    assert not after(judge, 60.0, WALKER, start=6.0).labelled[0]


def test_a_walker_who_stops_is_a_person_for_half_a_minute():
    judge = labels(walker_probability=0.9)
    after(judge, 6.0, WALKER)
    assert after(judge, 36.0, Thing(1, 3.0), start=6.0).labelled[0]
    assert not after(judge, 96.0, Thing(1, 3.0), start=36.0).labelled[0]


@pytest.mark.parametrize(
    "hidden",
    [Thing(2, 1.5, 0.0), Thing(2, 0.8, 0.0, misses=3)],
    ids=["something before it", "something carried on before it"],
)
def test_who_is_hidden_from_the_camera_keeps_the_label(hidden):
    things = [Thing(1, 3.0), hidden]
    judge, _ = seen_at((3.0, 0.0), things=things, repeat=9)
    assert after(judge, 6.0, *things, looks=[looking(AHEAD)], start=0.8).labelled[0]


def test_who_is_too_near_for_the_camera_keeps_the_label():
    thing = Thing(1, 0.4)
    judge, _ = seen_at((0.4, 0.0), things=[thing], repeat=9)
    wide = replace(AHEAD, width=3.0)
    assert after(judge, 6.0, thing, looks=[looking(wide)], start=0.8).labelled[0]


def leaves(judge, walker, *left, start, seconds):
    """`walker` goes on from where it is; the others stay."""
    for now in np.arange(start, start + seconds, 0.1):
        gone = now - start
        moved = Thing(walker.id, walker.x + gone, walker.y, vx=1.0, moving=gone > 0.5)
        persons = judge.update(scene(now, moved, *left), [])
    return dict(zip([walker.id, *(one.id for one in left)], persons.labelled.tolist()))


def test_a_trolley_with_the_old_number_keeps_the_label_for_a_while_only():
    """The person who leaves it is a new track; no camera looks."""
    judge, _ = seen_at((2.0, 0.0), things=[Thing(1, 2.0, size=1.2)], repeat=9)
    trolley, person = Thing(1, 2.0, size=0.9), Thing(2, 2.6)
    assert leaves(judge, person, trolley, start=1.0, seconds=2.0) == {2: True, 1: True}
    after(judge, 12.0, Thing(2, 5.0, vx=1.0, moving=True), trolley, start=3.0)
    persons = judge.update(scene(12.1, Thing(2, 5.0, vx=1.0, moving=True), trolley), [])
    assert persons.labelled.tolist() == [True, False]


def test_a_trolley_with_a_new_number_gets_no_label():
    judge, _ = seen_at((2.0, 0.0), things=[Thing(1, 2.0, size=1.2)], repeat=9)
    assert leaves(judge, Thing(1, 2.0), Thing(2, 1.4), start=1.0, seconds=4.0) == {
        1: True, 2: False,
    }  # fmt: skip


def test_detections_that_fall_on_the_other_move_the_label():
    judge, _ = seen_at((2.0, 0.0), things=[Thing(1, 2.0, size=1.2)], repeat=9)
    things = [Thing(1, 2.0, size=0.9), Thing(2, 2.6)]
    persons = after(judge, 12.0, *things, looks=[lambda now: look(now, (2.7, 0.0))], start=0.8)
    assert persons.labelled.tolist() == [False, True]


def test_a_detection_ends_the_doubt_about_who_was_left():
    judge, _ = seen_at((2.0, 0.0), things=[Thing(1, 2.0)], repeat=9)
    both = [Thing(1, 2.0), Thing(2, 2.5)]
    for now in np.arange(1.0, 2.0, 0.1):
        judge.update(scene(now, *both), [look(now, (2.6, 0.0))])
    judge.update(scene(2.0, *both), [look(2.0, (2.0, 0.0), (2.6, 0.0))])
    assert after(judge, 15.0, *both, start=2.0).labelled.all()


def test_a_new_number_on_the_same_person_is_labelled():
    """The tracker has lost the first and goes on with a second one."""
    judge, _ = seen_at((2.0, 0.0), things=[Thing(1, 2.0)], repeat=9)
    persons = after(judge, 1.5, Thing(1, 2.1, misses=4), Thing(2, 2.2), start=0.8)
    assert persons.labelled.tolist() == [True, True]
    assert after(judge, 3.0, Thing(2, 2.2), start=1.5).labelled.tolist() == [True]


def test_what_appears_beside_a_person_is_told_for_a_moment():
    """The person's track may have got hold of something else."""
    judge, _ = seen_at((2.0, 0.0), things=[Thing(1, 2.0)], repeat=9)
    both = [Thing(1, 2.0), Thing(2, 2.6)]
    assert after(judge, 1.5, *both, start=0.8).labelled.tolist() == [True, True]
    assert after(judge, 2.2, *both, start=1.5).labelled.tolist() == [True, False]
    fast = [Thing(1, 2.0), Thing(3, 2.5, vx=1.0)]  # a new track's speed is soon wrong
    after(judge, 2.5, *fast, start=2.2)
    assert after(judge, 4.0, *fast, start=2.5).labelled.tolist() == [True, False]


def test_what_appears_far_from_a_person_is_not_told():
    judge, _ = seen_at((2.0, 0.0), things=[Thing(1, 2.0)], repeat=9)
    persons = after(judge, 1.0, Thing(1, 2.0), Thing(2, 3.5), start=0.8)
    assert persons.labelled.tolist() == [True, False]


def test_things_beside_a_person_are_no_persons():
    judge, _ = seen_at((2.0, 0.0), things=[Thing(1, 2.0)], repeat=9)
    persons = after(judge, 5.0, Thing(1, 2.0), Thing(2, 2.4), start=0.8)
    assert persons.labelled.tolist() == [True, False]


def test_after_a_reset_nobody_is_known():
    judge, _ = seen_at((2.0, 0.0), things=[Thing(1, 2.0)], repeat=9)
    judge.reset()
    persons = judge.update(scene(0.0, Thing(1, 2.0)), [])
    assert np.isnan(persons.probability).all()


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"label_gate": -1.0}, "label_gate is -1.0, must lie in"),
        ({"person_threshold": 0.5}, "person_threshold is 0.5, must lie in"),
        ({"left_half_life": math.nan}, "left_half_life is nan, must lie in"),
    ],
)
def test_wrong_parameters_are_refused(wrong, said):
    with pytest.raises(ParameterError, match=said):
        PersonLabelParameters(**wrong)


PLACE = st.tuples(st.floats(-5, 5), st.floats(-5, 5))


@st.composite
def courses(draw):
    """Some cycles of things and detections."""
    cycles, now = [], 0.0
    for _ in range(draw(st.integers(1, 5))):
        now += draw(st.floats(0.0, 5.0))
        numbers = draw(st.lists(st.integers(1, 6), unique=True, max_size=5))
        things = [
            Thing(n, *draw(PLACE), *draw(PLACE), draw(st.sampled_from([0.1, 0.4, 1.5, 4.0])),
                  draw(st.booleans()), draw(st.integers(0, 2)), draw(st.booleans()))
            for n in numbers
        ]  # fmt: skip
        looks = [
            look(now - draw(st.floats(0.0, 1.0)), *draw(st.lists(PLACE, max_size=3)),
                 probability=draw(st.floats(0.0, 1.0)),
                 view=draw(st.sampled_from([None, AHEAD, AWAY])))
            for _ in range(draw(st.integers(0, 2)))
        ]  # fmt: skip
        cycles.append((now, things, looks))
    return cycles


@settings(deadline=None)
@given(courses())
def test_probabilities_are_ones_and_no_detection_is_lost(cycles):
    judge, p = labels(), PersonLabelParameters()
    for now, things, looks in cycles:
        persons = judge.update(scene(now, *things), looks)
        known = persons.probability[~np.isnan(persons.probability)]
        assert ((known >= 0.0) & (known <= p.person_certainty + 1e-9)).all()
        sizes = np.array([thing.size for thing in things])
        confirmed = np.array([thing.confirmed for thing in things], bool)
        assert (confirmed | ~persons.labelled).all()
        detections = sum(len(one.position) for one in looks)
        labelled = int((confirmed & (sizes <= p.person_size)).sum()) * len(looks)
        assert detections - labelled <= len(persons.unattached) <= detections


@settings(deadline=None)
@given(courses(), st.floats(0.1, 20.0))
def test_time_alone_raises_nothing(cycles, seconds):
    judge = labels()
    for now, things, looks in cycles:
        before = judge.update(scene(now, *things), looks)
    later = judge.update(scene(now, *things), [])  # what may be handed over has been
    later = judge.update(scene(now + seconds, *things), [])
    was = np.where(np.isnan(before.probability), 0.0, np.maximum(before.probability, 0.5))
    assert ((later.probability <= np.maximum(was, 0.5) + 1e-9) | np.isnan(before.probability)).all()


def test_of_a_labelled_track_in_pieces_each_is_told():
    """The tracker may take the person and the trolley that it leaves for one thing."""
    _, persons = seen_at((2.0, 0.0), things=[Thing(1, 2.0), Thing(2, 5.0)], repeat=2)
    assert [places.tolist() for places in persons.places.values()] == [[[2.0, 0.0]]]
    judge, _ = seen_at((2.0, 0.0), things=[Thing(1, 2.0)], repeat=2)
    snapshot = scene(0.3, Thing(1, 2.0, size=2.0))
    ends = Ragged(np.array([(1.0, 0.0), (1.1, 0.0), (3.0, 0.0)]), np.array([0, 3]))
    persons = judge.update(replace(snapshot, shapes=ends), [])
    (places,) = persons.places.values()
    assert sorted(places[:, 0]) == pytest.approx([1.05, 3.0])


def test_who_pushes_a_trolley_and_leaves_it_takes_the_label_along():
    """The tracker's own tracks, seen by lidar alone from the moment when the pushing ends."""
    run, judge = Run(), labels()
    for k in range(240):
        t = k * DT
        x = float(np.interp(t, [0, 3, 4, 8], [-3.2, -0.2, -0.2, 2.8]))
        aside, trolley = max(0.0, t - 9.0), max(0.5, x + 0.5)
        run.see(disc(trolley, 1.0, 0.2), disc(x, 1.0 - aside))
        looks = [look(t, (x, 1.0))] if 1.0 < t < 8.0 else []
        persons = judge.update(run.last, looks)
    assert persons.labelled[run.one_at(x, 1.0 - aside)]
    assert not persons.labelled[run.one_at(trolley, 1.0)]
