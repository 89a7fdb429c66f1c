"""The nodes' pages are those of the code, and what is written by hand names what there is."""

from __future__ import annotations

import re

import pytest
from safe_passage.core.described import Description
from safe_passage.ros.cpp_parameters import read_cpp
from safe_passage.ros.node_pages import BEGIN, END, ROOT, TABLES, cpp_table, renewed, table

PAGES = ROOT / "docs/nodes"
LINK = re.compile(r"\]\((?!http)([^)#]+)")


@pytest.mark.parametrize("node", TABLES)
def test_the_page_is_up_to_date(node):
    page = (PAGES / f"{node}.md").read_text()
    assert renewed(page, node) == page, "python3 -m safe_passage.ros.node_pages --write"


def test_what_is_written_by_hand_stays():
    node = "leg_detector"
    page = renewed(f"before\n{BEGIN}\noutdated\n{END}\nafter\n", node)
    assert page.startswith(f"before\n{BEGIN}\n| parameter") and page.endswith(f"|\n{END}\nafter\n")
    assert "outdated" not in page
    with pytest.raises(ValueError, match="leg_detector"):
        renewed("no marks", node)


def test_a_row_tells_name_default_range_unit_and_meaning():
    row = table([Description("a/b", "float", 0.5, 0, 1e9, "m", (), "x | y")], ["a/b"])
    assert row.splitlines()[-1] == "| `a/b` | 0.5 | 0 to 1e+09 | m | yes | x \\| y |"


@pytest.mark.parametrize(
    "node, source",
    [
        ("person_detector", "src/ros/detector_parameters.cpp"),
        ("safety_area_merger", "include/safe_passage/ros/safety_area_parameters.h"),
    ],
)
def test_no_parameter_of_a_cpp_node_is_missed(node, source):
    parameters, live = cpp_table(node)
    names = [one.name for one in parameters]
    code = (ROOT / source).read_text()
    assert len(names) == len(set(names)) == len(re.findall(r"\.read(?:_choice)?\(", code))
    assert live and live <= set(names)


def test_cpp_reader_and_yaml_are_put_together(tmp_path):
    source, config = tmp_path / "a.h", tmp_path / "a.yaml"
    source.write_text(
        'from.read("near", p.near, {0.1, 2.0}, "m (of all)");\n'
        'reader.read_choice("group/kind", kind, {"a", "b"});\n'
        'from.read("group/far", p.far, {0, p.near}, "m");\n'
        'from.read("hidden", p.hidden);\n'
        'inline const std::set<std::string> kLiveParameters = {"near", "group/far"};\n'
    )
    config.write_text(
        "near: 1.5   # [m] 0.1 to 2: not farther\n"
        "            # than this\n"
        "# alone\n"
        "group:\n"
        "  kind: b   # a or b\n"
        "  far: 1    # m\n"
        "# hidden: 3 # not set\n"
    )
    found, live = read_cpp([source], config)
    near, kind, far, hidden = found
    assert (near.default, near.least, near.most, near.unit) == (1.5, 0.1, 2.0, "m")
    assert near.text == "not farther than this"
    assert (kind.default, kind.choices, kind.text) == ("b", ("a", "b"), "a or b")
    assert (far.least, far.most, far.text) == (0.0, "near", "")
    assert hidden.text == "not set"
    assert live == {"near", "group/far"}


def test_links_of_readme_and_docs_lead_somewhere():
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        for link in LINK.findall(page.read_text()):
            assert (page.parent / link).exists(), f"{page.name}: {link}"


def test_the_tuning_guide_names_parameters_that_its_nodes_have():
    names = {node: {one.name.lower() for one in make()[0]} for node, make in TABLES.items()}
    node, seen = "", 0
    for line in (ROOT / "docs/tuning.md").read_text().splitlines():
        if not line.startswith("| ") or line.startswith("| what you see"):
            continue
        node = ""
        for nodes, name in re.findall(rf"\b({'|'.join(TABLES)})\b|`([\w/]+)`", line.split("|")[2]):
            node = nodes or node
            if name and node:
                known = {*names[node], *(full.rsplit("/", 1)[-1] for full in names[node])}
                assert name.lower() in known, f"{node}: {name}"
                seen += 1
    assert seen > 50
