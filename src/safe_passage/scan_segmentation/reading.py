"""Point clouds of files: PCD, PLY, XYZ, and 3DTK's .3d."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import safe_passage._scan_segmentation as kernels
from safe_passage.core.errors import InputError

ENDINGS = (".pcd", ".ply", ".xyz", ".txt", ".asc", ".3d")
NO_RETURN_3DTK = 32.75  # [m] what its scanners report when nothing is met


@dataclass(frozen=True)
class Cloud:
    """Points as a file holds them; no return is NaN."""

    points: np.ndarray  # (H, W, 3) [m], one line of a cloud that is not organised
    remission: np.ndarray | None  # (H, W)
    origin: tuple[float, float, float]  # [m] of the scanner


def read_cloud(file: Path) -> Cloud:
    """The cloud of a file, by its ending.

    Raises:
        InputError: naming the file, and what is wrong with it.
    """
    ending = file.suffix.lower()
    if ending not in ENDINGS:
        raise InputError(f"{file}: known are {', '.join(ENDINGS)}")
    if not file.is_file():
        raise InputError(f"{file}: no such file")
    if ending in (".pcd", ".ply"):
        return _read_with_pcl(file)
    table = _read_numbers(file)
    remission = table[None, :, 3] if table.shape[1] > 3 else None
    points = _from_3dtk(table[:, :3]) if ending == ".3d" else table[:, :3]
    return Cloud(without_returns_at_zero(points[None]), remission, (0.0, 0.0, 0.0))


def _read_with_pcl(file: Path) -> Cloud:
    try:
        points, remission, origin = kernels.read_cloud(str(file))
    except (RuntimeError, MemoryError, ValueError) as error:
        raise InputError(f"{file}: {error}".replace(f"{file}: {file}", str(file))) from None
    return Cloud(without_returns_at_zero(points), remission, origin)


def without_returns_at_zero(points: np.ndarray) -> np.ndarray:
    """Some drivers write 0, 0, 0 where nothing was met."""
    return np.where((points == 0.0).all(axis=-1)[..., None], np.nan, points)


def _read_numbers(file: Path) -> np.ndarray:
    """(N, columns) of lines of numbers, with commas or blanks between; comments are passed over."""
    try:
        text = file.read_text(encoding="ascii", errors="strict")
    except UnicodeDecodeError:
        raise InputError(f"{file}: not a text of numbers") from None
    lines = [line for line in text.replace(",", " ").splitlines() if _is_data(line)]
    if not lines:
        raise InputError(f"{file}: no lines of x y z in it")
    columns = len(lines[0].split())
    try:
        values = np.array(" ".join(lines).split(), dtype=float)
        return values.reshape(len(lines), columns)
    except ValueError:
        raise InputError(f"{file}: not every line has {columns} numbers") from None


def _is_data(line: str) -> bool:
    """Three columns or more that begin with a number: no comment, header or count of points."""
    parts = line.split(maxsplit=3)
    if len(parts) < 3 or line.lstrip().startswith(("#", "//")):
        return False
    try:
        float(parts[0])
    except ValueError:
        return False
    return True


def _from_3dtk(points: np.ndarray) -> np.ndarray:
    """Centimetres, x to the right, y up, z forward, in metres, x forward, y to the left, z up."""
    found = np.stack([points[:, 2], -points[:, 0], points[:, 1]], axis=1) * 0.01
    found[np.linalg.norm(found, axis=1) > NO_RETURN_3DTK] = np.nan
    return found
