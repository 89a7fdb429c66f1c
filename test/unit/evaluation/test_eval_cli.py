"""evaluate's command line: what is wrong is said, what is right is written."""

import json

import cv2
import numpy as np
import pytest
from eval_worlds import CONFIG
from safe_passage.evaluation import closed_loop_table, leg_report, plots
from safe_passage.evaluation.cli import main
from safe_passage.evaluation.closed_loop import TRACK, RunResult
from safe_passage.evaluation.report import plain, shown, table
from safe_passage.evaluation.warehouse_legs import JudgedSegment
from safe_passage.leg_detection.training_data import LEG, OTHER
from safe_passage.navigation import State


def no_bags(positive, negative):
    raise AssertionError("not asked for")


def run(*arguments):
    return main(CONFIG, no_bags, [str(argument) for argument in arguments])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "command"),
        (["fly"], "invalid choice"),
        (["detector", "--methods", "hog,magic"], "known are hog, yolo"),
        (["detector", "--methods", "none"], "known are hog, yolo"),
        (["detector", "--frames", "0"], "less than 1"),
        (["detector", "--frames", "many"], "invalid"),
        (["closed-loop", "--processes", "0"], "less than 1"),
        (["closed-loop", "--runs", "-3"], "less than 1"),
        (["dataset", "--seed", "-1"], "less than 0"),
        (["recordings"], "folder"),
    ],
)
def test_wrong_arguments(capsys, arguments, message):
    with pytest.raises(SystemExit) as stopped:
        run(*arguments)
    assert stopped.value.code == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["dataset", "--world", "nowhere.yaml"], "nowhere.yaml"),
        (["detector", "--dataset", "nowhere"], "nowhere"),
        (["legs", "--negative", "one.bag"], "needs positive recordings"),
        (["closed-loop", "--robot", "nobody.yaml"], "nobody.yaml"),
        (["closed-loop", "--costmap", "flat.yaml", "--runs", "1"], "flat.yaml"),
    ],
)
def test_what_cannot_be_used_is_one_line(capsys, tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    assert run(*arguments) == 1
    said = [line for line in capsys.readouterr().err.splitlines() if line.startswith("evaluate:")]
    assert len(said) == 1 and message in said[0]


def test_a_dataset_is_written_and_judged(capsys, tmp_path):
    assert run("dataset", "--frames", 2, "--seed", 4_400_000, "--out", tmp_path / "views") == 0
    assert "2 views" in capsys.readouterr().out
    arguments = ("--dataset", tmp_path / "views", "--methods", "hog", "--out", tmp_path / "out")
    assert run("detector", *arguments) == 0
    assert "| hog |" in capsys.readouterr().out
    assert json.loads((tmp_path / "out" / "detector.json").read_text())["views"] == 2
    assert cv2.imread(str(tmp_path / "out" / "detector.png")) is not None


def test_legs_asks_for_the_bags_that_are_named(tmp_path, monkeypatch, capsys):
    asked = []
    report = leg_report.LegReport([], {}, {"nothing": []})
    monkeypatch.setattr(leg_report, "judge_legs", lambda *args: report)
    main(
        CONFIG,
        lambda positive, negative: asked.append((positive, negative)),
        ["legs", "--positive", "a.bag", "b.bag", "--negative", "c.bag", "--out", str(tmp_path)],
    )
    assert [[path.name for path in paths] for paths in asked[0]] == [["a.bag", "b.bag"], ["c.bag"]]
    assert (tmp_path / "legs.png").exists()


def test_a_closed_loop_is_written(tmp_path, monkeypatch, capsys):
    track = np.ones((5, len(TRACK)))
    outcomes = [
        closed_loop_table.Outcome(
            0, RunResult(kind, method, State.SUCCEEDED, 9.0, 1.0, 1.1, 0.1, 0, track), True
        )
        for kind in ("standing", "walking")
        for method in closed_loop_table.METHODS
    ]
    monkeypatch.setattr(closed_loop_table, "run_all", lambda *args: outcomes)
    assert run("closed-loop", "--out", tmp_path) == 0
    values = json.loads((tmp_path / "closed_loop.json").read_text())
    assert len(values["runs"]) == 8 and len(values["summaries"]) == 8
    with np.load(tmp_path / "tracks.npz") as tracks:
        assert tracks["standing_0_yolo"].shape == track.shape
    for name in ("distances.png", "tracks.png"):
        assert cv2.imread(str(tmp_path / name)) is not None
    assert "walking, yolo" in capsys.readouterr().out


def test_a_picture_of_segments(tmp_path):
    points = np.random.default_rng(0).normal(2.0, 0.05, (9, 2))
    found = [JudgedSegment(points, label, 0.8, "pallet") for label in (LEG, OTHER)]
    plots.draw_legs({"pallet": found, "person": []}, tmp_path / "legs.png")
    assert cv2.imread(str(tmp_path / "legs.png")) is not None


def test_numbers_in_tables():
    assert [shown(v) for v in (1, 0.12345, 1234.5, float("nan"), None, "text")] == [
        *("1", "0.123", "1234", "-", "-", "text"),
    ]
    assert table(("a", "b"), [(1, 2.0)]) == "| a | b |\n|---|---|\n| 1 | 2.000 |"


def test_json_has_no_infinities():
    values = {"a": np.float64("inf"), 1: [np.int64(2), float("nan")], "c": np.arange(2), "d": True}
    assert plain(values) == {"a": None, "1": [2, None], "c": [0, 1], "d": True}
