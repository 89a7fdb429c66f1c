"""Faults of an input, as what becomes of its healthy messages; generic by message type."""

from __future__ import annotations

import copy
import math
from typing import Any, Callable

import numpy as np
import rospy
from sensor_msgs.msg import CameraInfo, Image, JointState, LaserScan, PointCloud2
from tf2_msgs.msg import TFMessage

OLD = 10.0  # [s] that stale and future messages are off
BEHIND = 0.15  # [s] that a message out of order is behind the last
SLOW = 10  # a tenth of the rate
MANY = 10**6  # elements of an array that is too long
MANY_MESSAGES = 10**4  # the same where each is a message: python makes them one by one
NOWHERE = "no_such_frame"
LARGEST = 1e308  # finite
DIMENSION = 2**31 - 1

Transform = Callable[[Any, int], "list[Any]"]  # a healthy message, its number -> what is sent


def silent(_message: Any, _number: int) -> list[Any]:
    """Nothing."""
    return []


def slow(message: Any, number: int) -> list[Any]:
    """Every tenth."""
    return [message] if number % SLOW == 0 else []


def nan(message: Any, number: int) -> list[Any]:
    """No number in the arrays; in every second message in no field at all."""
    spoilt = copy.deepcopy(message)
    if isinstance(message, (PointCloud2, Image)):
        spoilt.data = _nan_bytes(message)
    else:
        _fill(spoilt, math.nan, fields=number % 2 == 1 or not _has_arrays(message))
    return [spoilt]


def empty(message: Any, _number: int) -> list[Any]:
    """Arrays of length zero."""
    spoilt = copy.copy(message)
    for name, kind in _slots(message):
        if kind.endswith("[]") and not (isinstance(message, PointCloud2) and name == "fields"):
            setattr(spoilt, name, b"" if isinstance(getattr(message, name), bytes) else [])
        elif name in ("width", "height", "step", "row_step"):
            setattr(spoilt, name, 0)
    return [spoilt]


def truncated(message: Any, number: int) -> list[Any]:
    """Half of what the rest of the message tells; of tracks, in turn, sensors and cells."""
    spoilt = copy.deepcopy(message)
    parts = getattr(spoilt, "obstacles", [])
    if parts and number % 2:
        for part in parts:
            part.cells_y = _half(part.cells_y)
        return [spoilt]
    for name in ("data", "ranges", "position", "alive"):
        if _is_array(spoilt, name):
            setattr(spoilt, name, _half(getattr(spoilt, name)))
    return [spoilt]


def huge(message: Any, number: int) -> list[Any]:
    """Arrays too long, dimensions that lie, numbers too large; a few, for they take their time."""
    if number % SLOW:
        return []
    spoilt = copy.deepcopy(message)
    if isinstance(message, (PointCloud2, Image, CameraInfo)):
        spoilt.width, spoilt.height = DIMENSION, DIMENSION
    elif isinstance(message, LaserScan):
        spoilt.ranges = _long(spoilt.ranges)
    elif isinstance(message, JointState):
        spoilt.position = _long(spoilt.position)
    elif hasattr(message, "obstacles"):
        for part in spoilt.obstacles[:1]:
            part.cells_x, part.cells_y = _long(part.cells_x), _long(part.cells_y)
    elif many := next((n for n in ("persons", "poses") if hasattr(message, n)), ""):
        setattr(spoilt, many, list(getattr(message, many))[:1] * MANY_MESSAGES)
    else:
        _fill(spoilt, LARGEST, fields=True)
    return [spoilt]


def wrong_frame(message: Any, _number: int) -> list[Any]:
    """Of a frame that tf does not know."""
    spoilt = copy.deepcopy(message)
    for header in _headers(spoilt):
        header.frame_id = NOWHERE
    if getattr(spoilt, "child_frame_id", ""):
        spoilt.child_frame_id = NOWHERE
    return [spoilt]


def stale(message: Any, _number: int) -> list[Any]:
    """As old messages that come late."""
    return [shifted(message, -OLD)]


def future(message: Any, _number: int) -> list[Any]:
    """As of a host whose clock is ahead."""
    return [shifted(message, OLD)]


def out_of_order(message: Any, number: int) -> list[Any]:
    """Every second message is behind the last."""
    return [shifted(message, -BEHIND) if number % 2 else message]


def duplicated(message: Any, _number: int) -> list[Any]:
    """Everything twice."""
    return [message, message]


def wrong_transform(message: TFMessage, number: int) -> list[Any]:
    """Transforms that are none: a translation of NaN; a rotation of length zero, or two."""
    spoilt = copy.deepcopy(message)
    for one in spoilt.transforms:
        turn = one.transform.rotation
        if number % 3 == 0:
            one.transform.translation.x = math.nan
        else:
            turn.x = turn.y = turn.z = 0.0
            turn.w = 0.0 if number % 3 == 1 else 2.0
    return [spoilt]


OF_MESSAGES: dict[str, Transform] = {
    "silent": silent,
    "slow": slow,
    "NaN": nan,
    "empty": empty,
    "truncated": truncated,
    "huge": huge,
    "wrong frame": wrong_frame,
    "stale": stale,
    "future": future,
    "out of order": out_of_order,
    "duplicated": duplicated,
}
OF_TF: dict[str, Transform] = {
    "tf gap": silent,
    "tf wrong": wrong_transform,
    **{
        name: OF_MESSAGES[name]
        for name in ("slow", "wrong frame", "stale", "future", "out of order", "duplicated")
    },
}

NOT_OF_TF = {
    "silent": "it is the tf gap",
    "empty": "it is the tf gap",
    "NaN": "it is tf wrong",
    "truncated": "no array whose length another field tells",
    "huge": "a finite transform is believed: nothing tells a far one from a wrong one",
}


def faults_of(message: Any) -> dict[str, Transform]:
    """Those that a healthy message of an input can have, by name."""
    if isinstance(message, TFMessage):
        return dict(OF_TF)
    without = impossible(message)
    return {name: fault for name, fault in OF_MESSAGES.items() if name not in without}


def impossible(message: Any) -> dict[str, str]:
    """Faults that such a message cannot have, and why."""
    if isinstance(message, TFMessage):
        return dict(NOT_OF_TF)
    floats = _has_floats(message) or isinstance(message, (PointCloud2, Image))
    arrays = any(kind.endswith("[]") for _, kind in _slots(message))
    stamped = any(True for _ in _headers(message))
    has_shorter = any(_is_array(message, n) for n in ("data", "ranges", "position", "alive"))
    framed = stamped and bool(next(_headers(message)).frame_id)
    return {
        name: why
        for name, can, why in (
            ("NaN", floats, "no floating-point number in it"),
            ("empty", arrays, "no array in it"),
            ("truncated", has_shorter, "no array whose length another field tells"),
            ("wrong frame", framed, "no frame in it"),
            ("stale", stamped, "no stamp in it"),
            ("future", stamped, "no stamp in it"),
            ("out of order", stamped, "no stamp in it"),
        )
        if not can
    }


def shifted(message: Any, seconds: float) -> Any:
    """The same of another time."""
    moved = copy.deepcopy(message)
    for header in _headers(moved):
        header.stamp += rospy.Duration.from_sec(seconds)
    return moved


def has_nan(message: Any, allowed: frozenset[str] = frozenset()) -> str:
    """The name of a field that is not finite and is not among those `allowed`; empty: none."""
    for name, kind in _slots(message):
        value = getattr(message, name)
        if name in allowed:
            continue
        if kind.startswith("float"):
            if not np.isfinite(value).all():
                return name
        elif "/" in kind:
            for part in value if kind.endswith("]") else [value]:
                found = has_nan(part, allowed)
                if found:
                    return f"{name}.{found}"
    return ""


def _slots(message: Any) -> list[tuple[str, str]]:
    return list(zip(message.__slots__, getattr(message, "_slot_types", ())))


def _headers(message: Any):
    """Of the message itself, or of each of its transforms."""
    if isinstance(message, TFMessage):
        yield from {id(one.header): one.header for one in message.transforms}.values()
    elif hasattr(message, "header"):
        yield message.header


def _fill(message: Any, value: float, fields: bool) -> None:
    """Floats become `value`: those in arrays, and with `fields` all others, too."""
    for name, kind in _slots(message):
        inner = getattr(message, name)
        if kind in ("float32", "float64"):
            if fields:
                setattr(message, name, min(value, 3e38) if kind == "float32" else value)
        elif kind.startswith("float"):
            setattr(message, name, [value] * len(inner))
        elif "/" in kind and kind != "std_msgs/Header":
            for part in inner if kind.endswith("]") else [inner]:
                _fill(part, value, fields or kind.endswith("]"))


def _has_floats(message: Any) -> bool:
    probe = copy.deepcopy(message)
    _fill(probe, math.nan, fields=True)
    return bool(has_nan(probe))


def _has_arrays(message: Any) -> bool:
    return any(kind.endswith("[]") and len(getattr(message, n)) for n, kind in _slots(message))


def _is_array(message: Any, name: str) -> bool:
    return dict(_slots(message)).get(name, "").endswith("[]") and len(getattr(message, name)) > 0


def _half(values: Any) -> Any:
    return values[: len(values) // 2]


def _long(values: Any) -> list[float]:
    return (list(values) * (MANY // max(len(values), 1) + 1))[:MANY] if len(values) else []


def _nan_bytes(message: Any) -> bytes:
    """The same number of bytes; of depth in millimetres 0, which says as much."""
    if getattr(message, "encoding", "32FC1") != "32FC1":
        return bytes(len(message.data))
    return np.full(len(message.data) // 4, np.nan, np.float32).tobytes()
