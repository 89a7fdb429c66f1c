"""CLEAR-MOT and IDF1 of tracks, on examples worked out by hand."""

from pathlib import Path

import numpy as np
import pytest
from safe_passage.evaluation import tracking_diagnosis
from safe_passage.evaluation import tracking_metrics as metrics
from safe_passage.evaluation.tracking_catalogue import Catalogue
from safe_passage.evaluation.tracking_recording import Recording
from safe_passage.evaluation.tracking_runs import Told

CONFIG = Path(__file__).resolve().parents[3] / "config"
CYCLES = 10


@pytest.fixture(scope="module")
def scenario():
    return Catalogue(CONFIG, 1).make("static_turning")


@pytest.fixture()
def recording(scenario):
    """Person 0 walks along x, 1 m a cycle, person 1 parallel to it, 5 m beside."""

    def make(people: int = 1, visible: np.ndarray | None = None, moved: np.ndarray | None = None):
        way = np.zeros((CYCLES, people, 4))
        way[:, :, 0] = np.arange(CYCLES)[:, None]
        way[:, :, 1] = 5.0 * np.arange(people)
        yes = np.ones((CYCLES, people), bool)
        return Recording(
            scenario,
            np.arange(CYCLES) * 0.08,
            np.zeros((CYCLES, 3)),
            way,
            yes if visible is None else visible,
            yes if moved is None else moved,
            ((),) * CYCLES,
        )

    return make


def told(*tracks: tuple[int, float, float, bool], fresh: bool = True) -> Told:
    """id, x, y, moving of each track of a cycle."""
    count = len(tracks)
    return Told(
        np.array([track[0] for track in tracks], int),
        np.array([track[1:3] for track in tracks], float).reshape(count, 2),
        np.zeros((count, 2)),
        np.array([track[3] for track in tracks], bool),
        np.full(count, fresh),
    )


def test_a_track_that_never_errs(recording):
    found = metrics.score(recording(), [told((7, t + 0.1, 0.0, True)) for t in range(CYCLES)])
    assert (found.objects, found.misses, found.false_positives, found.switches) == (10, 0, 0, 0)
    assert (found.mota, found.idf1) == (1.0, 1.0)
    assert found.motp == pytest.approx(0.1)


def test_a_new_identity_half_way_is_one_switch_and_half_of_the_identities(recording):
    cycles = [told((1 if t < 5 else 2, t + 0.1, 0.0, True)) for t in range(CYCLES)]
    found = metrics.score(recording(), cycles)
    assert found.switches == 1
    assert found.mota == pytest.approx(0.9)
    assert (found.idtp, found.idfp, found.idfn) == (5, 5, 5)
    assert found.idf1 == pytest.approx(0.5)
    assert found.motp == pytest.approx(0.1)  # motmetrics' own would count the switch twice
    assert metrics.identities(recording(), cycles) == {0: [1, 2]}


def test_misses_and_false_positives(recording):
    """3 cycles without a track, 2 with one on a thing besides: 1 - 5 / 10."""
    cycles = [told((1, t, 0.0, t >= 3), (2, 0.0, 9.0, t < 2)) for t in range(CYCLES)]
    found = metrics.score(recording(), cycles)
    assert (found.misses, found.false_positives, found.switches) == (3, 2, 0)
    assert found.mota == pytest.approx(0.5)
    assert found.idf1 == pytest.approx(2 * 7 / (2 * 7 + 2 + 3))


def test_a_track_farther_away_than_the_gate_is_a_miss_and_a_false_positive(recording):
    found = metrics.score(recording(), [told((1, t + 0.51, 0.0, True)) for t in range(CYCLES)])
    assert (found.misses, found.false_positives) == (10, 10)
    assert found.mota == pytest.approx(-1.0)
    assert np.isnan(found.motp)


def test_a_track_for_each_leg_is_one_too_many(recording):
    cycles = [told((1, t, 0.1, True), (2, t, -0.2, True)) for t in range(CYCLES)]
    found = metrics.score(recording(), cycles)
    assert (found.misses, found.false_positives) == (0, 10)


def test_two_people_who_swap_their_tracks(recording):
    cycles = []
    for t in range(CYCLES):
        first, second = (1, 2) if t < 5 else (2, 1)
        cycles.append(told((first, t, 0.0, True), (second, t, 5.0, True)))
    found = metrics.score(recording(people=2), cycles)
    assert (found.objects, found.switches) == (20, 2)
    assert found.mota == pytest.approx(1.0 - 2 / 20)
    assert found.idf1 == pytest.approx(0.5)


def test_who_is_hidden_is_neither_wanted_nor_forbidden(recording):
    visible = np.ones((CYCLES, 1), bool)
    visible[4:7] = False
    followed = [told((1, t, 0.0, True)) for t in range(CYCLES)]
    dropped = [told((1, t, 0.0, True)) if visible[t] else told() for t in range(CYCLES)]
    for cycles in (followed, dropped):
        found = metrics.score(recording(visible=visible), cycles)
        assert (found.objects, found.mota, found.idf1) == (7, 1.0, 1.0)


def test_who_has_not_moved_yet_must_not_be_called_moving(recording):
    moved = np.arange(CYCLES)[:, None] >= 4
    found = metrics.score(recording(moved=moved), [told((1, t, 0.0, True)) for t in range(CYCLES)])
    assert (found.objects, found.false_positives) == (6, 4)


def test_a_track_that_was_not_seen_just_now_is_no_answer(recording):
    cycles = [told((1, t, 0.0, True), fresh=t < 8) for t in range(CYCLES)]
    found = metrics.score(recording(), cycles)
    assert (found.misses, found.false_positives) == (2, 0)


def test_tracks_of_things_that_are_called_moving_at_any_time(recording):
    """Track 1 is the person; 2 and 3 are things, 3 once called moving; 4 begins at the person."""
    cycles = []
    for t in range(CYCLES):
        fourth = (4, 0.4, 0.0, True) if t == 0 else (4, 0.4, 8.0, True)
        cycles.append(told((1, t, 0.0, True), (2, 3.0, 2.0, False), (3, 3.0, -2.0, t == 5), fourth))
    found = metrics.score(recording(), cycles)
    assert (found.static_tracks, found.false_moving) == (2, 1)
    assert found.false_moving_share == 0.5


def test_without_people_there_is_no_accuracy(recording):
    found = metrics.score(recording(people=0), [told((1, 0.0, 0.0, False))] * CYCLES)
    assert np.isnan(found.mota) and np.isnan(found.idf1)
    assert found.false_moving_share == 0.0


def test_scores_add_up(recording):
    a = metrics.score(recording(), [told((1, t, 0.0, True)) for t in range(CYCLES)])
    b = metrics.score(recording(), [told()] * CYCLES)
    assert (a + b).mota == pytest.approx(0.5)
    assert (a + b).objects == 20


def test_a_diagnosis_says_when_and_why(recording):
    """No track for 3 cycles, then one that stands for 2; a thing called moving at the end."""
    cycles = []
    for t in range(CYCLES):
        own = [(1, float(t), 0.0, t >= 5)] if t >= 3 else []
        cycles.append(told(*own, (2, 0.0, 9.0, t == 9)))
    missed = tracking_diagnosis.misses(recording(), cycles)
    assert missed == {0: [(0.0, 0.16, "no track"), (0.24, 0.32, "not moving")]}
    strays = tracking_diagnosis.strays(recording(), cycles)
    assert strays == {2: [(0.72, 0.72, "at (0.0, 9.0), 12.7 m from person 0")]}
    assert "person 0: 0.0-0.2 s no track" in tracking_diagnosis.as_text(recording(), cycles)
