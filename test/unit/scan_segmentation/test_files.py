"""Clouds of files, with and without lines; results as files."""

import json
import struct
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from safe_passage.core.errors import InputError, ParameterError
from safe_passage.evaluation.segment_scan import main, read_configuration
from safe_passage.evaluation.segmentation_places import garage, room
from safe_passage.scan_segmentation import ScanSegmenter
from safe_passage.scan_segmentation.organise import organise
from safe_passage.scan_segmentation.reading import Cloud, read_cloud
from safe_passage.scan_segmentation.scan import Level
from safe_passage.simulation.scan_scene import Scanner, scan_place

CONFIG = Path(__file__).resolve().parents[3] / "config"
POINTS = np.array([[1.0, 2.0, 3.0], [np.nan] * 3, [-4.5, 0.25, 1e-3], [7.0, 8.0, 9.0]])


def pcd(
    fields="x y z intensity", width=2, height=2, points=4, kind="ascii", viewpoint="1 2 3"
) -> str:
    count = len(fields.split())
    return (
        f"# .PCD v0.7\nVERSION 0.7\nFIELDS {fields}\nSIZE {'4 ' * count}\nTYPE {'F ' * count}\n"
        f"COUNT {'1 ' * count}\nWIDTH {width}\nHEIGHT {height}\n"
        f"VIEWPOINT 1 2 3 1 0 0 0\nPOINTS {points}\nDATA {kind}\n"
    )


def lines(points=POINTS) -> str:
    return "".join(f"{x} {y} {z} {10 * i}\n" for i, (x, y, z) in enumerate(points))


def check(cloud: Cloud) -> None:
    np.testing.assert_allclose(cloud.points.reshape(-1, 3), POINTS, rtol=1e-6)
    np.testing.assert_allclose(cloud.remission.ravel(), [0.0, 10.0, 20.0, 30.0])


def test_ascii_pcd(tmp_path):
    (tmp_path / "a.pcd").write_text(pcd() + lines())
    cloud = read_cloud(tmp_path / "a.pcd")
    check(cloud)
    assert cloud.points.shape == (2, 2, 3) and cloud.origin == (1.0, 2.0, 3.0)


def test_binary_pcd(tmp_path):
    data = np.column_stack([POINTS, 10.0 * np.arange(4)]).astype("<f4").tobytes()
    (tmp_path / "b.pcd").write_bytes(pcd(kind="binary").encode() + data)
    check(read_cloud(tmp_path / "b.pcd"))


def test_compressed_pcd(tmp_path):
    raw = np.vstack([POINTS.T, 10.0 * np.arange(4)]).astype("<f4").tobytes()  # field by field
    packed = b"".join(  # LZF's literal runs: nothing is saved, but it is the format
        bytes([len(raw[i : i + 32]) - 1]) + raw[i : i + 32] for i in range(0, len(raw), 32)
    )
    sizes = struct.pack("<II", len(packed), len(raw))
    (tmp_path / "c.pcd").write_bytes(pcd(kind="binary_compressed").encode() + sizes + packed)
    check(read_cloud(tmp_path / "c.pcd"))


def ply(points=4) -> str:
    return (
        f"ply\nformat ascii 1.0\nelement vertex {points}\nproperty float x\nproperty float y\n"
        "property float z\nproperty float intensity\nend_header\n"
    )


def test_ply(tmp_path):
    (tmp_path / "d.ply").write_text(ply() + lines())
    check(read_cloud(tmp_path / "d.ply"))


@pytest.mark.parametrize("head, comma", [("", " "), ("# a comment\n", ", "), ("4\n", " ")])
def test_xyz_in_its_dialects(tmp_path, head, comma):
    (tmp_path / "e.xyz").write_text(head + lines().replace(" ", comma))
    check(read_cloud(tmp_path / "e.xyz"))


def test_3dtk_is_turned_and_scaled_and_knows_lost_beams(tmp_path):
    (tmp_path / "f.3d").write_text("100 50 200\n0 0 3276\n")
    points = read_cloud(tmp_path / "f.3d").points[0]
    np.testing.assert_allclose(points[0], [2.0, -1.0, 0.5])
    assert np.isnan(points[1]).all()


@pytest.mark.parametrize(
    "name, content",
    [
        ("nothing.pcd", ""),
        ("noise.pcd", "\x00\x01nothing at all"),
        ("fields.pcd", pcd("x y intensity") + lines()),
        ("short.pcd", pcd(kind="binary") + "abc"),
        ("lies.pcd", pcd(width=10**9, height=4, points=4 * 10**9) + lines()),
        ("fat.pcd", pcd().replace("COUNT 1", f"COUNT {10**9}") + lines()),
        ("lies.ply", ply(10**10) + lines()),
        ("nothing.ply", ""),
        ("nothing.xyz", ""),
        ("words.xyz", "a b c\nd e f\n"),
        ("ragged.xyz", "1 2 3\n4 5 6 7\n"),
        ("image.bmp", "1 2 3\n"),
    ],
)
def test_files_that_are_no_clouds_are_refused_by_name(tmp_path, name, content):
    (tmp_path / name).write_text(content)
    with pytest.raises(InputError, match=name):
        read_cloud(tmp_path / name)
    with pytest.raises(InputError, match="missing"):
        read_cloud(tmp_path / "missing.pcd")


def as_files() -> dict:
    """A valid file of each format."""
    data = np.column_stack([POINTS, 10.0 * np.arange(4)]).astype("<f4").tobytes()
    return {
        "a.pcd": (pcd() + lines()).encode(),
        "b.pcd": pcd(kind="binary").encode() + data,
        "c.pcd": pcd(kind="binary_compressed").encode() + struct.pack("<II", 40, 64) + data[:40],
        "d.ply": (ply() + lines()).encode(),
        "e.xyz": lines().encode(),
        "f.3d": b"100 50 200\n0 0 3276\n",
    }


@settings(
    deadline=None, max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data(), name=st.sampled_from(sorted(as_files())))
def test_whatever_became_of_a_file_it_is_a_cloud_or_refused_by_name(tmp_path, data, name):
    content = bytearray(as_files()[name])
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(content) - 1))
        digits = st.integers(0, 10**12).map(lambda n: str(n).encode())
        more = data.draw(st.one_of(st.binary(max_size=8), digits, st.just(b"-1"), st.just(b"nan")))
        content[at : at + data.draw(st.integers(0, 12))] = more
        if not content:
            break
    file = tmp_path / name
    file.write_bytes(bytes(content))
    try:
        cloud = read_cloud(file)
    except InputError as error:
        assert name in str(error)
        return
    assert cloud.points.shape[-1] == 3
    assert cloud.points.size <= 3 * 100 * max(len(content), 1)


@pytest.fixture(scope="module")
def scan():
    return scan_place(garage(), Scanner(pitch=0.2, position=(0.0, 0.0, 1.3)), 4)[0]


def level_points(scan) -> tuple[np.ndarray, Level]:
    level = Level.of(scan)
    return level.points(scan.points.astype(float)), level


def test_lines_of_an_organised_cloud_are_its_rows(scan):
    points, level = level_points(scan)
    found = organise(Cloud(points, scan.remission, (0.0, 0.0, 0.0)))
    axis = level.R_level_scan @ np.array(scan.axis)
    assert abs(np.dot(found.axis, axis)) == pytest.approx(1.0, abs=1e-3)
    assert np.linalg.norm(found.origin) < 0.05
    assert len(found.beta) == len(scan.beta)


def test_columns_are_lines_of_a_cloud_that_is_turned(scan):
    points, _ = level_points(scan)
    found = organise(Cloud(points.swapaxes(0, 1), scan.remission.T, (0.0, 0.0, 0.0)))
    assert found.points.shape == scan.points.shape


@pytest.mark.parametrize("shuffled", [False, True])
def test_lines_of_an_unordered_cloud_are_found_about_a_main_axis(scan, shuffled):
    points = scan.points[scan.valid].astype(float)
    if shuffled:
        points = np.random.default_rng(0).permutation(points)
    found = organise(Cloud(points[None], None, (0.0, 0.0, 0.0)), up=scan.up)
    assert len(found.beta) == len(scan.beta) and found.notes == ()
    segmented = ScanSegmenter().segment(found)
    assert segmented.doors[0].width == pytest.approx(0.9, abs=0.03)


def test_an_axis_that_is_none_of_the_frames_is_told_by_the_order_or_given(scan):
    points, level = level_points(scan)
    ordered = points[scan.valid]
    axis = tuple(float(v) for v in level.R_level_scan @ np.array(scan.axis))
    found = organise(Cloud(ordered[None], None, (0.0, 0.0, 0.0)))
    assert abs(np.dot(found.axis, axis)) == pytest.approx(1.0, abs=1e-3)
    mixed = np.random.default_rng(0).permutation(ordered)
    given = organise(Cloud(mixed[None], None, (0.0, 0.0, 0.0)), axis=axis)
    assert len(given.beta) == len(found.beta) == len(scan.beta)


def test_a_cloud_without_lines_gets_some_and_says_so():
    rng = np.random.default_rng(0)
    scan, _ = scan_place(room(), Scanner(pitch=0.2), 1)
    points, _ = level_points(scan)
    points = points[scan.valid] + rng.normal(0.0, 0.01, (scan.valid.sum(), 3))
    found = organise(Cloud(rng.permutation(points)[None], None, (0.0, 0.0, 0.0)))
    assert found.notes and ScanSegmenter().segment(found).ground


def test_nothing_but_nan_is_refused():
    with pytest.raises(InputError, match="NaN"):
        organise(Cloud(np.full((1, 50, 3), np.nan), None, (0.0, 0.0, 0.0)))


@pytest.fixture(scope="module")
def written(tmp_path_factory, scan):
    """The command's folder for a scan, one without ground, and one that is no file."""
    folder = tmp_path_factory.mktemp("scans")
    points, _ = level_points(scan)
    values = np.column_stack([points[scan.valid], scan.remission[scan.valid]])
    np.savetxt(folder / "garage.xyz", values, fmt="%.4f")
    np.savetxt(folder / "up.xyz", values[values[:, 2] > 0.3], fmt="%.4f")
    (folder / "broken.pcd").write_text("nothing")
    return folder


def test_the_command_writes_what_it_says(written, capsys):
    out = written / "out"
    names = [str(written / name) for name in ("garage.xyz", "up.xyz")]
    assert main(CONFIG, [*names, "--out", str(out), "--walls"]) == 0
    said = capsys.readouterr().out
    assert "1 doors (1 passable)" in said and "REFUSED, scanner below the ground" in said
    values = json.loads((out / "garage" / "planes.json").read_text())
    assert values["doors"][0]["passable_by"] == ["smallest"]
    assert any(plane["ground"] for plane in values["planes"])
    assert [path.name for path in (out / "up").iterdir()] == ["refused.json"]
    assert json.loads((out / "up" / "refused.json").read_text())["reason"] == "SCANNER_BELOW_GROUND"


def test_maps_are_the_map_servers(written, scan):
    out = written / "out"
    if not out.exists():
        main(CONFIG, [str(written / "garage.xyz"), "--out", str(out)])
    meta = yaml.safe_load((out / "garage" / "drivable.yaml").read_text())
    image = cv2.imread(str(out / "garage" / meta["image"]), cv2.IMREAD_UNCHANGED)
    assert set(np.unique(image)) == {0, 128, 205, 254}
    column, row = ((np.array([1.5, 0.3]) - meta["origin"][:2]) / meta["resolution"]).astype(int)
    assert image[len(image) - 1 - row, column] == 254  # before the scanner the floor is free
    result = read_cloud(out / "garage" / "result.ply")
    assert result.points.shape[1] > scan.valid.sum()
    assert cv2.imread(str(out / "garage" / "picture.png")) is not None


def test_an_older_result_does_not_stay_beside_a_refusal(written):
    out = written / "again"
    (out / "up").mkdir(parents=True)
    (out / "up" / "picture.png").write_text("old")
    main(CONFIG, [str(written / "up.xyz"), "--out", str(out)])
    assert [path.name for path in (out / "up").iterdir()] == ["refused.json"]


def test_a_file_that_cannot_be_read_is_named_and_the_others_are_done(written, capsys):
    out = written / "mixed"
    names = [str(written / name) for name in ("broken.pcd", "up.xyz")]
    assert main(CONFIG, [*names, "--out", str(out)]) == 1
    said = capsys.readouterr().out
    assert "broken.pcd: cannot be used" in said and "up.xyz: REFUSED" in said


def test_a_robot_nobody_knows_is_refused(written, capsys):
    assert main(CONFIG, [str(written / "up.xyz"), "--robot", "tiny"]) == 1
    assert "smallest, wide, high" in capsys.readouterr().err


def test_the_configuration_names_what_is_wrong(tmp_path):
    robots, _ = read_configuration(CONFIG / "scan_segmentation.yaml")
    assert list(robots) == ["smallest", "wide", "high"]
    (tmp_path / "a.yaml").write_text("robots: {a: {widht: 1.0}}\n")
    with pytest.raises(ParameterError, match="widht"):
        read_configuration(tmp_path / "a.yaml")
    (tmp_path / "b.yaml").write_text("parameters: {}\n")
    with pytest.raises(ParameterError, match="robots"):
        read_configuration(tmp_path / "b.yaml")


def test_a_cluster_that_is_not_there_is_named(written, capsys):
    assert main(CONFIG, [str(written / "up.xyz"), "--dask", "tcp://localhost:1"]) == 1
    said = capsys.readouterr().err
    assert "distributed" in said or "tcp://localhost:1" in said
