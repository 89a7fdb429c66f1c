"""Who there is: bodies, clothes and colours of the people of the warehouse."""

from __future__ import annotations

from dataclasses import dataclass, field

Colour = tuple[int, int, int]  # RGB
REFLECTIVE: Colour = (205, 208, 205)


@dataclass(frozen=True)
class Person:
    """One person's looks."""

    name: str
    height: float  # [m] from the soles of the shoes to the crown, hair or helmet included
    phenotype: dict[str, float]  # see BodyMaker.make
    skin: Colour
    hair: Colour
    jacket: Colour
    trousers: Colour
    shoes: Colour
    vest: Colour | None = None  # high-visibility vest over the jacket
    helmet: Colour = (240, 240, 235)
    extras: tuple[str, ...] = ()  # bob, ponytail, helmet, cap
    short_sleeves: bool = False
    reflective_jacket: bool = False  # bands on the jacket and the trousers themselves
    beard: bool = False
    open_front: Colour | None = None  # of the shirt that an open jacket shows
    hem: float = -0.03  # [m] lower end of the jacket over the hip joint
    bald: float = 0.0  # how far the hairline is drawn back
    hair_low: float = -0.75  # lower end of the hair at the neck, in heights eye to crown
    hair_thickness: float = 0.012  # [m]
    looseness: float = 1.0  # of the clothes
    step: float = 0.72  # stride (two steps) in body heights
    seed: int = field(default=0)  # of cloth folds


def _body(gender: float, age: float, muscle: float, weight: float) -> dict[str, float]:
    return {
        "gender": gender, "age": age, "muscle": muscle, "weight": weight,
        "height": 0.65 - 0.25 * gender, "proportions": 0.6,
    }  # fmt: skip


PEOPLE = (
    Person(
        "vest_man", 1.81, _body(0.0, 0.74, 0.60, 0.52), (205, 160, 132), (58, 40, 28),
        jacket=(38, 48, 84), trousers=(72, 74, 80), shoes=(40, 34, 30), vest=(214, 232, 40), seed=1,
    ),
    Person(
        "vest_woman", 1.67, _body(1.0, 0.69, 0.50, 0.48), (226, 184, 158), (96, 60, 34),
        jacket=(120, 124, 130), trousers=(54, 72, 112), shoes=(60, 60, 64), vest=(250, 110, 30),
        extras=("ponytail",), seed=2,
    ),
    Person(
        "dark_man", 1.87, _body(0.0, 0.70, 0.62, 0.50), (120, 82, 60), (18, 16, 16),
        jacket=(34, 35, 40), trousers=(28, 29, 34), shoes=(20, 20, 22), hair_thickness=0.008,
        open_front=(92, 94, 100), hem=-0.05, seed=3,
    ),
    Person(
        "shirt_woman", 1.60, _body(1.0, 0.72, 0.48, 0.55), (234, 196, 172), (190, 150, 92),
        jacket=(168, 44, 52), trousers=(46, 60, 98), shoes=(210, 208, 204), extras=("bob",),
        short_sleeves=True, hem=0.0, seed=4,
    ),
    Person(
        "overall_man", 1.75, _body(0.0, 0.86, 0.50, 0.92), (218, 168, 144), (150, 148, 144),
        jacket=(44, 84, 150), trousers=(42, 78, 142), shoes=(50, 40, 32), beard=True, bald=0.12,
        hair_thickness=0.007, looseness=1.3, seed=5,
    ),
    Person(
        "tall_man", 1.94, _body(0.0, 0.68, 0.55, 0.40), (196, 150, 120), (34, 26, 22),
        jacket=(206, 210, 214), trousers=(150, 134, 104), shoes=(86, 58, 38), hem=-0.01, seed=6,
    ),
    Person(
        "old_woman", 1.56, _body(1.0, 0.92, 0.45, 0.78), (222, 180, 156), (176, 174, 172),
        jacket=(66, 104, 74), trousers=(92, 90, 92), shoes=(48, 44, 46), extras=("bob",),
        open_front=(214, 206, 190), hem=-0.06, looseness=1.2, seed=7,
    ),
    Person(
        "helmet_man", 1.74, _body(0.0, 0.72, 0.70, 0.66), (176, 128, 98), (40, 30, 26),
        jacket=(246, 120, 34), trousers=(40, 46, 70), shoes=(46, 42, 38), extras=("helmet",),
        reflective_jacket=True, looseness=1.25, seed=8,
    ),
)  # fmt: skip
