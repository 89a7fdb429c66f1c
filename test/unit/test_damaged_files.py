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


@pytest.mark.parametrize(
    "change", [("TYPE F F F F", "TYPE F F F Q"), ("COUNT 1 1 1 1", "COUNT 0 1 1 1")]
)
def test_scans_whose_fields_make_no_sense(tmp_path, change):
    """Found by tools/test --fuzz."""
    file = tmp_path / "scan.pcd"
    file.write_text(PCD.replace("rgb", "intensity").replace(*change))
    with pytest.raises(RuntimeError, match="scan.pcd"):
        read_cloud(str(file))


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
