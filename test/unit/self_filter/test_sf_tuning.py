"""Other parameters while a self-filter runs: they count, and what it remembers stays."""

from __future__ import annotations

import numpy as np
import pytest
from safe_passage.core.errors import InputError
from safe_passage.robot_model import JointHistory
from safe_passage.self_filter import SelfFilterParameters
from test_sf_filter import T_CAMERA_ROOT, make, seen, still


@pytest.mark.parametrize("change", [{"padding": 0.08}, {"edge": 4}, {"depth_noise": 0.1}])
def test_it_filters_as_one_made_with_the_new_parameters(change):
    depth, joints = seen(0.3), still(0.3)
    tuned, fresh, old = make(), make(**change), make()
    tuned.filter(depth, 0.0, joints, T_CAMERA_ROOT)
    tuned.tune(SelfFilterParameters(**change))
    found, wanted, before = (
        f.filter(depth, 0.0, joints, T_CAMERA_ROOT) for f in (tuned, fresh, old)
    )
    np.testing.assert_array_equal(found.removed, wanted.removed)
    np.testing.assert_array_equal(found.front, wanted.front)
    if "padding" in change:
        assert np.isfinite(found.front).sum() > np.isfinite(before.front).sum()
    for one in (tuned, fresh, old):
        one.close()


def test_joint_states_survive():
    joints = JointHistory(tolerance=0.02)
    joints.add(1.0, ["a"], [0.5])
    with pytest.raises(InputError):
        joints.at(1.1, ["a"])
    joints.tune(tolerance=0.2, max_gap=0.2)
    assert joints.at(1.1, ["a"]) == {"a": 0.5}
