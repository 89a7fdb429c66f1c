"""Legs in the warehouse: what beams met, the same runs for a number, the tables' own counts."""

import dataclasses

import numpy as np
import pytest
from eval_worlds import SETTING
from safe_passage.core.geometry import placed
from safe_passage.evaluation import warehouse_legs
from safe_passage.evaluation.leg_report import as_markdown, as_values, examples, judge_legs
from safe_passage.evaluation.leg_tables import judge
from safe_passage.evaluation.parallel import Workers
from safe_passage.evaluation.warehouse_legs import (
    SCANS,
    JudgedSegment,
    draw_run,
    judged_segments,
    shares,
    thing_at,
)
from safe_passage.leg_detection.classifiers import train
from safe_passage.leg_detection.segmentation import SegmentationParameters
from safe_passage.leg_detection.training_data import LEG, OTHER, from_labelled_scans, joined
from safe_passage.simulation.worlds import make_world

FIRST = 4_300_000
P = SegmentationParameters()


@pytest.fixture(scope="module")
def hall():
    """A pallet's board along x, a post, and a beam over the scanner."""
    boxes = [
        {"x": 0.0, "y": 0.0, "size": [1.2, 0.8, 0.144], "material": "wood"},
        {"x": 0.0, "y": 2.0, "size": [0.1, 0.1, 3.0], "material": "steel"},
        {"x": 3.0, "y": 0.0, "z": 1.0, "size": [1.0, 1.0, 0.2], "material": "cardboard"},
    ]
    return make_world({"name": "hall", "size": [10, 10], "start": [0, 0, 0], "boxes": boxes})


@pytest.mark.parametrize(
    ("point", "thing"),
    [
        ((0.61, 0.2), "pallet"),
        ((0.0, 1.94), "rack upright"),
        ((0.06, 2.0), "rack upright"),
        ((4.9, 0.0), "wall"),
        ((0.0, 1.1), "pallet"),  # 0.7 m from it, 0.85 m from the post
    ],
)
def test_what_is_at_a_point(hall, point, thing):
    assert thing_at(hall, np.array([point]), 0.12) == thing


def test_only_what_reaches_the_scanner_counts(hall):
    assert thing_at(hall, np.array([(3.0, 0.4)]), 0.12) != "goods"
    assert thing_at(hall, np.array([(3.0, 0.4)]), 1.1) == "goods"


def test_most_points_decide(hall):
    points = np.array([(0.6, 0.0), (0.6, 0.1), (0.0, 1.95)])
    assert thing_at(hall, points, 0.12) == "pallet"


def test_a_number_gives_one_run(sampler):
    one, again = draw_run(sampler, FIRST), draw_run(sampler, FIRST)
    assert len(one.scans) == SCANS
    for a, b in zip(one.scans, again.scans):
        assert np.array_equal(a.scan.ranges, b.scan.ranges)
        assert np.array_equal(a.person_beams, b.person_beams)
    assert [s.scan.stamp for s in one.scans] == pytest.approx(np.arange(SCANS) * 0.1)


def test_what_stands_is_met_where_the_world_has_it(sampler):
    """All beams that met no person end at a block: within the noise of the scanner."""
    run = draw_run(sampler, FIRST)
    world, _ = SETTING.load()
    labelled = run.scans[0]
    met = labelled.scan.returns() & ~labelled.person_beams
    angles = labelled.scan.angles()[met]
    ranges = labelled.scan.ranges[met]
    points = placed(np.stack([ranges * np.cos(angles), ranges * np.sin(angles)], 1), run.laser)
    height = sampler.lidar.z
    blocks = [b for b in world.blocks if b.z <= height <= b.z + b.size[2]]
    away = [
        np.hypot(*np.maximum(np.abs(_local(points, b)) - 0.5 * np.array(b.size[:2]), 0.0).T)
        for b in blocks
    ]
    assert np.quantile(np.min(away, axis=0), 0.99) < 0.03


def _local(points, block):
    c, s = np.cos(block.yaw), np.sin(block.yaw)
    return (points - (block.x, block.y)) @ np.array([[c, -s], [s, c]])


@pytest.fixture(scope="module")
def runs(sampler):
    return [draw_run(sampler, FIRST + i) for i in range(6)]


def test_segments_are_those_of_the_table(runs):
    data = joined(from_labelled_scans(r.scans, P, "all", False) for r in runs)
    model = train("random_forest", data, P)
    world, robot = SETTING.load()
    counts = judge(model, from_labelled_scans(runs[0].scans, P, "", judging=True))
    found = list(judged_segments(model, runs[0], world, robot.lidars[0].z))
    assert len(found) == counts.tp + counts.fp + counts.fn + counts.tn
    assert sum(s.false_alarm for s in found) == counts.fp
    assert sum(s.label == LEG for s in found) == counts.tp + counts.fn
    assert all((s.thing == "person") == (s.label == LEG) for s in found)


def test_shares_by_hand():
    def one(thing, label, probability):
        return JudgedSegment(np.zeros((3, 2)), label, probability, thing)

    found = [
        *[one("pallet", OTHER, 0.9)] * 3,
        *[one("pallet", OTHER, 0.1)] * 5,
        one("wall", OTHER, 0.8),
        one("person", LEG, 0.9),
    ]
    assert shares(found) == [("pallet", 8, 3, 0.75), ("wall", 1, 1, 0.25)]
    chosen = examples(found)
    assert {thing: len(segments) for thing, segments in chosen.items()} == {
        "pallet": 3,
        "rack upright": 0,
        "person": 1,
    }


def test_who_would_walk_into_a_rack_stands(sampler):
    pose, people = sampler.draw_places(np.random.default_rng(5))
    while not any(people):
        pose, people = sampler.draw_places(np.random.default_rng(6))
    person = next(p for p in people if p)
    fast = dataclasses.replace(person, velocity=(50.0, 0.0))
    assert warehouse_legs._walks_or_stands(sampler, fast, 1.0).stands
    slow = dataclasses.replace(person, velocity=(0.001, 0.0))
    assert not warehouse_legs._walks_or_stands(sampler, slow, 1.0).stands


def test_the_report_without_recordings():
    report = judge_legs(SETTING, FIRST, 4, None, Workers())
    assert not report.real
    assert list(report.warehouse) == ["other simulated scans"]
    markdown = as_markdown(report)
    assert "Table 1" not in markdown
    assert "| the paper's svm | 0.310 |" in markdown
    rows = as_values(report)["table_2"]["other simulated scans"]
    assert set(rows) == {"adaboost", "svm", "random_forest"}
