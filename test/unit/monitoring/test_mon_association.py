import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.monitoring.association import associate, candidates, choose, feature_distance
from safe_passage.monitoring.features import Features
from safe_passage.monitoring.hypotheses import Hypotheses
from safe_passage.monitoring.parameters import CLOUD, SourceParameters, TrackerParameters
from safe_passage.monitoring.ragged import Ragged
from safe_passage.monitoring.tracks import new_tracks

LASERS_AND_CAMERA = (
    SourceParameters("front"),
    SourceParameters("rear"),
    SourceParameters("camera", CLOUD),
)
P = TrackerParameters(sources=LASERS_AND_CAMERA)
OLD = np.ones(9, bool)
HEIGHTS = np.array([False, False, True])


def features(positions, counts=(10, 0, 0), cells=4, top=np.nan, extent=0.01, **known) -> Features:
    n, before = len(positions), {"new": 0.0, "stood": 0.0, "here": True, **known}
    return Features(
        np.array(positions, float).reshape(-1, 2),
        np.tile(extent * np.eye(2), (n, 1, 1)),
        np.full(n, cells),
        np.tile(np.array(counts), (n, 1)),
        np.tile(np.array([0.1, top]), (n, 1)),
        np.zeros(n),
        np.zeros(n, bool),
        *(np.full(n, value) for value in before.values()),
        np.zeros(n, bool),
    )


def tracks_at(positions, **seen):
    seen = features(positions, **seen)
    return new_tracks(seen, [np.zeros((1, 2))] * len(positions), 1, 0.0, P)


def hypotheses_of(seen: Features, atoms=None, overlaps=()) -> Hypotheses:
    n = len(seen.position)
    atoms = [(i,) for i in range(n)] if atoms is None else atoms
    cells = Ragged.of([np.array([i]) for i in range(n)], np.empty(0, int))
    pairs = np.array(overlaps, np.int64).reshape(-1, 2)
    fallen = np.empty((0, 2), np.int64)
    no, nobody = np.zeros(n, bool), np.full(n, 99)
    return Hypotheses(cells, atoms, seen, no, fallen, nobody, pairs)


def pairs(hypotheses, tracks) -> set:
    return set(
        zip(*(a.tolist() for a in associate(hypotheses, tracks, OLD[: len(tracks)], HEIGHTS, P)))
    )


def one_distance(seen: Features, tracks) -> float:
    zero = np.array([0])
    return float(feature_distance(seen, tracks, zero, zero, HEIGHTS, P)[0])


def test_each_goes_to_its_nearest():
    seen = hypotheses_of(features([(0.0, 0.0), (1.0, 0.0)]))
    assert pairs(seen, tracks_at([(1.02, 0.0), (0.03, 0.0)])) == {(0, 1), (1, 0)}


def test_what_is_too_far_is_nobody():
    assert pairs(hypotheses_of(features([(0.0, 0.0)])), tracks_at([(1.0, 0.0)])) == set()


def test_a_large_object_is_itself_wherever_its_visible_part_is():
    """Half a wall disappears behind a person: its centroid leaps, its cells still overlap."""
    seen = hypotheses_of(features([(3.0, 0.0)], cells=40, extent=1.0), overlaps=[(0, 0)])
    assert pairs(seen, tracks_at([(0.0, 0.0)], cells=60, extent=2.0)) == {(0, 0)}


def test_a_person_beside_a_hidden_wall_is_not_the_wall():
    seen = hypotheses_of(features([(0.8, 0.0)]))
    assert pairs(seen, tracks_at([(0.0, 0.0)], cells=60, extent=2.0)) == set()


def test_the_composite_wins_over_one_leg_and_rules_out_both():
    legs = [(-0.15, 0.0), (0.15, 0.0), (0.0, 0.0)]
    seen = features(legs)
    seen.cells[2], seen.counts[2] = 8, (20, 0, 0)
    hypotheses = hypotheses_of(seen, [(0,), (1,), (0, 1)])
    assert pairs(hypotheses, tracks_at([(0.01, 0.0)], cells=8, counts=(20, 0, 0))) == {(2, 0)}


def test_points_of_a_sensor_that_sees_only_one_of_both_do_not_count():
    tracks = tracks_at([(0, 0)], counts=(10, 0, 0))
    assert one_distance(features([(0, 0)], counts=(10, 0, 500)), tracks) == 0.0


def test_points_of_a_common_sensor_count():
    tracks = tracks_at([(0, 0)], counts=(10, 0, 0))
    assert one_distance(features([(0, 0)], counts=(5, 0, 0)), tracks) == pytest.approx(
        0.5 * P.points_weight
    )


def test_sensors_that_never_saw_the_other_cost_a_constant():
    tracks = tracks_at([(0, 0)], counts=(10, 0, 0))
    assert one_distance(features([(0, 0)], counts=(0, 10, 0)), tracks) == P.no_common_sensor


def test_heights_are_compared_where_a_camera_saw_both():
    tracks = tracks_at([(0, 0)], counts=(0, 0, 50), top=1.8)
    seen = features([(0, 0)], counts=(0, 0, 50), top=0.9)
    assert one_distance(seen, tracks) == pytest.approx(0.9 / P.height_scale * P.height_weight)
    laser = tracks_at([(0, 0)], counts=(5, 0, 0), top=1.8)
    seen = features([(0, 0)], counts=(5, 0, 50), top=0.9)
    assert one_distance(seen, laser) == 0.0


def walking(positions, speed=1.0, **seen):
    """Tracks that have just been seen moving along x."""
    tracks = tracks_at(positions, **seen)
    x = tracks.x.copy()
    x[:, 2] = speed
    return tracks.with_(x=x, moving=np.ones(len(tracks), bool))


def test_who_comes_out_from_behind_a_pillar_is_found_again_but_no_chair_is_taken_for_them():
    lost = walking([(0.0, 0.0)]).with_(unseen=np.array([1.0]))
    lost = lost.with_(P=lost.P + 0.3 * np.eye(4))
    assert pairs(hypotheses_of(features([(1.2, 0.0)], new=1.0)), lost) == {(0, 0)}
    assert pairs(hypotheses_of(features([(1.2, 0.0)], new=0.0)), lost) == set()


def test_who_walks_is_not_what_stood_there_before():
    stood = hypotheses_of(features([(0.1, 0.0)], stood=1.0))
    assert pairs(stood, walking([(0.0, 0.0)])) == set()
    assert pairs(stood, walking([(0.0, 0.0)], speed=0.1)) == {(0, 0)}  # who has stopped


def test_who_walks_is_not_where_nothing_is_left():
    seen = features([(0.1, 0.0)])
    seen.left[0] = True
    assert pairs(hypotheses_of(seen), walking([(0.0, 0.0)])) == set()
    assert pairs(hypotheses_of(seen), tracks_at([(0.0, 0.0)])) == {(0, 0)}  # a chair's thin leg


def test_a_walker_inherits_what_began_at_the_other_foot():
    feet = features([(0.0, 0.0), (0.4, 0.0)])
    tracks = walking([(0.05, 0.0), (0.4, 0.0)])
    tracks = tracks.with_(moving=np.array([True, False]))
    established = np.array([True, False])
    for here, expected in ((True, {(0, 0), (1, 1)}), (False, {(1, 0)})):
        feet.here[0] = here
        found = associate(hypotheses_of(feet), tracks, established, HEIGHTS, P)
        assert set(zip(*(a.tolist() for a in found))) == expected


def test_two_who_are_known_inherit_nothing():
    feet = features([(0.0, 0.0), (0.4, 0.0)])
    feet.here[0] = False
    assert pairs(hypotheses_of(feet), walking([(0.05, 0.0), (0.4, 0.0)])) == {(0, 0), (1, 1)}


def test_nobody_and_nothing():
    assert pairs(hypotheses_of(features([])), tracks_at([(0, 0)])) == set()
    assert pairs(hypotheses_of(features([(0, 0)])), tracks_at([])) == set()


def test_candidates_name_each_pair_once_and_know_the_overlapping():
    found, overlap = candidates(np.zeros((2, 2)), np.zeros((1, 2)), np.array([[1, 0]]))
    assert found.tolist() == [[0, 0], [1, 0]]
    assert overlap.tolist() == [False, True]


@given(
    st.lists(st.sets(st.integers(0, 5), min_size=1), min_size=1, max_size=8),
    st.lists(st.tuples(st.integers(0, 7), st.integers(0, 4)), max_size=30),
)
def test_no_atom_and_no_track_is_used_twice_and_none_left_without_need(sets, offered):
    atoms = [tuple(s) for s in sets]
    offered = [(h % len(atoms), t) for h, t in offered]
    h, t = np.array(offered, np.int64).reshape(-1, 2).T
    chosen = list(zip(*(a.tolist() for a in choose(h, t, atoms))))
    used = [atom for hypothesis, _ in chosen for atom in atoms[hypothesis]]
    assert len(used) == len(set(used))
    assert len({track for _, track in chosen}) == len(chosen)
    for hypothesis, track in offered:  # maximal
        taken = any(track == other for _, other in chosen)
        assert taken or not set(used).isdisjoint(atoms[hypothesis])
