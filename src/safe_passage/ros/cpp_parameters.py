"""Parameters of the C++ nodes, as their source and yaml tell: what node_pages cannot ask them.

Ranges, units and choices stand in the calls of `Parameters::read` (include/safe_passage/ros/
parameters.h), defaults and meanings in config/NODE.yaml. test/node/live_tuning.test holds what is
found here against what the running nodes tell.
"""

from __future__ import annotations

import re
from pathlib import Path

import yaml

from safe_passage.core.described import REQUIRED, Description

READ = re.compile(
    r'\.read(?P<choice>_choice)?\(\s*"(?P<name>[\w/]+)",\s*[\w.]+'
    r'(?:,\s*\{(?P<braces>[^}]*)\})?(?:,\s*"(?P<unit>[^"]*)")?\)'
)
LIVE = re.compile(r"kLive\w*Parameters = \{([^}]*)\}")
KEY = re.compile(r"(?P<indent> *)(?P<off># )?(?P<key>\w+):(?P<value>[^#]*)(?:# ?(?P<comment>.*))?$")
MORE = re.compile(r" +# ?(?P<comment>.*)$")
TYPES = {bool: "bool", int: "int", float: "float", str: "str"}


def read_cpp(sources: list[Path], config: Path) -> tuple[tuple[Description, ...], frozenset]:
    """The node's parameters in the order in which it reads them; names of those that are live."""
    code = "".join(path.read_text() for path in sources)
    values, texts = _flat(yaml.safe_load(config.read_text())), _comments(config.read_text())
    live = frozenset(name for names in LIVE.findall(code) for name in _quoted(names))
    found = [_description(call, values, texts) for call in READ.finditer(code)]
    return tuple(found), live


def _description(call: re.Match, values: dict, texts: dict[str, str]) -> Description:
    name, braces = call["name"], call["braces"] or ""
    choices = tuple(_quoted(braces)) if call["choice"] else ()
    bounds = [] if choices or not braces else [_number(text) for text in braces.split(",")]
    least, most = bounds or (None, None)
    value = values.get(name, REQUIRED)
    kind = TYPES.get(type(value), "list" if isinstance(value, list) else "str")
    said, text = _without_unit(texts.get(name, ""))
    text = re.sub(r"^-?[\d.]+ to -?[\d.]+(: |$)", "", text)  # the range
    unit = re.sub(r"^\(|\)$| \(.*", "", call["unit"] or "") or said
    text = "" if text == unit else text
    return Description(name, kind, value, least, most, unit, choices, text)


def _number(text: str) -> float | str:
    """A bound; one that is another parameter stays its name."""
    try:
        return float(text)
    except ValueError:
        return text.strip().rsplit(".", 1)[-1]


def _quoted(text: str) -> list[str]:
    return re.findall(r'"([^"]*)"', text)


def _without_unit(text: str) -> tuple[str, str]:
    found = re.match(r"\[([^\]]+)\] ?(.*)", text)
    return (found.group(1), found.group(2)) if found else ("", text)


def _flat(values: dict, prefix: str = "") -> dict:
    found = {}
    for key, value in values.items():
        if isinstance(value, dict):
            found.update(_flat(value, f"{prefix}{key}/"))
        else:
            found[prefix + key] = value
    return found


def _comments(text: str) -> dict[str, str]:
    """What stands behind each key, and in the lines of nothing but a comment that go on with it."""
    comments: dict[str, str] = {}
    group, name = "", ""
    for line in text.splitlines():
        found, more = KEY.match(line), MORE.match(line)
        if more and name and not (found and found["off"]):
            comments[name] += " " + more["comment"].strip()
            continue
        name = ""
        if found is None:
            continue
        inside = found["indent"] and group
        if not found["value"].strip() and not found["off"] and not found["indent"]:
            group = found["key"] + "/"
            continue
        group = group if inside else ""
        name = group + found["key"]
        comments[name] = (found["comment"] or "").strip()
    return comments
