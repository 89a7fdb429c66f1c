from __future__ import annotations

import copy

import pytest
import yaml
from safe_passage.core.errors import ParameterError
from safe_passage.costmap import InflationLayerParameters, load_costmap_parameters

YAML = """
global_frame: odom
rolling_window: true
width: 8
height: 8
resolution: 0.05
footprint: [[0.36, 0.31], [0.36, -0.31], [-0.36, -0.31], [-0.36, 0.31]]
plugins:
  - {name: obstacles, type: "costmap_2d::ObstacleLayer"}
  - {name: inflation, type: "costmap_2d::InflationLayer"}
obstacles:
  observation_sources: front cloud
  obstacle_range: 4.0
  front: {data_type: LaserScan, topic: scan, clearing: true, inf_is_valid: true,
          raytrace_range: 6.0}
  cloud: {data_type: PointCloud2, obstacle_range: 2.0}
inflation: {inflation_radius: 0.05}
"""


@pytest.fixture
def mapping():
    return copy.deepcopy(yaml.safe_load(YAML))


def load(mapping):
    return load_costmap_parameters(mapping).parameters


def warnings(mapping):
    return load_costmap_parameters(mapping).warnings


def test_reads_what_is_given(mapping):
    parameters = load(mapping)
    assert not warnings(mapping)
    assert parameters.shape == (160, 160)
    assert parameters.global_frame == "odom"
    obstacles, inflation = parameters.layers
    assert [source.topic for source in obstacles.sources] == ["scan", "cloud"]
    assert inflation == InflationLayerParameters("inflation", inflation_radius=0.05)


def test_defaults_are_those_of_costmap_2d(mapping):
    parameters = load({key: mapping[key] for key in ("plugins", "obstacles")})
    assert (parameters.width, parameters.update_frequency, parameters.rolling_window) == (10, 5, 0)
    assert parameters.footprint.robot_radius == 0.46
    assert parameters.footprint.footprint_padding == 0.01
    assert parameters.layers[1].cost_scaling_factor == 10.0
    cloud = parameters.layers[0].sources[1]
    assert (cloud.clearing, cloud.marking, cloud.raytrace_range) == (False, True, 3.0)


def test_a_source_takes_the_ranges_of_its_layer(mapping):
    front, cloud = load(mapping).layers[0].sources
    assert (front.obstacle_range, cloud.obstacle_range) == (4.0, 2.0)


def test_the_costmaps_own_values_win_over_the_layers(mapping):
    mapping["inflation_radius"] = 0.7
    assert load(mapping).layers[1].inflation_radius == 0.7
    assert "inflation/inflation_radius = 0.05: overridden" in warnings(mapping)[0]


def test_unknown_tracking_comes_from_the_costmap_unless_the_layer_says_so(mapping):
    mapping["track_unknown_space"] = True
    assert load(mapping).layers[0].track_unknown_space


def test_unknown_plugin_is_named(mapping):
    mapping["plugins"].insert(0, {"name": "social", "type": "social_layers::ProxemicLayer"})
    mapping["social"] = {"cutoff": 1.0}
    assert warnings(mapping) == (
        "plugins: social of type social_layers::ProxemicLayer is not known and has no effect",
    )


@pytest.mark.parametrize(
    "place, name",
    [((), "widht"), (("obstacles",), "obstacles/widht"),
     (("obstacles", "front"), "obstacles/front/widht"), (("inflation",), "inflation/widht")],
)  # fmt: skip
def test_unknown_key_is_named(mapping, place, name):
    inner = mapping
    for step in place:
        inner = inner[step]
    inner["widht"] = 1
    assert warnings(mapping) == (f"{name}: not known and without effect",)


@pytest.mark.parametrize(
    "place, key, value, words",
    [
        ((), "resolution", 0.0, ("resolution", "0.001", "m")),
        ((), "width", "wide", ("width", "m")),
        ((), "update_frequency", 1000.0, ("update_frequency", "100", "Hz")),
        ((), "rolling_window", 1, ("rolling_window", "true or false")),
        ((), "footprint", [[1, 2], [3, 4]], ("footprint", "3 points")),
        ((), "footprint", "[[1, 2], [3, oops]]", ("footprint", "[x, y] in m")),
        ((), "plugins", "obstacles", ("plugins", "name", "type")),
        (("inflation",), "cost_scaling_factor", -1.0, ("inflation/cost_scaling_factor", "1/m")),
        (("inflation",), "inflation_radius", float("nan"), ("inflation/inflation_radius", "m")),
        (("obstacles",), "combination_method", 2, ("obstacles/combination_method", "0, 1, 99")),
        (("obstacles",), "observation_sources", ["front"], ("observation_sources", "spaces")),
        (("obstacles",), "observation_sources", "front front", ("names a source twice",)),
        (("obstacles",), "front", 3, ("obstacles/front", "namespace")),
        (("obstacles", "front"), "data_type", "Image", ("front/data_type", "LaserScan")),
        (("obstacles", "front"), "raytrace_range", -2.0, ("front/raytrace_range", "m")),
        (("obstacles", "front"), "min_obstacle_height", 3.0, ("front/min_obstacle_height", "m")),
    ],
)
def test_errors_name_parameter_unit_and_range(mapping, place, key, value, words):
    inner = mapping
    for step in place:
        inner = inner[step]
    inner[key] = value
    with pytest.raises(ParameterError) as error:
        load(mapping)
    for word in words:
        assert word in str(error.value)


def test_voxel_layer_is_used_flat_and_says_so(mapping):
    mapping["plugins"][0]["type"] = "costmap_2d::VoxelLayer"
    mapping["obstacles"]["z_voxels"] = 16
    assert len(load(mapping).layers[0].sources) == 2
    assert "flat" in warnings(mapping)[0] and "every height" in warnings(mapping)[0]
    assert warnings(mapping)[1] == "obstacles/z_voxels: not known and without effect"


def test_a_costmap_that_never_marks_is_refused(mapping):
    mapping["plugins"] = [{"name": "static", "type": "costmap_2d::StaticLayer"}]
    with pytest.raises(ParameterError, match="StaticLayer"):
        load(mapping)


def test_footprint_as_text_of_the_parameter_server(mapping):
    mapping["footprint"] = "[[0.5, 0.0], [0.0, 0.5], [-0.5, 0.0]]"
    assert load(mapping).footprint.footprint[0] == (0.5, 0.0)
    mapping["footprint"] = "[]"
    assert load(mapping).footprint.footprint == ()


def test_parameters_of_the_time_before_hydro():
    flat = {
        "static_map": True, "map_type": "voxel", "observation_sources": "scan",
        "scan": {"data_type": "LaserScan", "clearing": True, "inf_is_valid": True},
        "obstacle_range": 2.0, "inflation_radius": 0.3,
    }  # fmt: skip
    obstacles, inflation = load(flat).layers
    assert obstacles.sources[0].obstacle_range == 2.0
    assert inflation.inflation_radius == 0.3
    assert [text.split(":")[0] for text in warnings(flat)] == ["plugins"] * 3


def test_settings_that_leave_ghosts_are_named(mapping):
    mapping["obstacles"]["front"].update(inf_is_valid=False, raytrace_range=3.0)
    assert [text.split(" ")[0] for text in warnings(mapping)] == [
        "obstacles/front/raytrace_range",
        "obstacles/front/inf_is_valid:",
    ]


def test_the_mapping_is_left_as_it_was(mapping):
    before = copy.deepcopy(mapping)
    load(mapping)
    assert mapping == before
