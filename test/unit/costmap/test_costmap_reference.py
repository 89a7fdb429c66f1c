"""Against recordings of the real costmap_2d."""

from __future__ import annotations

import numpy as np
import pytest
from safe_passage.costmap.reference import reference_folder, replay

RECORDINGS = sorted(reference_folder().glob("*.npz"))

needs_recordings = pytest.mark.skipif(
    not RECORDINGS, reason=f"no recordings in {reference_folder()} (set SAFE_PASSAGE_DATA)"
)


@needs_recordings
def test_at_most_a_thousandth_of_the_cells_differ():
    steps = [pair for recording in RECORDINGS for pair in replay(recording)]
    different = sum(int((ours != recorded).sum()) for ours, recorded in steps)
    assert different / sum(ours.size for ours, _ in steps) <= 0.0003  # bar 0.001


@needs_recordings
@pytest.mark.parametrize("recording", RECORDINGS, ids=[path.stem for path in RECORDINGS])
def test_every_difference_is_explained(recording):
    """Two things differ, and without them not one cell does.

    The recorder's tf interpolates where the pose jumps between steps: one scan seen at 98 % of
    the way marks cells behind the wall, which no later ray clears. And costmap_2d leaves stray
    cells of a person who has left, which `clear_crossed_cells` clears.
    """
    for ours, recorded in replay(recording, switch=(0.98,), clear_crossed_cells=False):
        assert np.argwhere(ours != recorded).tolist() == []


@needs_recordings
@pytest.mark.parametrize("recording", RECORDINGS, ids=[path.stem for path in RECORDINGS])
def test_only_stray_cells_are_cleared_besides(recording):
    for ours, recorded in replay(recording, switch=(0.98,)):
        stray = (recorded == 100) & (ours < 100)
        assert stray.sum() <= 2
        assert not ((recorded < 100) & (ours == 100)).any()
