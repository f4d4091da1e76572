"""Command lines of the tools: help, and what is wrong with them."""

from __future__ import annotations

import pytest

from pyros1.cli.topic_tools import main
from pyros1.cli.topic_tools_usage import ABOUT
from pyros1.finding.packages import PackageIndex


@pytest.mark.parametrize("tool", ABOUT)
def test_each_has_help_and_a_node(tool: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([tool, "--help"]) == 0
    assert f"usage: {tool} " in capsys.readouterr().out
    assert PackageIndex({}, installs=[]).find_executable("topic_tools", tool)


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        (["relay"], 1, "usage: relay IN_TOPIC [OUT_TOPIC]"),
        (["drop", "/a", "1", "x"], 1, "Y must be a whole number, not 'x'"),
        (["drop", "/a", "1", "0"], 1, "Y must be at least 1"),
        (["throttle", "words", "/a", "1"], 1, "there is messages and bytes, not 'words'"),
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
def test_wrong_usage(words: list[str], code: int, text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words) == code
    captured = capsys.readouterr()
    assert text in captured.out + captured.err
