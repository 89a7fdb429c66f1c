"""Parameters refuse what they do not know, by name."""

from dataclasses import dataclass

import pytest
from safe_passage.core.errors import ParameterError
from safe_passage.core.parameters import check_range, from_mapping


@dataclass(frozen=True)
class Example:
    speed: float = 1.0  # [m/s]

    def __post_init__(self) -> None:
        check_range("speed", self.speed, 0.0, 2.0, "m/s")


def test_defaults_and_values():
    assert from_mapping(Example, {}).speed == 1.0
    assert from_mapping(Example, {"speed": 2}).speed == 2


def test_unknown_key_is_named():
    with pytest.raises(ParameterError, match="/robot/node/sped is not known; known are: speed"):
        from_mapping(Example, {"sped": 1.0}, "/robot/node")


@pytest.mark.parametrize("value", [-0.1, 2.1, float("nan"), "fast", None, True])
def test_wrong_value_is_named_with_range_and_unit(value):
    with pytest.raises(ParameterError, match=r"/node/speed is .* must lie in \[0.0, 2.0\] m/s"):
        from_mapping(Example, {"speed": value}, "/node")
