"""Lists of sources of velocity commands."""

from __future__ import annotations

from math import inf, nan
from typing import Any

import pytest

from pyros1.robot_nodes.shared.twist_sources import Source, SourceError, read_sources

GOOD = {"name": "joy", "topic": "joy_vel", "timeout": 0.5, "priority": 10}


def test_reading() -> None:
    assert read_sources([], "/mux/locks") == []
    assert read_sources([GOOD, {**GOOD, "timeout": 1, "priority": 255.0}], "/mux/topics", 255) == [
        Source("joy", "joy_vel", 0.5, 10),
        Source("joy", "joy_vel", 1.0, 255),
    ]


@pytest.mark.parametrize(
    ("value", "problem"),
    [
        ({"joy": GOOD}, "/mux/topics must be a list, not {'joy'"),
        ([GOOD, 5], r"/mux/topics\[1\] must have name, topic, timeout and priority, but is 5"),
        ([{**GOOD, "name": 3}], r"topics\[0\] needs a name, a string, not 3"),
        ([{**GOOD, "topic": ""}], r"topics\[0\] \(joy\) needs a topic, a string, not ''"),
        ([{**GOOD, "timeout": -1}], r"\(joy\) needs a timeout, a number of at least 0, not -1"),
        ([{**GOOD, "timeout": nan}], "needs a timeout, a number of at least 0, not nan"),
        ([{**GOOD, "timeout": inf}], "needs a timeout"),
        ([{**GOOD, "priority": 256}], "needs a priority, an integer from 0 to 255, not 256"),
        ([{**GOOD, "priority": 1.5}], "needs a priority"),
        ([{key: value for key, value in GOOD.items() if key != "priority"}], "needs a priority, .*, not None"),
    ],
)
def test_entries_that_cannot_be_used(value: Any, problem: str) -> None:
    with pytest.raises(SourceError, match=problem):
        read_sources(value, "/mux/topics", 255)
