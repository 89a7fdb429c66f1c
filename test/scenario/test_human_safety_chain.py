"""Persons -> safety areas -> costmap without a roscore: the robot's map keeps people 1.2 m away."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from safe_passage import _person_detection as detection
from safe_passage import _safety_area as safety
from safe_passage.costmap import (
    LocalCostmap,
    Observation,
    load_costmap_parameters,
    project_scan,
)
from safe_passage.costmap.costs import LETHAL_OBSTACLE
from safe_passage.simulation.analytic_scene import AnalyticScene

ROOT = Path(__file__).resolve().parents[2]
LASER_X, LASER_Z = 0.2, 0.12  # [m]
RANGE_MIN, MAX_RANGE = 0.06, 20.0  # [m]
ANGLES = np.linspace(-0.75 * np.pi, 0.75 * np.pi, 1081)
STEP = ANGLES[1] - ANGLES[0]
RADIUS = 1.2


class Chain:
    """What the three nodes do, in a row, for a robot standing at the odom origin."""

    def __init__(self):
        self.scene = AnalyticScene()
        camera = self.scene.camera
        self.intrinsics = detection.Intrinsics(camera.focal, camera.focal, 319.5, 239.5)
        self.seed = detection.GroundPlane(camera.rotation()[2], camera.z)
        self.detector = detection.PersonDetector(detection.DetectorParameters())
        self.merger = safety.Pipeline()
        parameters = yaml.safe_load((ROOT / "config/local_costmap.yaml").read_text())
        self.costmap = LocalCostmap(load_costmap_parameters(parameters).parameters)
        self.key = self._source_key(parameters)

    @staticmethod
    def _source_key(parameters):
        layers = [plugin["name"] for plugin in parameters["plugins"]]
        layer = next(name for name in layers if "observation_sources" in parameters[name])
        return layer, parameters[layer]["observation_sources"].split()[0]

    def see(self, time):
        """Detect at `time` and remember; the heads' places (3,) [m], odom frame."""
        depth, bgr = self.scene.render(time)
        frame = detection.from_depth(depth, bgr, self.intrinsics)
        found = [d for d in self.detector.detect(frame, self.seed).detections if d.accepted]
        heads = [d.candidate.head for d in found]
        self.merger.remember([safety.Person(time, [h[0], h[1], 0.0]) for h in heads])
        return heads

    def merged_scan(self, time):
        """The real and the merged ranges at `time`."""
        ranges = self.scene.scan(time, ANGLES, LASER_Z, LASER_X, MAX_RANGE)
        scan = safety.Scan(ranges, ANGLES[0], ANGLES[-1], STEP, RANGE_MIN, MAX_RANGE)
        T_laser_fixed = np.eye(4)
        T_laser_fixed[0, 3], T_laser_fixed[2, 3] = -LASER_X, -LASER_Z
        merged = self.merger.merge(scan, time, safety.LaserPose(T_laser_fixed)).scan.ranges
        return ranges.astype(np.float32), np.asarray(merged)

    def lethal_cells(self, time):
        """Centres (N, 2) [m] of the costmap's lethal cells after the scan of `time`."""
        _, merged = self.merged_scan(time)
        points = project_scan(merged, ANGLES[0], STEP, RANGE_MIN, MAX_RANGE, inf_is_valid=True)
        place = (LASER_X, 0.0, LASER_Z)
        seen = Observation(time, place, points + np.array(place, np.float32))
        update = self.costmap.update((0.0, 0.0, 0.0), {self.key: [seen]}, time)
        cells = np.argwhere(update.costs == LETHAL_OBSTACLE)[:, ::-1]
        return np.array(update.origin) + (cells + 0.5) * update.resolution


@pytest.fixture
def chain():
    return Chain()


def test_no_beam_reaches_into_a_persons_area_and_none_gets_longer(chain):
    heads = chain.see(1.6)
    assert len(heads) >= 2
    real, merged = chain.merged_scan(1.6)
    assert (merged <= real).all()
    ends = np.stack([merged * np.cos(ANGLES) + LASER_X, merged * np.sin(ANGLES)], axis=1)
    for head in heads:
        assert np.hypot(*(ends - head[:2]).T).min() >= RADIUS - 0.01


def test_every_person_in_sight_has_an_area(chain):
    """1.2 m around where each person truly stands, but for the detector's error of position."""
    chain.see(1.6)
    _, merged = chain.merged_scan(1.6)
    ends = np.stack([merged * np.cos(ANGLES) + LASER_X, merged * np.sin(ANGLES)], axis=1)
    for person in chain.scene.persons(1.6):
        assert np.hypot(*(ends - [person.x, person.y]).T).min() >= RADIUS - 0.2


def test_beams_beside_the_areas_are_untouched(chain):
    chain.see(1.6)
    real, merged = chain.merged_scan(1.6)
    behind = np.abs(ANGLES) > 1.7
    assert np.array_equal(merged[behind], real[behind])


def test_costmap_shows_the_area_in_one_update_and_loses_it_in_one(chain):
    head = min(chain.see(1.6), key=lambda h: np.hypot(h[0], h[1]))
    front = head[:2] * (1.0 - RADIUS / np.hypot(*head[:2]))

    def nearest_lethal(time):
        return np.hypot(*(chain.lethal_cells(time) - front).T).min()

    assert nearest_lethal(1.6) < 0.15
    chain.merger.clear()
    assert nearest_lethal(1.65) > 0.3


def test_pallet_stays_approachable_while_a_person_stands_by(chain):
    """The pallet itself is no farther away in the map than it is: only people get 1.2 m."""
    chain.merger.clear()
    cells = chain.lethal_cells(1.6)
    pallet = cells[(cells[:, 0] > 1.5) & (cells[:, 0] < 1.7) & (cells[:, 1] > 1.0)]
    assert pallet.size and pallet[:, 0].min() > 1.5
