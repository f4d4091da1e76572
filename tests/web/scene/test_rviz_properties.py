"""Each property that rviz writes into its files is honoured here, or named to the user."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml

from pyros1.web.scene.rviz.defaults import INVISIBLE_PROPERTIES
from pyros1.web.scene.rviz.file import RvizFile, read_rviz

pytestmark = pytest.mark.once

SAVED: Mapping[str, Any] = yaml.safe_load(Path(__file__).with_name("rviz_saved.yaml").read_text())[
    "Visualization Manager"
]
OTHER_CHOICES = {
    "Axis": "X",
    "Color Scheme": "costmap",
    "Color Transformer": "FlatColor",
    "Color Transport Hint": "compressed",
    "Depth Map Transport Hint": "compressed",
    "Image Rendering": "overlay",
    "Line Style": "Billboards",
    "Line Style/Value": "Billboards",
    "Plane": "XZ",
    "Pose Style": "Axes",
    "Reference Frame": "base",
    "Shape": "Axes",
    "Shape/Value": "Axes",
    "Style": "Boxes",
    "Target Frame": "base",
    "Transport Hint": "compressed",
}
"""Properties with a choice, and another than rviz makes."""
WORKING = [
    {},
    {"Color Transformer": "FlatColor"},
    {"Color Transformer": "AxisColor", "Autocompute Value Bounds": {"Min Value": 0, "Max Value": 5, "Value": False}},
    {"Color Transformer": "Intensity", "Autocompute Intensity Bounds": False, "Min Intensity": 0, "Max Intensity": 5},
]
"""Many properties work only while others have certain values: one of these lets each of them work."""
DISPLAYS = {each["Class"].removeprefix("rviz/"): each for each in SAVED["Displays"]}


def read(display: Mapping[str, Any]) -> RvizFile:
    topics = {key: "/one" for key in display if key.endswith("Topic") and not display[key]}
    return read_rviz(
        yaml.safe_dump({"Visualization Manager": {"Displays": [{**display, **topics}]}}),
        lambda name: "/" + name.strip("/"),
    )


def leaves(values: Mapping[str, Any], before: str = "") -> Iterator[str]:
    """Yield the names of the properties; inner ones as ``Covariance/Position/Alpha``."""
    for key, value in values.items():
        if isinstance(value, dict) and value:
            yield from leaves(value, f"{before}{key}/")
        elif not isinstance(value, dict):
            yield before + key


def with_another(values: Mapping[str, Any], name: str) -> dict[str, Any]:
    changed = copy.deepcopy(dict(values))
    *path, last = name.split("/")
    inner = changed
    for key in path:
        inner = inner[key]
    value = inner[last]
    if isinstance(value, bool):
        inner[last] = not value
    elif last.endswith("Alpha"):
        inner[last] = value / 4
    elif isinstance(value, (int, float)):
        inner[last] = value + 0.25 if isinstance(value, float) else value + 2
    else:
        inner[last] = OTHER_CHOICES.get(name) or ("1; 2; 3" if "Color" in last and ";" in value else "other")
    return changed


def works_or_is_named(values: Mapping[str, Any], name: str) -> bool:
    for more in WORKING:
        base = {**values, **(more if "Color Transformer" in values else {})}
        if name.partition("/")[0] in more and name in more:
            continue
        before, after = read(base), read(with_another(base, name))
        if before.settings != after.settings or name in " ".join(after.notes):
            return True
    return False


@pytest.mark.slow
@pytest.mark.parametrize("kind", sorted({*DISPLAYS} - {"Axes"}))  # which is named as a whole
def test_each_property_of_a_display_is_honoured_or_named(kind: str) -> None:
    display = DISPLAYS[kind]
    forgotten = [
        name
        for name in leaves(display)
        if name not in INVISIBLE_PROPERTIES
        and not name.startswith(("Links/", "Frames/"))
        and not works_or_is_named(display, name)
    ]
    assert not forgotten, forgotten


@pytest.mark.parametrize("kind", sorted(DISPLAYS))
def test_what_rviz_writes_by_itself_is_not_named(kind: str) -> None:
    expected = ["Axes: use the TF display for axes of frames"] if kind == "Axes" else []
    assert read({**DISPLAYS[kind], "Enabled": True}).notes == expected


@pytest.mark.slow
def test_each_property_of_views_tools_and_the_whole_is_honoured_or_named() -> None:
    forgotten = []

    def look(kind: str, values: Mapping[str, Any], whole: Any) -> None:
        def read_it(changed: Mapping[str, Any]) -> RvizFile:
            return read_rviz(
                yaml.safe_dump({"Visualization Manager": whole(changed)}), lambda name: "/" + name.strip("/")
            )

        before = read_it(values)
        assert before.notes == []
        for name in leaves(values):
            after = read_it(with_another(values, name))
            if name not in INVISIBLE_PROPERTIES and before == after:
                forgotten.append(f"{kind}: {name}")

    look("Global Options", SAVED["Global Options"], lambda values: {"Global Options": values})
    for tool in SAVED["Tools"]:
        look(tool["Class"], tool, lambda values: {"Tools": [values]})
    for view in SAVED["Views"]["Every"]:
        look(view["Class"], view, lambda values: {"Views": {"Current": values}})
    assert not forgotten, forgotten


def test_a_property_that_nobody_knows_is_named() -> None:
    display = {**DISPLAYS["Path"], "Sparkle": True, "Glow": {"Colour": "red"}}
    assert read(display).notes == ["Path: not supported: Glow/Colour red, Sparkle"]
