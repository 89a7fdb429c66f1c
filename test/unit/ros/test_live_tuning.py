"""Live tuning without a ROS master: the node's side, and what the library's server is told."""

from __future__ import annotations

from dataclasses import dataclass

import pytest
from safe_passage.core.parameters import check_choice, check_range
from safe_passage.costmap.parameters import CostmapParameters, SourceParameters
from safe_passage.costmap.parameters import ObstacleLayerParameters as Layer
from safe_passage.monitoring.parameters import SourceParameters as TrackerSource
from safe_passage.ros import (
    costmap_node,
    depth_self_filter_node,
    live_tuning,
    separation_parameters,
    tracker_parameters,
)
from safe_passage.ros.live_tuning import LiveTuning


@dataclass(frozen=True)
class Example:
    near: float = 1.0  # [m] from here
    far: float = 2.0  # [m] from here
    method: int = 1  # 1 or 2
    frame: str = "odom"

    def __post_init__(self) -> None:
        check_range("near", self.near, 0.0, 10.0, "m")
        check_range("far", self.far, self.near, 10.0, "m")
        check_choice("method", self.method, (1, 2))


class FakeServer:
    """Asks as dynamic_reconfigure's does."""

    def __init__(self, kind, values, callback, namespace):
        self.kind, self.callback = kind, callback
        self.config = callback({**values, "groups": {}}, ~0)

    def request(self, **changes):
        self.config = self.callback({**self.config, **changes}, 1)
        return {name: value for name, value in self.config.items() if name != "groups"}


@pytest.fixture
def tuning(monkeypatch):
    monkeypatch.setattr(live_tuning, "_Server", FakeServer)
    return LiveTuning(Example(near=1), ("near", "far", "method"))  # a whole number, as of yaml


def test_nothing_to_take_before_a_change(tuning):
    assert tuning.take() is None


def test_a_change_is_taken_once_and_told_back(tuning):
    assert tuning._server.request(near=1.5) == {"near": 1.5, "far": 2.0, "method": 1}
    assert tuning.take() == Example(1.5)
    assert tuning.take() is None


def test_two_changes_before_a_cycle_are_one(tuning):
    tuning._server.request(near=1.5)
    tuning._server.request(far=4.0)
    assert tuning.take() == Example(1.5, 4.0)


@pytest.mark.parametrize(
    "changes",
    [
        {"near": 11.0},
        {"near": float("nan")},
        {"near": 2.5},  # beyond far
        {"near": 1.5, "far": 1.2},
        {"near": 0.5, "method": 3},
        {"near": "1.5"},
        {"near": 0.5, "frame": "map"},  # a parameter, but not to be tuned
        {"near": 0.5, "unknown": 1.0},
    ],
)
def test_a_refused_change_leaves_all_as_it_is_and_tells_so(tuning, changes):
    tuning._server.request(far=3.0)
    before = tuning.take()
    changes = {"far": 2.0, **changes}
    assert tuning._server.request(**changes) == {"near": 1.0, "far": 3.0, "method": 1}
    assert tuning.take() is None
    tuning._server.request(near=0.5)
    assert tuning.take() == Example(0.5, before.far)  # and what was refused does not come later


def test_the_same_values_are_no_change(tuning):
    tuning._server.request(near=1.0, far=2.0)
    assert tuning.take() is None


def test_clients_are_told_ranges_units_and_choices(tuning):
    kind = tuning._server.kind
    assert (kind.min["far"], kind.max["far"], kind.defaults["far"]) == (1.0, 10.0, 2.0)
    assert all(isinstance(kind.min[name], float) for name in ("near", "far"))
    near, _, method = kind.config_description["parameters"]
    assert (near["type"], near["description"]) == ("double", "from here [m]")
    assert [const["value"] for const in eval(method["edit_method"])["enum"]] == [1, 2]


SCAN = SourceParameters("scan", data_type="LaserScan")


@pytest.mark.parametrize(
    "parameters, names",
    [
        (
            separation_parameters.SeparationNodeParameters(robot_radius=0.3),
            separation_parameters.LIVE,
        ),
        (
            tracker_parameters.TrackerNodeParameters(sources=(TrackerSource("scan"),)),
            tracker_parameters.LIVE,
        ),
        (depth_self_filter_node.SelfFilterNodeParameters(), depth_self_filter_node.LIVE),
        (
            CostmapParameters(layers=(Layer(sources=(SCAN,)),)),
            costmap_node.live_names(CostmapParameters(layers=(Layer(sources=(SCAN,)),))),
        ),
    ],
)
def test_every_live_parameter_of_the_nodes_can_be_served(monkeypatch, parameters, names):
    monkeypatch.setattr(live_tuning, "_Server", FakeServer)
    assert len(set(names)) == len(names)
    tuning = LiveTuning(parameters, names)
    for name in names:
        assert tuning._server.kind.min[name] <= tuning._server.kind.max[name]
