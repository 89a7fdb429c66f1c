"""Changes of parameters in use: all of them or none."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import strategies as st
from safe_passage.core.errors import ParameterError
from safe_passage.core.parameters import check_range
from safe_passage.core.tuning import changed, description_at, value_at


@dataclass(frozen=True)
class Layer:
    name: str
    radius: float = 0.5  # [m] that it reaches

    def __post_init__(self) -> None:
        check_range(f"{self.name}/radius", self.radius, 0.0, 2.0, "m")


@dataclass(frozen=True)
class Labels:
    gate: float = 0.6

    def __post_init__(self) -> None:
        check_range("gate", self.gate, 0.1, 1.0, "m")


@dataclass(frozen=True)
class Whole:
    near: float = 1.0  # [m] from here
    far: float = 2.0
    cycles: int = 3
    flag: bool = False
    frame: str = "odom"
    labels: Labels = field(default_factory=Labels)
    layers: tuple[Layer, ...] = (Layer("first"), Layer("second"))

    def __post_init__(self) -> None:
        check_range("near", self.near, 0.0, 10.0, "m")
        check_range("far", self.far, self.near, 10.0, "m")
        check_range("cycles", self.cycles, 1, 10, "cycles")


def test_changes_come_together_and_leave_the_old_set_alone():
    old = Whole()
    new = changed(old, {"near": 3, "far": 4.0, "cycles": 5, "flag": True, "frame": "map"})
    assert new == Whole(3.0, 4.0, 5, True, "map")
    assert old == Whole()
    assert isinstance(new.near, float)


def test_parts_are_changed_by_path():
    new = changed(Whole(), {"labels/gate": 0.7, "second/radius": 1.5, "first/radius": 0.1})
    assert new == Whole(labels=Labels(0.7), layers=(Layer("first", 0.1), Layer("second", 1.5)))
    assert value_at(new, "second/radius") == 1.5
    assert value_at(new, "labels/gate") == 0.7


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"near": 2.5}, "far is 2.0, must lie in"),  # each is in range, both together are not
        ({"near": 11.0, "far": 9.0}, "near"),
        ({"near": float("nan")}, "near is nan"),
        ({"near": float("inf")}, "near is inf"),
        ({"near": True}, "near is True"),
        ({"near": "far"}, "near is 'far'"),
        ({"cycles": 2.0}, "cycles is 2.0, must be int"),
        ({"cycles": True}, "cycles"),
        ({"flag": 1}, "flag"),
        ({"layers": ()}, "layers"),
        ({"labels/gate": 2.0}, "labels/gate is 2.0"),
        ({"second/radius": -1.0}, "second/radius is -1.0"),
        ({"third/radius": 1.0}, "third is not known"),
        ({"nearr": 1.0}, "nearr is not known"),
        ({"second/radiu": 1.0}, "second/radiu is not known"),
        ({"near/far": 1.0}, "near is not known"),
    ],
)
def test_one_wrong_change_refuses_all(changes, message):
    old = Whole()
    with pytest.raises(ParameterError, match=message):
        changed(old, {"cycles": 7, **changes})
    assert old == Whole()


@given(st.floats(allow_nan=False), st.floats(allow_nan=False))
def test_a_new_set_is_as_told_or_there_is_none(near, far):
    try:
        new = changed(Whole(), {"near": near, "far": far})
    except ParameterError:
        assert not 0.0 <= near <= far <= 10.0
    else:
        assert (new.near, new.far) == (near, far) and 0.0 <= near <= far <= 10.0


def test_a_description_tells_the_bounds_of_now():
    far = description_at(Whole(near=1.5), "far")
    assert (far.name, far.least, far.most) == ("far", 1.5, 10.0)
    assert description_at(Whole(), "second/radius").text == "that it reaches"
    assert description_at(Whole(), "labels/gate").name == "labels/gate"
    for path in ("nothing", "first/nothing", "nothing/radius"):
        with pytest.raises(KeyError):
            description_at(Whole(), path)
