"""Colours and textures of a world's materials, painted from noise; nothing is photographed."""

from __future__ import annotations

from typing import Callable, Mapping

import numpy as np

Texture = np.ndarray  # (N, N, 3) uint8 RGB
SIDE = 128  # [px] of a texture


def _noise(rng: np.random.Generator, cells: int, strength: float) -> np.ndarray:
    """Smooth noise (SIDE, SIDE, 1) around 1 with blotches SIDE / cells px wide."""
    coarse = rng.normal(0.0, strength, (cells + 1, cells + 1))
    at = np.linspace(0, cells, SIDE, endpoint=False)
    low, part = at.astype(int), at % 1.0
    rows = coarse[low] * (1 - part)[:, None] + coarse[low + 1] * part[:, None]
    both = rows[:, low] * (1 - part) + rows[:, low + 1] * part
    return 1.0 + both[..., None]


def _paint(rng: np.random.Generator, colour: tuple[float, float, float], cells: int) -> np.ndarray:
    return np.array(colour) * _noise(rng, cells, 0.05) * _noise(rng, SIDE // 2, 0.02)


def _concrete(rng: np.random.Generator) -> np.ndarray:
    picture = _paint(rng, (150, 150, 146), 6)
    picture[0], picture[:, 0] = 118, 118  # joints
    return picture


def _wall(rng: np.random.Generator) -> np.ndarray:
    picture = _paint(rng, (196, 198, 192), 5)
    picture[::16] *= 0.93  # trapezoidal sheet
    return picture


def _wood(rng: np.random.Generator) -> np.ndarray:
    grain = 1.0 + 0.10 * np.sin(np.linspace(0, 60, SIDE) + rng.normal(0, 0.5, SIDE))
    return _paint(rng, (176, 139, 92), 8) * grain[:, None, None]


def _cardboard(rng: np.random.Generator) -> np.ndarray:
    picture = _paint(rng, (172, 130, 86), 6)
    picture[58:70] = (196, 170, 120)  # tape
    picture[:2], picture[-2:] = 110, 110
    picture[:, :2], picture[:, -2:] = 110, 110
    picture[84:110, 20:56] = 225  # label
    for row in range(88, 108, 5):
        picture[row, 24:52] = 60
    return picture


def _plastic(rng: np.random.Generator) -> np.ndarray:
    picture = _paint(rng, (70, 96, 120), 5)
    picture[::16, :] *= 0.7
    picture[:, ::16] *= 0.7
    return picture


PAINTERS: Mapping[str, Callable[[np.random.Generator], np.ndarray]] = {
    "concrete": _concrete,
    "wall": _wall,
    "steel": lambda rng: _paint(rng, (42, 74, 140), 8),
    "beam": lambda rng: _paint(rng, (222, 108, 34), 8),
    "wood": _wood,
    "cardboard": _cardboard,
    "plastic": _plastic,
    "metal": lambda rng: _paint(rng, (128, 132, 136), 10),
}


def paint(material: str) -> Texture:
    """The material's texture, the same each time."""
    rng = np.random.default_rng(sorted(PAINTERS).index(material))
    return np.clip(PAINTERS[material](rng), 0, 255).astype(np.uint8)
