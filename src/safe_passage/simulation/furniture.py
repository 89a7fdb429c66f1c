"""What stands in a workshop; each element reads its own keys. Frame: map, each faces its own -y."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Sequence

from safe_passage.core.geometry import Pose
from safe_passage.core.parameters import check_range
from safe_passage.simulation.blocks import Hall, Placed


@dataclass(frozen=True)
class BenchElement(Placed):
    """A work bench: a plate on four legs, tools on it."""

    length: float = 1.8  # [m]
    depth: float = 0.8  # [m]
    height: float = 0.9  # [m]

    def __post_init__(self) -> None:
        _check_size(self, ("length", "depth", "height"))

    def build(self, hall: Hall) -> None:
        place = self.place
        a, b = 0.5 * self.length, 0.5 * self.depth
        hall.add(place, (-a, -b, self.height - 0.05), (2 * a, 2 * b, 0.05), "wood")
        for x in (-a + 0.02, a - 0.08):
            for y in (-b + 0.02, b - 0.08):
                hall.add(place, (x, y, 0.0), (0.06, 0.06, self.height - 0.05), "metal")
        _put_tools(hall, place, (a, b), self.height)


@dataclass(frozen=True)
class CabinetElement(Placed):
    """A locked metal cabinet with two doors."""

    width: float = 0.95  # [m]
    depth: float = 0.5  # [m]
    height: float = 1.95  # [m]
    shade: float = 1.0

    def __post_init__(self) -> None:
        _check_size(self, ("width", "depth", "height"))

    def build(self, hall: Hall) -> None:
        place = self.place
        a, b = 0.5 * self.width, 0.5 * self.depth
        size = (self.width, self.depth, self.height - 0.08)
        hall.add(
            place, (-a + 0.03, -b + 0.03, 0.0), (2 * a - 0.06, 2 * b - 0.06, 0.08), "metal", 0.4
        )
        hall.add(place, (-a, -b, 0.08), size, "metal", self.shade)
        for x in (-a + 0.01, 0.005):
            door = (a - 0.015, 0.015, self.height - 0.12)
            hall.add(place, (x, -b - 0.015, 0.10), door, "metal", 0.9 * self.shade)
        hall.add(place, (0.03, -b - 0.035, 0.9), (0.02, 0.02, 0.14), "steel", 0.4)


@dataclass(frozen=True)
class ShelfElement(Placed):
    """An open shelf with bins and cartons on its boards."""

    width: float = 1.2  # [m]
    depth: float = 0.45  # [m]
    height: float = 1.9  # [m]
    boards: int = 4

    def __post_init__(self) -> None:
        _check_size(self, ("width", "depth", "height"))
        check_range("boards", self.boards, 1, 20, "boards")

    def build(self, hall: Hall) -> None:
        place, rng = self.place, hall.rng
        a, b = 0.5 * self.width, 0.5 * self.depth
        for x in (-a, a - 0.04):
            for y in (-b, b - 0.04):
                hall.add(place, (x, y, 0.0), (0.04, 0.04, self.height), "metal", 0.7)
        gap = (self.height - 0.15) / self.boards
        for board in range(self.boards):
            z = 0.10 + board * gap
            hall.add(place, (-a, -b, z), (self.width, self.depth, 0.025), "metal")
            x = -a + 0.05
            while x < a - 0.25:
                width = float(rng.uniform(0.15, 0.3))
                size = (width, self.depth - 0.1, gap * float(rng.uniform(0.3, 0.8)))
                if rng.random() < 0.8:
                    material = ("plastic", "cardboard")[int(rng.integers(2))]
                    shade = float(rng.uniform(0.6, 1.1))
                    hall.add(place, (x, -b + 0.05, z + 0.025), size, material, shade)
                x += width + 0.03


@dataclass(frozen=True)
class MachineElement(Placed):
    """A milling machine: base, table, column, head and a panel to operate it."""

    shade: float = 1.0

    def build(self, hall: Hall) -> None:
        parts: Sequence[tuple[Any, Any, str, float]] = (  # lowest corner, size, material, shade
            ((-0.40, -0.35, 0.0), (0.8, 1.0, 0.25), "metal", 0.5),
            ((-0.25, 0.15, 0.25), (0.5, 0.45, 1.5), "steel", 1.0),
            ((-0.20, -0.25, 0.25), (0.4, 0.4, 0.5), "steel", 0.9),
            ((-0.65, -0.30, 0.75), (1.3, 0.45, 0.12), "metal", 0.8),
            ((-0.18, -0.30, 1.35), (0.36, 0.45, 0.45), "steel", 1.0),
            ((-0.06, -0.12, 1.10), (0.12, 0.12, 0.25), "metal", 0.4),
            ((0.36, -0.25, 1.20), (0.08, 0.35, 0.45), "plastic", 1.2),
            ((0.25, -0.10, 1.40), (0.11, 0.06, 0.06), "metal", 0.5),
        )
        for low, size, material, shade in parts:
            hall.add(self.place, low, size, material, shade * self.shade)


@dataclass(frozen=True)
class TrolleyElement(Placed):
    """A tool trolley on wheels: a lidar near the floor sees little of it."""

    def build(self, hall: Hall) -> None:
        place = self.place
        for x in (-0.38, 0.32):
            for y in (-0.23, 0.19):
                hall.add(place, (x, y, 0.0), (0.06, 0.04, 0.12), "metal", 0.3)
                hall.add(place, (x, y, 0.12), (0.03, 0.03, 0.70), "metal", 0.8)
        for z in (0.16, 0.78):
            hall.add(place, (-0.40, -0.25, z), (0.8, 0.5, 0.04), "beam", 0.9)
        hall.add(place, (-0.48, -0.20, 0.88), (0.03, 0.40, 0.03), "metal", 0.5)
        for y in (-0.20, 0.17):
            hall.add(place, (-0.48, y, 0.82), (0.14, 0.03, 0.06), "metal", 0.5)
        _put_tools(hall, self.place, (0.38, 0.23), 0.82)


@dataclass(frozen=True)
class StoolElement(Placed):
    """A stool: a column on a cross, a seat."""

    height: float = 0.55  # [m]

    def __post_init__(self) -> None:
        _check_size(self, ("height",))

    def build(self, hall: Hall) -> None:
        place = self.place
        hall.add(place, (-0.25, -0.03, 0.02), (0.5, 0.06, 0.05), "metal", 0.4)
        hall.add(place, (-0.03, -0.25, 0.02), (0.06, 0.5, 0.05), "metal", 0.4)
        hall.add(place, (-0.025, -0.025, 0.07), (0.05, 0.05, self.height - 0.11), "metal")
        hall.add(place, (-0.18, -0.18, self.height - 0.04), (0.36, 0.36, 0.04), "wood", 0.7)


def _put_tools(hall: Hall, place: Pose, half: tuple[float, float], z: float) -> None:
    """Some things somewhere on a plate that reaches `half` [m] each way."""
    a, b = half
    for material in hall.rng.choice(("plastic", "metal", "cardboard", "beam"), 4):
        size = hall.rng.uniform((0.08, 0.06, 0.03), (0.35, 0.25, 0.22))
        low = hall.rng.uniform((-a, -b), (a - size[0], b - size[1]))
        hall.add(place, (*low, z), size, str(material), float(hall.rng.uniform(0.6, 1.1)))


def _check_size(element: Any, names: Sequence[str]) -> None:
    for name in names:
        check_range(name, getattr(element, name), 0.2, 20.0, "m")
