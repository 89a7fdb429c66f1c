"""Worlds of yaml: what their elements are made of, and what is said of a wrong key."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from safe_passage.core.errors import InputError, ParameterError
from safe_passage.simulation.blocks import PANEL
from safe_passage.simulation.static_map import make_map
from safe_passage.simulation.worlds import ELEMENTS, World, load_world, make_world
from sim_hall import make_hall

WORLDS = Path(__file__).resolve().parents[3] / "config/worlds"
OUTER = len(make_hall().blocks)  # of the hall's own walls


def own(world: World) -> tuple:
    return world.blocks[: len(world.blocks) - OUTER]


def reach(world: World) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner (3,) of all that is in the hall."""
    corners = np.concatenate([block.corners() for block in own(world)])
    z = [(block.z, block.z + block.size[2]) for block in own(world)]
    return np.append(corners.min(0), np.min(z)), np.append(corners.max(0), np.max(z))


@pytest.mark.parametrize("name", ["warehouse", "workshop", "crossing"])
def test_the_worlds_that_are_shipped_can_be_read(name):
    world = load_world(WORLDS / f"{name}.yaml")
    assert world.name == name and len(world.people) >= 3
    assert world == load_world(WORLDS / f"{name}.yaml")  # goods are drawn from the seed


def test_crossing_hides_what_comes_from_the_side():
    """4 m before the crossing, in the middle of one corridor: what is 3 m into the other."""
    grid = make_map(load_world(WORLDS / "crossing.yaml"), 1.7)
    for y in (3.0, -3.0):
        sight = np.linspace((-4.0, 0.0), (0.0, y), 200)
        assert grid.at(sight, outside=True).any()
        assert not grid.at(np.linspace((0.0, 0.0), (0.0, y), 200), outside=True).any()


def test_a_wall_has_its_length_thickness_and_height():
    wall = {"points": [[0, 0], [2, 0], [2, 1.5]], "thickness": 0.2, "height": 2.5}
    low, high = reach(make_hall(walls=[wall]))
    assert low == pytest.approx([0.0, -0.1, 0.0])
    assert high == pytest.approx([2.1, 1.5, 2.5])


@pytest.mark.parametrize("turn", [-2.0, -0.5 * math.pi, -0.7, 0.7, 0.5 * math.pi, 2.0])
def test_bends_of_a_wall_are_closed(turn):
    end = [2.0 + 2.0 * math.cos(turn), 2.0 * math.sin(turn)]
    grid = make_map(make_hall(walls=[{"points": [[0, 0], [2, 0], end]}]), 1.2)
    line = np.concatenate([np.linspace((0.01, 0), (2, 0), 300), np.linspace((2, 0), end, 300)[:-3]])
    assert grid.at(line, outside=False).all()


def test_an_opening_between_walls_is_free_under_its_lintel():
    walls = [
        {"points": [[0, -3], [0, -0.6]]},
        {"points": [[0, 0.6], [0, 3]]},
        {"points": [[0, -0.6], [0, 0.6]], "z": 2.1, "height": 0.9},
    ]
    grid = make_map(make_hall(walls=walls), 1.7)
    through = np.stack([np.zeros(100), np.linspace(-0.58, 0.58, 100)], axis=1)
    assert not grid.at(through, outside=True).any()
    assert grid.at(np.array([[0.0, 0.7], [0.0, -0.7]]), outside=False).all()


def test_long_walls_are_of_panels():
    blocks = own(make_hall(walls=[{"points": [[-4, 0], [4, 0]]}]))
    assert len(blocks) == 3 and max(block.size[0] for block in blocks) <= PANEL


@pytest.mark.parametrize(
    "kind, size",
    [("benches", (1.8, 0.8)), ("cabinets", (0.95, 0.5)), ("shelves", (1.2, 0.45)),
     ("machines", (1.3, 1.0)), ("trolleys", (0.9, 0.5)), ("stools", (0.5, 0.5)),
     ("pallets", (1.2, 0.8)), ("boxes", (0.5, 0.5))],
)  # fmt: skip
def test_elements_stand_on_the_floor_around_their_place(kind, size):
    low, high = reach(make_hall(**{kind: [{"x": 1.0, "y": -0.5}]}))
    assert low[2] == pytest.approx(0.0, abs=0.021) and high[2] < 3.0
    assert (low[:2] > np.array([1.0, -0.5]) - 0.7 * np.array(size)).all()
    assert (high[:2] < np.array([1.0, -0.5]) + 0.7 * np.array(size)).all()
    turned_low, turned_high = reach(
        make_hall(**{kind: [{"x": 1.0, "y": -0.5, "yaw": math.pi / 2}]})
    )
    assert turned_high - turned_low == pytest.approx((high - low)[[1, 0, 2]])


def test_a_rack_has_pallets_on_the_floor_that_face_the_aisle():
    world = make_hall(racks=[{"x": -3.0, "y": 1.0, "bays": 2, "floor_goods": 1.0}])
    assert len(world.pallets) == 6
    assert all(yaw == pytest.approx(math.pi / 2) for _, _, yaw in world.pallets)
    low, high = reach(world)
    assert low[0] == pytest.approx(-3.03) and high[0] == pytest.approx(-3.0 + 2 * 2.8 + 0.13)


WRONG = [
    ({"raks": []}, r"raks is not known; known are: .*benches"),
    ({"size": [10.0]}, r"/size is \[10.0\], must hold 2 values"),
    ({"size": [10.0, math.nan]}, r"/size\[1\] is nan, must be finite"),
    ({"start": "here"}, r"/start is 'here', must be a list"),
    ({"seed": 1.5}, r"/seed is 1.5, must be a whole number"),
    ({"wall_height": -1}, r"/wall_height is -1.0, must lie in"),
    ({"lights": [[1, 2]]}, r"/lights\[0\] is \[1, 2\], must hold 3 values"),
    ({"racks": [{"x": 0, "y": 0}, {"x": 0, "y": 0, "bay_s": 2}]}, r"racks\[1\]/bay_s is not known"),
    ({"racks": [{"x": 0}]}, r"racks\[0\]: y is missing"),
    ({"racks": [{"x": 0, "y": 0, "levels": []}]}, r"racks\[0\]/levels"),
    ({"racks": [{"x": 0, "y": 0, "bays": True}]}, r"racks\[0\]/bays is True, must be a whole"),
    ({"pallets": [{"x": "a", "y": 0}]}, r"pallets\[0\]/x is 'a', must be a number"),
    ({"boxes": [{"x": 0, "y": 0, "size": [1, 1]}]}, r"boxes\[0\]/size .* must hold 3 values"),
    ({"boxes": [{"x": 0, "y": 0, "material": "gold"}]}, r"boxes\[0\]/material is 'gold'"),
    ({"boxes": [{"x": 0, "y": 0, "size": [1, 0, 1]}]}, r"boxes\[0\]/size is 0.0"),
    ({"boxes": [None]}, r"boxes\[0\] is None, must be a mapping"),
    ({"boxes": {"x": 0}}, r"boxes is .*, must be a list"),
    ({"walls": [{"points": [[0, 0]]}]}, r"walls\[0\]/points: two or more"),
    ({"walls": [{"points": [[0, 0], [0, 0]]}]}, r"walls\[0\]/points: two or more"),
    (
        {"walls": [{"points": [[0, 0], [0, 1.6e10]]}]},
        r"walls\[0\]/points: .* no farther than 1000 m",
    ),
    ({"walls": [{"points": [[0, 0], [0]]}]}, r"walls\[0\]/points\[1\] is \[0\], must hold 2"),
    ({"benches": [{"x": 0, "y": 0, "length": 0}]}, r"benches\[0\]/length is 0.0"),
    ({"people": [{"waypoints": [["a", 0]]}]}, r"people\[0\]/waypoints\[0\]\[0\] is 'a'"),
    ({"people": [{"speed": 9}]}, r"people\[0\]/speed is 9.0, must lie in"),
    ({"people": [{"body": 3}]}, r"people\[0\]/body is 3"),
]


@pytest.mark.parametrize("values, message", WRONG, ids=[str(values) for values, _ in WRONG])
def test_what_is_wrong_is_named(values, message):
    with pytest.raises(ParameterError, match=message):
        make_hall(**values)


@pytest.mark.parametrize("key", ["name", "size", "start"])
def test_what_is_missing_is_named(key):
    values = {"name": "hall", "size": [10, 8], "start": [0, 0, 0]}
    del values[key]
    with pytest.raises(ParameterError, match=f"world: {key} is missing"):
        make_world(values)


@pytest.mark.parametrize("content", [None, "{a: [", "- 1\n- 2\n", b"\xff\xfe\x00"])
def test_a_file_that_is_no_world_is_named(tmp_path, content):
    path = tmp_path / "some.yaml"
    if content is not None:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InputError, match=r"some\.yaml"):
        load_world(path)


def test_every_element_takes_an_empty_list_and_none():
    for kind in ELEMENTS:
        assert own(make_hall(**{kind: []})) == own(make_hall(**{kind: None})) == ()
