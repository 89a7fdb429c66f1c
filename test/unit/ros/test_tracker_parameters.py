"""The obstacle tracker's yaml."""

from pathlib import Path

import pytest
import yaml
from safe_passage.core.errors import ParameterError
from safe_passage.ros.tracker_parameters import make_tracker_parameters
from safe_passage.simulation.robots import load_robot

ROOT = Path(__file__).parents[3]
LASER = {"name": "laser"}


@pytest.mark.parametrize(
    ("config", "robot"),
    [("obstacle_tracker", "omnirob"), ("obstacle_tracker_single_lidar", "summit_xl")],
)
def test_shipped_files_fit_their_robots(config, robot):
    values = yaml.safe_load((ROOT / f"config/{config}.yaml").read_text())
    parameters = make_tracker_parameters(values, "/tracker")
    model = load_robot(ROOT / f"config/robots/{robot}.yaml")
    assert set(parameters.footprint) == set(model.footprint)
    lidars = [source.name for source in parameters.sources if not source.three_dimensional]
    assert lidars == [lidar.name for lidar in model.lidars]
    cameras = [source.name for source in parameters.sources if source.three_dimensional]
    assert cameras in ([], [camera.name for camera in model.cameras])


def test_a_3d_lidars_file_loads():
    values = yaml.safe_load((ROOT / "config/obstacle_tracker_lidar3d.yaml").read_text())
    parameters = make_tracker_parameters(values, "/tracker")
    (source,) = parameters.sources
    assert source.three_dimensional
    assert parameters.alignment_reach >= parameters.resolution


@pytest.mark.parametrize(
    ("values", "complaint"),
    [
        ({}, "sources is empty"),
        ({"sources": [LASER], "speed": 1.0}, "/tracker/speed is not known"),
        ({"sources": [{**LASER, "speed": 1.0}]}, r"/tracker/sources\[0\]/speed is not known"),
        ({"sources": [LASER, LASER]}, "different names"),
        ({"sources": [{**LASER, "aggregate": 1.5}]}, "aggregate is 1.5, must be a whole number"),
        ({"sources": [LASER], "odom_frame": ""}, "odom_frame is ''"),
        ({"sources": [LASER], "rate": "fast"}, "rate is 'fast', must be a number"),
        ({"sources": [LASER], "footprint": [[0.0, 1.0]]}, "3 points"),
        ({"sources": [LASER], "path_duration": -1.0}, "path_duration is -1.0"),
        ({"sources": [LASER], "person_sources": [{}, {}]}, "different topics"),
        ({"sources": [LASER], "person_sources": [{"odd": 1}]}, r"person_sources\[0\]/odd is not"),
        ({"sources": [LASER], "person_labels": {"denial": -1.0}}, "person_labels/denial is -1.0"),
    ],
)
def test_what_is_wrong_is_named(values, complaint):
    with pytest.raises(ParameterError, match=complaint):
        make_tracker_parameters(values, "/tracker")
