"""Parameters are validated, each by name, unit and range."""

import dataclasses

import pytest
from safe_passage.core.errors import ParameterError
from safe_passage.separation import SeparationParameters

ROUND = {"robot_radius": 0.3}


@pytest.mark.parametrize("field", dataclasses.fields(SeparationParameters), ids=lambda f: f.name)
def test_each_has_a_range(field):
    wrong = -1.0 if field.name != "footprint" else ((0.0, 0.0), (1.0, 0.0))
    with pytest.raises(ParameterError, match=f"^{field.name}"):
        SeparationParameters(**{**ROUND, field.name: wrong})


def test_the_robot_has_one_shape():
    for both_or_none in ({}, {**ROUND, "footprint": ((0, 0), (1, 0), (0, 1))}):
        with pytest.raises(ParameterError, match="robot_radius"):
            SeparationParameters(**both_or_none)
