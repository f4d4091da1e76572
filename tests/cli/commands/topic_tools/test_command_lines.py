"""Command lines of the tools: help, and what is wrong with them."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import pytest

from pyros1.cli import registry
from pyros1.cli.main import entry
from pyros1.finding.packages import PackageIndex

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(call_main: Run) -> Run:
    return partial(call_main, entry, "pyros1", "topic_tools")


@pytest.mark.parametrize("tool", registry.verbs("topic_tools"))
def test_each_has_help_and_a_node(tool: str, run: Run) -> None:
    code, out, _ = run(tool, "--help")
    assert code == 0 and f"usage: {tool} " in out and "Examples:" in out
    assert PackageIndex({}, installs=[]).find_executable("topic_tools", tool)


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        (["relay"], 1, "usage: relay IN_TOPIC [OUT_TOPIC]"),
        (["drop", "/a", "1", "x"], 1, "Y must be a whole number, not 'x'"),
        (["drop", "/a", "1", "0"], 1, "Y must be at least 1"),
        (["throttle", "words", "/a", "1"], 1, "unknown limit 'words': use messages or bytes"),
        (["throttle", "messages", "/a", "0"], 1, "MSGS_PER_SEC must be greater than 0"),
        (["throttle", "messages", "/a", "nan"], 1, "MSGS_PER_SEC must be greater than 0"),
        (["throttle", "bytes", "/a", "10"], 1, "usage: throttle"),
        (["mux", "/a"], 1, "usage: mux"),
        (["mux_select", "mux"], 1, "usage: mux_select"),
        (["transform", "/a"], 2, "usage: transform"),
        (["reley"], 64, "did you mean 'relay'?"),
        ([], 64, "Tools:"),
    ],
)
def test_wrong_usage(words: list[str], code: int, text: str, run: Run) -> None:
    done = run(*words)
    assert done[0] == code and text in done[1] + done[2]
