"""Other parameters while a costmap is in use: they count, and what it remembers stays."""

from __future__ import annotations

import numpy as np
import pytest
from safe_passage.core.errors import ParameterError
from safe_passage.core.tuning import changed
from safe_passage.costmap import CostmapParameters, LocalCostmap, Observation
from safe_passage.costmap.parameters import (
    InflationLayerParameters,
    ObstacleLayerParameters,
    SourceParameters,
)


class TestCostmap:
    scan = SourceParameters("scan", data_type="LaserScan", marking=True, clearing=True)
    parameters = CostmapParameters(
        layers=(
            ObstacleLayerParameters(sources=(scan,)),
            InflationLayerParameters(inflation_radius=0.3),
        ),
        rolling_window=True,
        width=6.0,
        height=6.0,
    )
    here = (0.0, 0.0, 0.0)

    def seen(self, x):
        return {
            ("obstacle_layer", "scan"): [Observation(0.0, (0, 0, 0.2), np.array([[x, 0, 0.2]]))]
        }

    def test_marks_survive_and_are_inflated_anew(self):
        costmap = LocalCostmap(self.parameters)
        before = costmap.update(self.here, self.seen(1.0), 0.0).costs.copy()
        assert (before == 254).sum() == 1
        costmap.tune(changed(self.parameters, {"inflation_layer/inflation_radius": 0.8}))
        after = costmap.update(self.here, {}, 0.2).costs
        assert (after == 254).sum() == 1
        fresh = LocalCostmap(changed(self.parameters, {"inflation_layer/inflation_radius": 0.8}))
        np.testing.assert_array_equal(after, fresh.update(self.here, self.seen(1.0), 0.0).costs)

    def test_the_whole_window_is_computed_anew(self):
        parameters = changed(self.parameters, {"obstacle_layer/scan/clearing": False})
        wider = changed(parameters, {"inflation_layer/inflation_radius": 0.8})
        tuned, fresh = LocalCostmap(parameters), LocalCostmap(wider)
        for x in (-2.4, 1.5):  # the first is a mark that nobody sees any more
            for costmap in (tuned, fresh):
                costmap.update(self.here, self.seen(x), 0.0)
        for costmap in (tuned, fresh):
            costmap.update(self.here, {}, 0.1)
        tuned.tune(wider)
        costs = [costmap.update(self.here, {}, 0.2).costs for costmap in (tuned, fresh)]
        np.testing.assert_array_equal(*costs)

    def test_a_new_range_counts_for_what_comes_next(self):
        costmap = LocalCostmap(self.parameters)
        costmap.tune(changed(self.parameters, {"obstacle_layer/scan/obstacle_range": 0.5}))
        assert (costmap.update(self.here, self.seen(1.0), 0.0).costs == 254).sum() == 0

    @pytest.mark.parametrize("other", [{"width": 5.0}, {"obstacle_layer/enabled": False}])
    def test_another_setup_is_refused_and_the_old_one_stays(self, other):
        costmap = LocalCostmap(self.parameters)
        with pytest.raises(ParameterError):
            costmap.tune(changed(self.parameters, other))
        assert costmap.parameters is self.parameters
