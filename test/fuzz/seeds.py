"""Small valid inputs of each fuzz target, from which the fuzzer starts: seeds.py FOLDER."""

from __future__ import annotations

import struct
import sys
from pathlib import Path
from typing import Iterator

HEAD = (
    "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z {last}\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
    "WIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\nDATA {kind}\n"
)
ROWS = [(1, 1, 2, 0), (2, 1, 2, 0), (1, 2, 2, 0), (2, 2, 2, 0)]
PLY = (
    "ply\nformat {kind} 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nproperty float intensity\nend_header\n"
)
TEXT = "".join("{} {} {} {}\n".format(*row) for row in ROWS).encode()
BINARY = b"".join(struct.pack("<4f", *row) for row in ROWS)
COLUMNS = struct.pack("<16f", *(row[i] for i in range(4) for row in ROWS))
LITERAL = b"".join(  # LZF without one repetition: runs of up to 32 bytes
    bytes([len(COLUMNS[i : i + 32]) - 1]) + COLUMNS[i : i + 32] for i in range(0, len(COLUMNS), 32)
)
COMPRESSED = struct.pack("<II", len(LITERAL), len(COLUMNS)) + LITERAL


def pcd(last: str) -> Iterator[bytes]:
    for kind, data in (("ascii", TEXT), ("binary", BINARY), ("binary_compressed", COMPRESSED)):
        yield HEAD.format(last=last, kind=kind).encode() + data


def ply() -> Iterator[bytes]:
    for kind, data in (("ascii", TEXT), ("binary_little_endian", BINARY)):
        yield PLY.format(kind=kind).encode() + data


SEEDS = {
    "pcd_scan": lambda: pcd("intensity"),
    "ply_scan": ply,
    "pcd_frame": lambda: pcd("rgb"),
    "cloud_message": lambda: [bytes(range(200))],
    "image_message": lambda: [bytes(range(200))],
    "person_message": lambda: [bytes(range(200))],
    "scan_message": lambda: [bytes(range(200))],
}

if __name__ == "__main__":
    for name, make in SEEDS.items():
        folder = Path(sys.argv[1]) / name
        folder.mkdir(parents=True, exist_ok=True)
        for i, content in enumerate(make()):
            (folder / f"seed{i}").write_bytes(content)
