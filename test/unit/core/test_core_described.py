"""A dataclass of parameters describes itself by what it checks and what its comments say."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field

import pytest
from safe_passage.core.described import REQUIRED, described, described_as
from safe_passage.core.errors import ParameterError
from safe_passage.core.parameters import (
    check_choice,
    check_flag,
    check_range,
    check_text,
    recorded_checks,
)
from safe_passage.costmap.parameters import CostmapParameters, InflationLayerParameters
from safe_passage.monitoring.parameters import SourceParameters, TrackerParameters
from safe_passage.self_filter import SelfFilterParameters
from safe_passage.separation import SeparationParameters


@dataclass(frozen=True)
class Wheel:
    radius: float = 0.1  # [m] of the tyre
    kind: str = "air"  # air | solid

    def __post_init__(self) -> None:
        check_range("radius", self.radius, 0.01, 1.0, "m")
        check_choice("kind", self.kind, ("air", "solid"))


@dataclass(frozen=True)
class Chair:
    name: str
    legs: int = 4
    height: float = 0.45  # m, of the seat
    depth: float = 0.4  # [m] of the seat
    back: bool = True  # to lean on
    front: Wheel = field(default_factory=Wheel)
    others: tuple[Wheel, ...] = ()  # all but the first

    def __post_init__(self) -> None:
        check_text("name", self.name)
        check_flag("back", self.back)
        check_range(f"{self.name}/legs", self.legs, 0, 8, "legs")
        for metres in ("height", "depth"):
            check_range(metres, getattr(self, metres), 0.1, 2 * self.legs, "m")


def by_name(descriptions):
    return {description.name: description for description in descriptions}


def test_range_unit_default_and_meaning_of_a_field():
    found = by_name(described(Chair))
    height = found["height"]
    assert (height.least, height.most, height.unit) == (0.1, 8, "m")
    assert (height.default, height.type, height.text) == (0.45, "float", "of the seat")
    assert found["depth"].text == "of the seat"  # on a line of its own
    assert (found["legs"].type, found["legs"].unit, found["legs"].text) == ("int", "legs", "")
    assert (found["back"].type, found["back"].least) == ("bool", None)


def test_a_field_without_default_says_so():
    assert by_name(described(Chair))["name"].default is REQUIRED


def test_parts_and_lists_of_parts_are_described_by_their_own_fields():
    found = by_name(described(Chair))
    assert list(found) == [
        "name", "legs", "height", "depth", "back",
        "front/radius", "front/kind", "others[]/radius", "others[]/kind",
    ]  # fmt: skip
    assert found["front/kind"].choices == ("air", "solid")
    assert found["others[]/radius"].most == 1.0


def test_a_prefix_stands_before_all_names():
    assert all(d.name.startswith("hall/") for d in described(Chair, prefix="hall/"))


def test_bounds_that_depend_on_others_are_those_of_the_values_given():
    assert by_name(described_as(Chair("one", legs=2)))["height"].most == 4
    assert by_name(described(Chair, legs=2))["height"].most == 4
    assert by_name(described_as(Chair("one", legs=2)))["legs"].default == 4  # stays the code's


def test_what_does_not_validate_is_refused():
    with pytest.raises(ParameterError, match="legs"):
        described(Chair, legs=9)


def test_other_threads_checks_are_not_recorded():
    with recorded_checks() as checks:
        thread = threading.Thread(target=Wheel)
        thread.start()
        thread.join()
        assert checks == []
        Wheel(radius=0.2)
    Wheel(radius=0.3)
    assert [check.name for check in checks] == ["radius", "kind"]


@pytest.mark.parametrize(
    "cls, given",
    [
        (SeparationParameters, {"robot_radius": 0.3}),
        (TrackerParameters, {"sources": (SourceParameters("a"),)}),
        (SelfFilterParameters, {}),
        (CostmapParameters, {}),
        (InflationLayerParameters, {}),
    ],
)
def test_every_number_of_the_package_has_a_range_that_its_default_is_in(cls, given):
    for one in described(cls, **given):
        if one.type in ("float", "int") and not one.choices:
            assert one.least is not None and one.most is not None, one.name
            assert one.least <= one.default <= one.most, one.name


def test_meanings_do_not_begin_with_their_unit():
    for one in described(SeparationParameters, robot_radius=0.3) + described(CostmapParameters):
        assert not one.text.startswith(("[", f"{one.unit} " if one.unit else "[")), one
