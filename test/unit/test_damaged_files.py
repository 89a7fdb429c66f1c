"""Whatever became of a file: a result, or a clear error of ours that names it."""

import struct
from pathlib import Path

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from safe_passage._person_detection import load_pcd
from safe_passage._scan_segmentation import read_cloud
from safe_passage.core.errors import SafePassageError
from safe_passage.evaluation.tracking_runs import tracker_parameters
from safe_passage.robot_model.robot import load_robot_model
from safe_passage.robot_model.surfaces import load_mesh
from safe_passage.simulation.robot_files import load_robot_file
from safe_passage.simulation.worlds import load_world

CONFIG = Path(__file__).resolve().parents[2] / "config"
URDF = """<robot name="r"><link name="a"/><link name="b"><visual><geometry><box size="1 2 3"/>
</geometry></visual></link><joint name="j" type="revolute"><parent link="a"/><child link="b"/>
<origin xyz="0 0 1" rpy="0 1 0"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1"
velocity="1"/></joint></robot>"""
STL = b"\0" * 80 + struct.pack("<I", 1) + struct.pack("<12fH", *range(12), 0)
PCD = (
    "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
    "WIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\nDATA ascii\n"
    "1 1 2 0\n2 1 2 0\n1 2 2 0\n2 2 2 0\n"
)
FEW = settings(
    deadline=None,
    max_examples=120,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
pieces = st.one_of(
    st.binary(max_size=6),
    st.sampled_from([b"-1", b"nan", b"1e999", b"[]", b"{}", b": ", b"\n- ", b"null", b"'", b"\0"]),
    st.integers(-(10**12), 10**12).map(lambda n: str(n).encode()),
)


def damaged(data, content: bytes) -> bytes:
    """With some pieces replaced by others."""
    found = bytearray(content)
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(found)))
        found[at : at + data.draw(st.integers(0, 10))] = data.draw(pieces)
    return bytes(found)


FILES = {
    "robot.yaml": (load_robot_file, (CONFIG / "robots/summit_xl.yaml").read_bytes()),
    "world.yaml": (load_world, (CONFIG / "worlds/workshop.yaml").read_bytes()),
    "arm.urdf": (lambda file: load_robot_model(file, {}), URDF.encode()),
    "mesh.stl": (load_mesh, STL),
    "mesh.obj": (load_mesh, b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
}


@pytest.mark.parametrize("name", sorted(FILES))
@FEW
@given(data=st.data())
def test_files(tmp_path, name, data):
    load, content = FILES[name]
    (tmp_path / name).write_bytes(damaged(data, content))
    try:
        load(tmp_path / name)
    except SafePassageError as error:
        assert str(error)


@FEW
@given(data=st.data())
def test_coloured_clouds(tmp_path, data):
    (tmp_path / "frame.pcd").write_bytes(damaged(data, PCD.encode()))
    try:
        load_pcd(str(tmp_path / "frame.pcd"))
    except RuntimeError as error:
        assert "frame.pcd" in str(error)


def test_a_second_list_of_fields_does_not_make_points_larger_than_their_memory(tmp_path):
    """PCL reserves 4 points of 14 bytes, and writes 4 of 16. Found by tools/test --fuzz."""
    head = PCD[: PCD.index("DATA")].replace("rgb", "intensity").replace("SIZE 4", "SIZE 2")
    again = "FIELDS x y z intensity\n"
    (tmp_path / "scan.pcd").write_text(head + again + PCD[PCD.index("DATA") :])
    with pytest.raises(RuntimeError, match="scan.pcd: .*out of order: FIELDS"):
        read_cloud(str(tmp_path / "scan.pcd"))


def test_points_that_begin_like_a_header_do_not_change_it(tmp_path):
    """PCL 1.13.0 reads its header on behind DATA, and ended in an exception. Found by --fuzz."""
    head = PCD[: PCD.index("DATA")].replace("rgb", "intensity") + "DATA binary\n"
    for points in (b"FIELDS x y z i x y z i\n", b"\n# so\nDATA\n", b"COLUMNSx y\n"):
        (tmp_path / "scan.pcd").write_bytes(head.encode() + points + bytes(64))
        with pytest.raises(RuntimeError, match="scan.pcd: its points begin like a header"):
            read_cloud(str(tmp_path / "scan.pcd"))


CHANGES = {  # of PCD
    "a type that is none": ("TYPE F F F F", "TYPE F F F Q"),
    "a type of another size": ("SIZE 4 4 4 4", "SIZE 2 4 4 4"),
    "a field that is not there": ("COUNT 1 1 1 1", "COUNT 0 1 1 1"),
    "a size too few": ("SIZE 4 4 4 4", "SIZE 4 4 4"),
    "a negative size": ("SIZE 4 4 4 4", "SIZE 4 -4 4 4"),
    "a negative count": ("COUNT 1 1 1 1", "COUNT 1 -1 1 1"),
    "numbers with more behind": ("POINTS 4", "POINTS 4N"),
    "points before their size": ("SIZE 4", "POINTS 4\nSIZE 4"),
    "counts after the points": ("DATA", "COUNT 9 9 9 9\nDATA"),
    "width for its own": ("WIDTH 2", "WIDTH 3"),
    "more than 32 bits": ("WIDTH 2", "WIDTH 4294967298"),
    "a line nobody knows": ("HEIGHT", "DEPTH 2\nHEIGHT"),
    "a line that python cannot show": ("SIZE", "S\udc80ZE"),
    "no text": ("FIELDS x", "FIELDS \x01x"),
    "no points": (
        "WIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4",
        "WIDTH 0\nHEIGHT 0\nPOINTS 0",
    ),
    "a viewpoint nowhere": ("VIEWPOINT 0", "VIEWPOINT nan"),
    "data of no kind": ("ascii", "asci"),
    "no data": (PCD[PCD.index("DATA") :], "DATA ascii"),
    "a line too short": ("2 1 2 0", "2 1 2"),
    "a line too long": ("2 1 2 0", "2 1 2 0 0"),
    "a line too few": ("2 2 2 0\n", ""),
    "fewer bytes than points": ("DATA ascii", "DATA binary"),
}


@pytest.mark.parametrize("load, field", [(load_pcd, "rgb"), (read_cloud, "intensity")])
@pytest.mark.parametrize("change", sorted(CHANGES))
def test_unsound_point_clouds_are_refused(tmp_path, load, field, change):
    file = tmp_path / "cloud.pcd"
    changed = PCD.replace(*CHANGES[change])
    assert changed != PCD
    file.write_bytes(changed.replace("rgb", field).encode(errors="surrogateescape"))
    with pytest.raises(RuntimeError, match="cloud.pcd: (?!no readable|cloud has too few)"):
        load(str(file))


@pytest.mark.parametrize(
    "fields, packed, unpacked",
    [("x y z rgb", 10**6, 64), ("x y z rgb", 0, 64), ("x y z rgb", 66, 60), ("x y z _", 66, 64)],
)
def test_compressed_points_that_are_not_the_headers_are_refused(tmp_path, fields, packed, unpacked):
    file = tmp_path / "cloud.pcd"
    head = PCD[: PCD.index("DATA")].replace("x y z rgb", fields) + "DATA binary_compressed\n"
    data = (bytes([31]) + bytes(32)) * 2
    file.write_bytes(head.encode() + struct.pack("<II", packed, unpacked) + data)
    with pytest.raises(RuntimeError, match="cloud.pcd"):
        read_cloud(str(file))


@pytest.mark.parametrize("count", ["-3", "18446744073709551613", "many", ""])
def test_ply_files_that_count_no_points_are_refused(tmp_path, count):
    """PCL takes -3 as 2^32 - 3, and reserves as much. Found by tools/test --fuzz."""
    head = "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
    text = head.format(count) + "property float z\nend_header\n1 1 2\n"
    (tmp_path / "scan.ply").write_text(text)
    with pytest.raises(RuntimeError, match="scan.ply: its header"):
        read_cloud(str(tmp_path / "scan.ply"))


@FEW
@given(data=st.data())
def test_parameters_of_the_tracker(tmp_path, data):
    text = damaged(data, (CONFIG / "obstacle_tracker.yaml").read_bytes())
    (tmp_path / "obstacle_tracker.yaml").write_bytes(text)
    try:
        tracker_parameters(tmp_path)
    except SafePassageError as error:
        assert str(error)


def test_the_valid_files_are_read(tmp_path):
    for name, (load, content) in FILES.items():
        (tmp_path / name).write_bytes(content)
        assert load(tmp_path / name)
    assert yaml.safe_load(FILES["robot.yaml"][1])["robot"]
