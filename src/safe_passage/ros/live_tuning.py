"""Serves some of a node's parameters by dynamic_reconfigure, to be changed while it runs."""

from __future__ import annotations

import threading
from typing import Any, Callable, Generic, Iterable, TypeVar

import rospy
from dynamic_reconfigure.server import Server

from safe_passage.core.described import Description
from safe_passage.core.errors import ParameterError
from safe_passage.core.tuning import changed, description_at, value_at

T = TypeVar("T")

TYPES = {"float": "double", "int": "int", "bool": "bool", "str": "str"}
PYTHON_TYPES = {"float": float, "int": int, "bool": bool, "str": str}
GROUPS = "groups"  # dynamic_reconfigure's own key beside the parameters

OnRequest = Callable[[dict, int], dict]


class LiveTuning(Generic[T]):
    """The node takes a new set out between two of its cycles; a change is in it whole or refused.

    Unlike the library's server it does not clamp: a value out of range, or one that does not go
    with the others, refuses the request with a message, and the values in force are told back.

    Args:
        parameters: in force, as the node read them.
        names: paths (core.tuning) of those that may be changed, of type float, int, bool or str.
        namespace: of the parameters, the node's own or one in it.
    """

    def __init__(self, parameters: T, names: Iterable[str], namespace: str = "~") -> None:
        self._lock = threading.Lock()
        self._newest, self._is_new = parameters, False
        self._names = tuple(names)
        found = [description_at(parameters, name) for name in self._names]
        self._kinds = {one.name: PYTHON_TYPES[one.type] for one in found}
        self._server = _Server(_Kind(found), self._values(), self._on_request, namespace)

    def take(self) -> T | None:
        """The set from now on, if it was changed since the last call."""
        with self._lock:
            is_new, self._is_new = self._is_new, False
            return self._newest if is_new else None

    def _values(self) -> dict[str, Any]:
        """As they are told: yaml may have given a whole number for a float."""
        return {name: kind(value_at(self._newest, name)) for name, kind in self._kinds.items()}

    def _on_request(self, config: dict[str, Any], _level: int) -> dict[str, Any]:
        """The values in force after it."""
        with self._lock:
            now = self._values()
            wanted = {
                name: value
                for name, value in config.items()
                if name != GROUPS and (name not in now or value != now[name])
            }
            if wanted:
                self._change(wanted)
            return {**self._values(), GROUPS: config[GROUPS]}

    def _change(self, wanted: dict[str, Any]) -> None:
        said = ", ".join(f"{name} = {value}" for name, value in wanted.items())
        try:
            unknown = [name for name in wanted if name not in self._kinds]
            if unknown:
                raise ParameterError(f"{', '.join(unknown)}: cannot be changed while it runs")
            self._newest = changed(self._newest, wanted)
        except ParameterError as error:
            rospy.logwarn(f"refused: {said}; nothing is changed: {error}")
            return
        self._is_new = True
        rospy.loginfo(f"changed: {said}")


class _Kind:
    """What the library wants in place of a module that is generated from a .cfg file."""

    def __init__(self, descriptions: list[Description]) -> None:
        bounds = {"bool": (False, True), "str": ("", "")}
        self.min, self.max, self.defaults = {}, {}, {}
        for one in descriptions:
            kind = PYTHON_TYPES[one.type]
            least, most = bounds.get(one.type, (one.least, one.most))
            if one.choices and one.type in ("int", "float"):
                least, most = min(one.choices), max(one.choices)
            self.min[one.name], self.max[one.name] = kind(least), kind(most)
            self.defaults[one.name] = kind(one.default)
        self.config_description = {
            "name": "Default",
            "type": "",
            "state": True,
            "id": 0,
            "parent": 0,
            "groups": [],
            "parameters": [_told(one) for one in descriptions],
        }


def _told(one: Description) -> dict[str, Any]:
    unit = f" [{one.unit}]" if one.unit else ""
    enum = ""
    if one.choices:
        consts = [
            {"name": str(choice), "value": choice, "type": TYPES[one.type], "description": ""}
            for choice in one.choices
        ]
        enum = str({"enum_description": one.name, "enum": consts})
    return {
        "name": one.name,
        "type": TYPES[one.type],
        "level": 1,
        "description": f"{one.text}{unit}".strip(),
        "edit_method": enum,
    }


class _Server(Server):
    """The library's, but for who has read the parameters already and refuses instead of clamps."""

    def __init__(
        self, kind: _Kind, values: dict[str, Any], callback: OnRequest, namespace: str
    ) -> None:
        self._values_at_start = values
        super().__init__(kind, callback, "" if namespace == "~" else namespace.rstrip("/"))

    def _copy_from_parameter_server(self) -> None:
        self.config.update(self._values_at_start)

    def _clamp(self, config: dict[str, Any]) -> None:
        """What is out of range is refused."""
