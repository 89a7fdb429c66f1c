"""Datasets: what is written is what is read, by this package's readers and by others'."""

import dataclasses
import json
import math

import numpy as np
import pytest
import safe_passage._person_detection as detection
import yaml
from eval_worlds import SETTING
from safe_passage.core.errors import InputError
from safe_passage.evaluation.dataset import Dataset, write_dataset
from safe_passage.evaluation.parallel import Workers
from safe_passage.replay.sources import FileSource

FIRST, COUNT = 4_100_000, 3


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("views") / "dataset"
    write_dataset(made, SETTING, FIRST, COUNT, clouds=True, workers=Workers())
    return made


def test_round_trip(folder, sampler):
    read = Dataset(folder)
    assert len(read) == COUNT
    for number, view in enumerate(read):
        drawn = sampler.draw(FIRST + number)
        assert np.array_equal(view.bgr, drawn.bgr)
        assert np.array_equal(np.isnan(view.depth), np.isnan(drawn.depth))
        assert np.nanmax(np.abs(view.depth - drawn.depth)) < 0.00051  # files hold millimetres
        assert np.array_equal(view.ranges, drawn.ranges)
        assert np.array_equal(view.beam_persons, drawn.beam_persons)
        assert view.persons == drawn.persons
        assert view.pose == pytest.approx(drawn.pose)
        assert view.T_map_camera == pytest.approx(drawn.T_map_camera)
    assert read.camera == sampler.camera
    assert read.lidar == sampler.lidar


def test_it_says_what_made_it(folder):
    about = yaml.safe_load((folder / "dataset.yaml").read_text())
    assert (about["world"], about["robot"]) == ("warehouse", "summit_xl")
    assert (about["first"], about["count"]) == (FIRST, COUNT)
    truth = json.loads((folder / "truth.json").read_text())
    assert [entry["name"] for entry in truth] == [f"{FIRST + i:07d}" for i in range(COUNT)]


def test_it_can_be_replayed(folder, sampler):
    source = FileSource(folder, seconds_per_frame=1.0)
    assert len(source.files) == COUNT
    frame = source.frame(0.0)
    assert frame.intrinsics == sampler.camera.intrinsics
    assert frame.p_base_camera[2] == pytest.approx(sampler.camera.z, abs=0.05)


def test_the_cloud_is_the_depth(folder, sampler):
    view = sampler.draw(FIRST)
    cloud = detection.load_pcd(str(folder / f"{FIRST:07d}_cloud.pcd"))
    ours = detection.from_depth(
        view.depth, view.bgr, detection.Intrinsics(*sampler.camera.intrinsics)
    )
    known = np.isfinite(view.depth)
    assert cloud.xyz[known] == pytest.approx(ours.xyz[known], abs=1e-5)
    assert np.isnan(cloud.xyz[~known]).all()
    assert np.array_equal(cloud.bgr, view.bgr)


def test_more_processes_write_the_same(folder, tmp_path):
    write_dataset(tmp_path / "two", SETTING, FIRST, COUNT, clouds=False, workers=Workers(2))
    for file in sorted((tmp_path / "two").iterdir()):
        if file.suffix != ".npz":  # whose archive holds the time
            assert file.read_bytes() == (folder / file.name).read_bytes(), file.name
    ours, theirs = Dataset(folder), Dataset(tmp_path / "two")
    assert all(np.array_equal(a.ranges, b.ranges) for a, b in zip(ours, theirs))


def test_nothing_is_overwritten(folder):
    with pytest.raises(InputError, match="is not empty"):
        write_dataset(folder, SETTING, FIRST, 1, clouds=False, workers=Workers())


def test_what_is_damaged_is_named(folder, tmp_path):
    with pytest.raises(InputError, match=r"dataset\.yaml"):
        Dataset(tmp_path)
    (tmp_path / "dataset.yaml").write_text("{format: something else}")
    with pytest.raises(InputError, match="format"):
        Dataset(tmp_path)
    (tmp_path / "dataset.yaml").write_text((folder / "dataset.yaml").read_text())
    (tmp_path / "truth.json").write_text("[")
    with pytest.raises(InputError, match=r"truth\.json"):
        Dataset(tmp_path)
    (tmp_path / "truth.json").write_text((folder / "truth.json").read_text())
    with pytest.raises(InputError, match="_rgb.png"):
        Dataset(tmp_path)[0]


def test_persons_are_as_the_format_says(folder):
    fields = {"id", "body", "position", "velocity", "distance", "box", "visible"}
    persons = [p for view in Dataset(folder) for p in view.persons]
    assert persons, "draw other views"
    for person in persons:
        assert set(dataclasses.asdict(person)) == fields
        assert all(map(math.isfinite, (*person.position, *person.box, person.visible)))
