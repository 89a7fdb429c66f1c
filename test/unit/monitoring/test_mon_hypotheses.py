from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mon_cells import CELL, grid_of, places, shapes_of
from safe_passage.monitoring.clustering import cluster
from safe_passage.monitoring.hypotheses import Hypotheses, Rules, propose
from safe_passage.monitoring.ragged import Ragged

OFF = 2.0
NO_WALKERS = np.empty((0, 2))
NOBODY = Ragged.of([], np.empty((0, 2)))


def rules(tracks: Ragged, composite: float = 0.5, split: float = 0.5, **other) -> Rules:
    count = len(tracks)
    told = {"body": 0.0, "walker": 1.3, "moving": np.ones(count, bool)}
    told.update({"established": np.zeros(count, bool), "bodies": np.empty((0, 2))})
    return Rules(composite, split, **{**told, **other})


def proposed(now: str, tracks: Ragged, composite: float = 0.5, split: float = 0.5, **other):
    grid = grid_of(now)
    return grid, propose(
        grid,
        cluster(grid, 1, 1.0, 1.3, NO_WALKERS),
        tracks,
        rules(tracks, composite, split, **other),
    )


def found(grid, hypotheses: Hypotheses) -> set:
    """Every hypothesis as the set of its cells' (column, row)."""
    return {
        frozenset(map(tuple, np.floor(grid.position[cells] / CELL).astype(int).tolist()))
        for cells in (hypotheses.cells[h] for h in range(len(hypotheses)))
    }


def cells(drawing: str, letters: str) -> frozenset:
    return frozenset(map(tuple, np.floor(places(drawing, letters) / CELL).astype(int).tolist()))


TWO_LEGS = """
........
.aa..bb.
.aa..bb.
........"""


def test_without_tracks_every_cluster_is_a_hypothesis():
    grid, hypotheses = proposed(TWO_LEGS, NOBODY)
    assert found(grid, hypotheses) == {cells(TWO_LEGS, "a"), cells(TWO_LEGS, "b")}


def test_two_clusters_on_one_track_may_be_one_object():
    person = shapes_of("........\n.pppppp.\n.pppppp.\n........", "p")
    grid, hypotheses = proposed(TWO_LEGS, person)
    assert found(grid, hypotheses) == {
        cells(TWO_LEGS, "a"),
        cells(TWO_LEGS, "b"),
        cells(TWO_LEGS, "ab"),
    }


def test_three_clusters_may_be_one_object_or_any_two_of_them():
    now = "a.a.b.b.c.c"
    whole = shapes_of("ppppppppppp", "p")
    grid = grid_of(now)
    found_sets = found(
        grid, propose(grid, np.array([0, 0, 1, 1, 2, 2]), whole, rules(whole, 0.5, OFF))
    )
    for letters in ("a", "b", "c", "ab", "bc", "ac", "abc"):
        assert cells(now, letters) in found_sets
    assert len(found_sets) == 7


def test_a_cluster_that_the_track_hardly_touches_is_no_part():
    now = """
..........
.aa.bbbbbb
.aa.bbbbbb
.........."""
    track = shapes_of("..........\n.ppp......\n.ppp......\n..........", "p")
    grid, hypotheses = proposed(now, track)
    assert cells(now, "ab") not in found(grid, hypotheses)


TABLE_AND_PERSON = """
............
.ttttttpp...
.ttttttpp...
............"""


def test_a_cluster_on_two_tracks_may_be_two_objects():
    tracks = shapes_of(TABLE_AND_PERSON, "tp")
    grid, hypotheses = proposed(TABLE_AND_PERSON, tracks)
    assert found(grid, hypotheses) == {
        cells(TABLE_AND_PERSON, "tp"),
        cells(TABLE_AND_PERSON, "t"),
        cells(TABLE_AND_PERSON, "p"),
    }


def test_the_whole_contradicts_its_parts_and_the_parts_do_not_each_other():
    _, hypotheses = proposed(TABLE_AND_PERSON, shapes_of(TABLE_AND_PERSON, "tp"))
    sizes = {len(own): set(own) for own in hypotheses.atoms}
    singles = [set(own) for own in hypotheses.atoms if len(own) == 1]
    assert singles[0].isdisjoint(singles[1])
    assert sizes[2] == singles[0] | singles[1]


def test_splits_and_composites_can_be_switched_off():
    tracks = shapes_of(TABLE_AND_PERSON, "tp")
    grid, hypotheses = proposed(TABLE_AND_PERSON, tracks, split=OFF)
    assert found(grid, hypotheses) == {cells(TABLE_AND_PERSON, "tp")}
    person = shapes_of("........\n.pppppp.\n.pppppp.\n........", "p")
    grid, hypotheses = proposed(TWO_LEGS, person, composite=OFF)
    assert len(hypotheses) == 2


def test_one_leg_beside_a_table_and_one_apart_are_together_a_person():
    now = """
..............
.ttttttll..rr.
.ttttttll..rr.
.............."""
    tracks = Ragged.of([places(now, "t"), places(now, "lr")], np.empty((0, 2)))
    grid, hypotheses = proposed(now, tracks)
    assert cells(now, "lr") in found(grid, hypotheses)


def test_two_who_are_known_to_walk_do_not_become_one():
    tracks = shapes_of(TABLE_AND_PERSON, "tp")
    grid, hypotheses = proposed(TABLE_AND_PERSON, tracks, established=np.ones(2, bool))
    assert found(grid, hypotheses) == {cells(TABLE_AND_PERSON, "t"), cells(TABLE_AND_PERSON, "p")}


def test_who_walk_apart_do_not_stay_one():
    together, parted = "aabb", "aa......bb"
    both = shapes_of(parted, "ab")
    both = Ragged.of([both.values], np.empty((0, 2)))
    for now, one in ((together, True), (parted, False)):
        grid, hypotheses = proposed(now, both, walker=0.5)
        assert (cells(now, "ab") in found(grid, hypotheses)) == one
    standing = proposed(parted, both, walker=0.5, moving=np.zeros(1, bool))
    assert cells(parted, "ab") in found(*standing)


def test_what_has_come_is_no_part_of_what_stands():
    whole = shapes_of("........\n.pppppp.\n.pppppp.\n........", "p")
    grid = grid_of(TWO_LEGS)
    came = np.isin(grid.cell, grid.cells_of(places(TWO_LEGS, "b")))
    labels = came.astype(np.int64)
    for moving in (True, False):
        told = rules(whole, moving=np.array([moving]))
        hypotheses = propose(replace(grid, new=came), labels, whole, told)
        assert (cells(TWO_LEGS, "ab") in found(grid, hypotheses)) == moving


def test_things_that_never_moved_are_not_taken_apart():
    tracks = shapes_of(TABLE_AND_PERSON, "tp")
    grid, hypotheses = proposed(TABLE_AND_PERSON, tracks, moving=np.zeros(2, bool))
    assert found(grid, hypotheses) == {cells(TABLE_AND_PERSON, "tp")}


def test_what_is_as_large_as_a_person_is_taken_apart_only_between_those_long_known():
    tracks = shapes_of(TABLE_AND_PERSON, "tp")
    for established in (np.array([True, False]), np.array([True, True])):
        grid, hypotheses = proposed(TABLE_AND_PERSON, tracks, body=1.0, established=established)
        assert (len(hypotheses) > 1) == established.all()
        assert hypotheses.fallen.tolist() == [[0, 0], [1, 0]]


def test_a_leg_that_steps_out_of_the_predicted_shape_still_belongs_to_its_body():
    person = shapes_of("........\n.pp.....\n.pp.....\n........", "p")
    grid, hypotheses = proposed(TWO_LEGS, person, body=1.0)
    assert cells(TWO_LEGS, "ab") not in found(grid, hypotheses)
    grid, hypotheses = proposed(TWO_LEGS, person, body=1.0, bodies=np.array([[0.4, 0.2]]))
    assert cells(TWO_LEGS, "ab") in found(grid, hypotheses)


def test_a_part_is_known_as_such():
    _, hypotheses = proposed(TABLE_AND_PERSON, shapes_of(TABLE_AND_PERSON, "tp"))
    assert [len(own) == 1 for own in hypotheses.atoms] == hypotheses.part.tolist()


def test_features_describe_the_cells():
    now = """
....
.aa.
.a..
...."""
    grid, hypotheses = proposed(now, NOBODY)
    features = hypotheses.features
    assert features.position[0] == pytest.approx([0.15 + 0.1 / 3, 0.15 + 0.2 / 3])
    assert features.cells.tolist() == [3]
    assert features.counts.tolist() == [[9]]
    assert np.isnan(features.height).all()
    points = places(now, "a")
    assert features.extent[0] == pytest.approx(np.cov(points.T, bias=True))


def test_nothing_seen():
    _, hypotheses = proposed("....", NOBODY)
    assert len(hypotheses) == 0
    assert hypotheses.features.counts.shape == (0, 1)


@given(st.text("ab.", min_size=36, max_size=36), st.text("pq.", min_size=36, max_size=36))
def test_atoms_are_a_partition_whatever_is_seen_and_predicted(now, before):
    def rows(text):
        return "\n".join(text[i : i + 6] for i in range(0, 36, 6))

    grid, hypotheses = proposed(rows(now), shapes_of(rows(before), "pq"))
    members = [set(hypotheses.cells[h].tolist()) for h in range(len(hypotheses))]
    for a, cells_a in zip(hypotheses.atoms, members):
        assert len(cells_a) > 0
        for b, cells_b in zip(hypotheses.atoms, members):
            assert set(a).isdisjoint(b) == cells_a.isdisjoint(cells_b)
    assert set().union(*members) == set(range(len(grid.cell))) if members else not len(grid.cell)
