"""Real scans: what sees the floor is segmented, what looks upward only is refused."""

import os
from pathlib import Path

import pytest
from safe_passage.scan_segmentation import Reason, ScanSegmenter, SegmentationError
from safe_passage.scan_segmentation.organise import organise
from safe_passage.scan_segmentation.reading import read_cloud

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data"
DATA = Path(os.environ.get("SAFE_PASSAGE_DATA", SHARED)) / "rotating_scanner"
HEIGHT = (0.85, 1.0)  # [m] of that scanner over the floor, where it saw it
pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason=f"no recordings in {DATA}")


@pytest.mark.parametrize("name", ["A601", "A603"])
def test_a_scan_of_the_upper_half_is_refused(name):
    with pytest.raises(SegmentationError) as caught:
        ScanSegmenter().segment(organise(read_cloud(DATA / "dlut" / f"{name}.pcd")))
    assert caught.value.reason in (Reason.SCANNER_BELOW_GROUND, Reason.FEW_GROUND_POINTS)


@pytest.mark.parametrize("name", ["A605", "A607", "A609", "A617", "A625", "A629"])
def test_a_scan_that_sees_the_floor_is_segmented(name):
    found = ScanSegmenter().segment(organise(read_cloud(DATA / "dlut" / f"{name}.pcd")))
    assert HEIGHT[0] < -found.ground[0].height < HEIGHT[1]
    assert len(found.planes.valid) > 10


def test_a_3dtk_scan_has_its_lines_and_its_floor():
    scan = organise(read_cloud(DATA / "3dtk" / "scan000.3d"))
    assert len(scan.beta) == 226
    assert ScanSegmenter().segment(scan).ground
