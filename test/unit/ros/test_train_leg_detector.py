"""train_leg_detector: bags in, a model and a table out."""

import sys

import numpy as np
import pytest
import rosbag
import rospy
from geometry_msgs.msg import Point, Pose, PoseArray
from leg_world import look, walk
from safe_passage.core.errors import InputError
from safe_passage.leg_detection.classifiers import load
from safe_passage.ros import train_leg_detector
from sensor_msgs.msg import LaserScan


def to_message(scan):
    return LaserScan(
        angle_min=scan.angle_min, angle_increment=scan.angle_increment, range_min=scan.range_min,
        range_max=scan.range_max, ranges=np.asarray(scan.ranges).tolist(),
    )  # fmt: skip


def write(path, scans, legs=None):
    with rosbag.Bag(str(path), "w") as bag:
        for i, scan in enumerate(scans):
            message, time = to_message(scan), rospy.Time(100, 1000 * (i + 1))
            message.header.stamp = rospy.Time.from_sec(100.0 + scan.stamp)
            bag.write("/scan", message, time)
            if legs:
                poses = [Pose(position=Point(x, y, 0.0)) for x, y in legs[i]]
                bag.write("/legs", PoseArray(poses=poses), time)


@pytest.fixture(scope="module")
def bags(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bags")
    for seed in (1, 2):
        recording, _ = walk("walk", seed)
        write(folder / f"walk_{seed}.bag", recording.scans, recording.legs)
    write(folder / "empty.bag", [look([], stamp=0.1 * i).scan for i in range(12)])
    return folder


def call(monkeypatch, *arguments):
    monkeypatch.setattr(sys, "argv", ["train_leg_detector", *map(str, arguments)])
    train_leg_detector.main()


def test_bags_make_a_model_and_a_table(bags, tmp_path, monkeypatch, capsys):
    output = tmp_path / "legs.model"
    positive = bags / "walk_1.bag", bags / "walk_2.bag"
    negative = "--negative", bags / "empty.bag"
    call(
        monkeypatch, "--positive", *positive, *negative, "--output", output,
        "--jump-distance", "0.11",
    )  # fmt: skip
    model = load(output)
    assert model.name == "random_forest"
    assert model.segmentation.jump_distance == 0.11
    assert model.trained_on == "walk_1.bag, walk_2.bag, empty.bag"
    said = capsys.readouterr()
    assert "walk_2.bag: " in said.err
    assert "0 segments of unknown truth" in said.err
    assert "random_forest: 8 models to train and judge" in said.err  # two walks, six blocks
    assert [line.split("|")[1].strip() for line in said.out.splitlines()] == [
        "Method", "---", "random_forest"
    ]  # fmt: skip


def test_every_classifier_in_the_table(bags, tmp_path, monkeypatch, capsys):
    positive = bags / "walk_1.bag", bags / "walk_2.bag"
    call(monkeypatch, "--positive", *positive, "--output", tmp_path / "m", "--all")
    rows = [line.split("|")[1].strip() for line in capsys.readouterr().out.splitlines()[2:]]
    assert rows == ["adaboost", "svm", "random_forest"]


def test_the_table_can_be_left_out(bags, tmp_path, monkeypatch, capsys):
    bag = bags / "walk_1.bag"
    call(
        monkeypatch, "--positive", bag, "--output", tmp_path / "m", "--no-table",
        "--classifier", "svm",
    )  # fmt: skip
    assert load(tmp_path / "m").name == "svm"
    assert capsys.readouterr().out == ""


def test_one_recording_cannot_judge_itself(bags, tmp_path, monkeypatch):
    with pytest.raises(InputError, match="legs of one recording alone"):
        call(monkeypatch, "--positive", bags / "walk_1.bag", "--output", tmp_path / "m")
    assert load(tmp_path / "m")


def test_a_missing_bag_is_named(bags, tmp_path, monkeypatch):
    with pytest.raises(InputError, match="none.bag"):
        call(monkeypatch, "--positive", bags / "none.bag", "--output", tmp_path / "m")
    assert not (tmp_path / "m").exists()
