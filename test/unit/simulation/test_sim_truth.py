"""What is said to be in a picture: boxes around persons, and how much of them is to be seen."""

from __future__ import annotations

import math

import numpy as np
import pytest
from safe_passage.core.geometry import matrix
from safe_passage.simulation.people_assets import load_person
from safe_passage.simulation.robots import CameraModel
from safe_passage.simulation.scene import Scene
from safe_passage.simulation.truth import PersonTruth, persons_in_view
from safe_passage.simulation.walkers import PersonState
from sim_hall import make_cart, make_hall

CAMERA = CameraModel(z=1.2, width=320, height=240, focal=200.0)
BODIES = (load_person("tall_man"), load_person("vest_woman"))


def look(*states: PersonState | None, boxes: tuple = ()) -> tuple[list[PersonTruth], np.ndarray]:
    """From (-3, 0) along +x: who is there, and the picture's difference to one without people."""
    padded = [*states, None, None][:2]
    scene = Scene(make_hall(boxes=boxes), make_cart(cameras=[vars(CAMERA)]), BODIES)
    scene.place_robot((-3.0, 0.0, 0.0))
    scene.place_people([None, None])
    scene.settle()
    empty, _ = scene.render(CAMERA)
    scene.place_people(padded)
    scene.settle()
    bgr, exact = scene.render(CAMERA)
    scene.close()
    T = matrix((-3.0, 0.0, 0.0)) @ CAMERA.pose_in_base()
    return persons_in_view(exact, T, CAMERA, BODIES, padded), (bgr != empty).any(axis=-1)


def at(x: float, y: float, walking: bool = False) -> PersonState:
    return PersonState(x, y, 0.5, (1.0, 0.0) if walking else (0.0, 0.0), 0.4)


@pytest.mark.parametrize("walking", [False, True])
def test_a_person_in_the_open_is_wholly_visible_in_its_box(walking):
    (truth,), drawn = look(at(1.0, 0.3, walking))
    assert truth.visible > 0.97
    assert (truth.id, truth.body, truth.position) == (0, "tall_man", (1.0, 0.3))
    assert truth.distance == pytest.approx(math.hypot(4.0, 0.3))
    rows, columns = np.nonzero(drawn)
    x, y, width, height = truth.box
    box = [x, y, x + width, y + height]
    by_picture = [columns.min(), rows.min(), columns.max(), rows.max()]
    assert box == pytest.approx(by_picture, abs=1.6)


def test_a_person_behind_a_block_is_half_hidden():
    screen = {"x": 0.0, "y": 0.0, "size": [0.1, 3.0, 0.95]}
    (truth,), drawn = look(at(1.0, 0.0), boxes=(screen,))
    (whole,), all_of_it = look(at(1.0, 0.0))
    assert truth.visible == pytest.approx(drawn.sum() / all_of_it.sum(), abs=0.04)
    assert 0.3 < truth.visible < 0.7
    assert truth.box == pytest.approx(whole.box)  # the box is that of the whole person


def test_a_person_behind_a_wall_is_not_visible():
    (truth,), drawn = look(at(1.0, 0.0), boxes=({"x": 0, "y": 0, "size": [0.1, 3.0, 2.5]},))
    assert truth.visible == 0.0 and not drawn.any()


def test_a_person_hides_the_one_behind():
    near, far = look(at(0.0, 0.0), at(2.5, 0.0))[0]
    assert near.visible > 0.97
    assert far.visible < 0.5


def test_persons_outside_the_picture_are_not_told():
    beside, behind, absent = (look(state)[0] for state in (at(0.0, 3.5), at(-4.0, 0.0), None))
    assert beside == behind == absent == []


def test_a_person_on_the_border_is_visible_in_part():
    edge = math.tan(math.atan2(160, 200.0)) * 4.0
    (truth,), drawn = look(at(1.0, edge))
    assert 0.2 < truth.visible < 0.8
    assert truth.box[0] < 0.0 < truth.box[0] + truth.box[2]
    assert drawn[:, :1].any()
