"""The expressions of joy_remap.py, for joysticks of every shape."""

from __future__ import annotations

import random
from math import inf, nan
from pathlib import Path
from typing import Any

import pytest
import yaml

from pyros1.finding.packages import OWN_PACKAGES
from pyros1.ground.errors import Error
from pyros1.robot_nodes.joy.remapping import MAX_EXPRESSIONS, Remapping

PS4 = yaml.safe_load((Path(OWN_PACKAGES) / "joy" / "config" / "ps4joy.yaml").read_text(encoding="utf-8"))["mappings"]


def test_a_ps4_controller_looks_like_one_of_a_ps3() -> None:
    """Feature: joy_remap.py converts the axes and buttons of a joystick by expressions"""
    mapping = Remapping(PS4["axes"], PS4["buttons"], pytest.fail)
    chance = random.Random(1)
    for _ in range(50):
        axes = [chance.uniform(-1, 1) for _ in range(14)]
        buttons = [chance.randint(0, 1) for _ in range(14)]
        new_axes, new_buttons = mapping(axes, buttons)
        assert (len(new_axes), len(new_buttons)) == (27, 17)
        up, right, down, left = max(axes[10], 0), max(-axes[9], 0), max(-axes[10], 0), max(axes[9], 0)
        assert new_axes[8:12] == pytest.approx([-up, -right, -down, -left])
        assert new_axes[12:14] == pytest.approx([(axes[3] - 1) / 2, (axes[4] - 1) / 2])
        assert new_axes[14:20] == [-buttons[number] for number in (4, 5, 3, 2, 1, 0)]
        assert new_buttons[4:8] == [int(pressed > 0) for pressed in (up, right, down, left)]
        assert new_buttons[8:] == [buttons[number] for number in (6, 7, 4, 5, 3, 2, 1, 0, 12)]


@pytest.mark.parametrize("text", ["axes[9]", "1 / axes[0]", "nothing", "axes", "'x'", "1e39", "1e308 * 10", "axes[1]"])
def test_an_unusable_value_is_0_and_reported(text: str) -> None:
    reports: list[str] = []
    assert Remapping([text, 0.5], [text], reports.append)([0.0, nan], []) == ([0.0, 0.5], [0])
    assert len(reports) == 2 and all(f"[{text}]" in report for report in reports)


def test_every_shape_of_joystick() -> None:
    mapping = Remapping(["axes[0] * 2", "max(axes)"], ["sum(buttons) - 1"], lambda _: 0)
    for num_axes in range(4):
        for num_buttons in range(4):
            axes, buttons = [0.25] * num_axes, [1] * num_buttons
            expected = [0.5 if num_axes else 0.0, 0.25 if num_axes else 0.0]
            assert mapping(axes, buttons) == (expected, [int(num_buttons > 1)])
    assert mapping([inf], [2**40]) == ([0.0, 0.0], [1])


@pytest.mark.parametrize(
    ("axes", "reason"),
    [
        ("axes[0]", "must be a list"),
        ({"x": 1}, "must be a list"),
        (["axes["], "~mappings/axes"),
        (["__import__('os')"], "~mappings/axes"),
        ([0] * (MAX_EXPRESSIONS + 1), "257 expressions"),
    ],
)
def test_malformed_mappings_are_refused(axes: Any, reason: str) -> None:
    with pytest.raises(Error, match=reason):
        Remapping(axes, [], print)
