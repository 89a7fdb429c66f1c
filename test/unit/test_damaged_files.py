"""Whatever became of a file: a result, or a clear error of ours that names it."""

import struct
from pathlib import Path

import pytest
import yaml
from damage import FEW, damaged
from hypothesis import given
from hypothesis import strategies as st
from safe_passage._person_detection import load_pcd
from safe_passage._scan_segmentation import read_cloud
from safe_passage.core.errors import InputError, SafePassageError
from safe_passage.core.reading import read_yaml
from safe_passage.costmap.loading import load_costmap_parameters
from safe_passage.evaluation.tracking_runs import tracker_parameters
from safe_passage.leg_detection import classifiers
from safe_passage.leg_detection.segmentation import SegmentationParameters
from safe_passage.robot_model.robot import load_robot_model
from safe_passage.robot_model.surfaces import load_mesh
from safe_passage.scan_segmentation.configuration import read_configuration
from safe_passage.simulation.robot_files import load_robot_file
from safe_passage.simulation.worlds import load_world

CONFIG = Path(__file__).resolve().parents[2] / "config"
URDF = """<robot name="r"><link name="a"/><link name="b"><visual><geometry><box size="1 2 3"/>
</geometry></visual></link><joint name="j" type="revolute"><parent link="a"/><child link="b"/>
<origin xyz="0 0 1" rpy="0 1 0"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1"
velocity="1"/></joint></robot>"""
STL = b"\0" * 80 + struct.pack("<I", 1) + struct.pack("<12fH", *range(12), 0)
DAE = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimeter" meter="0.01"/></asset><library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#a" count="3" stride="3"><param name="X" type="float"/><param name="Y"
type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="1">
<input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/>
</node></visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene>
</COLLADA>"""
PCD = (
    "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
    "WIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\nDATA ascii\n"
    "1 1 2 0\n2 1 2 0\n1 2 2 0\n2 2 2 0\n"
)
FILES = {
    "robot.yaml": (load_robot_file, (CONFIG / "robots/summit_xl.yaml").read_bytes()),
    "world.yaml": (load_world, (CONFIG / "worlds/workshop.yaml").read_bytes()),
    "arm.urdf": (lambda file: load_robot_model(file, {}), URDF.encode()),
    "scan_segmentation.yaml": (
        read_configuration,
        (CONFIG / "scan_segmentation.yaml").read_bytes(),
    ),
    "local_costmap.yaml": (
        lambda file: load_costmap_parameters(read_yaml(file)),
        (CONFIG / "local_costmap.yaml").read_bytes(),
    ),
    "mesh.dae": (load_mesh, DAE.encode()),
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
def test_what_a_leg_model_says_of_itself(tmp_path, data):
    """Its first line; what follows is a pickle, of which only a trusted one is read."""
    file = tmp_path / "legs.model"
    classifiers.save(classifiers.LegModel("adaboost", [1], SegmentationParameters()), file)
    head, _, estimator = file.read_bytes().partition(b"\n")
    changed = damaged(data, head).replace(b"\n", b" ")
    file.write_bytes(changed + b"\n" + estimator)
    try:
        assert classifiers.load(file).estimator == [1]
    except InputError as error:
        assert "legs.model" in str(error)


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
