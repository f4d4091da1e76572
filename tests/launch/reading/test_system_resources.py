"""launch.reading.system_resources: the commands that launch files run."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from pyros1.ground.errors import LaunchError
from pyros1.launch.reading.system_resources import make_resources, run_command


def test_the_output_is_that_of_the_command() -> None:
    assert run_command([sys.executable, "-c", "print('one\\ntwo')"]) == "one\ntwo\n"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["/no/such/command", "x"], r"no such command \[\['/no/such/command', 'x'\]\]\."),
        (["/"], r"command \[\['/'\]\] failed: .*Permission denied"),
        (["sh", "-c", "echo half; exit 3"], r"command \[.*\] returned with code \[3\]\."),
        (["printf", r"\377"], r"command \[.*\]: its output is not UTF-8 text: "),
    ],
)
def test_commands_without_a_usable_output(words: list[str], said: str) -> None:
    with pytest.raises(LaunchError, match=said):
        run_command(words)


def test_a_command_that_does_not_end_is_killed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.launch.reading.system_resources.COMMAND_TIMEOUT_S", 0.01)
    with pytest.raises(LaunchError, match=r"failed: it did not exit within 0\.01 seconds"):
        run_command(["sleep", "100"])


def test_the_environment_is_that_of_the_moment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    resources = make_resources()
    monkeypatch.setenv("LATER", "yes")
    assert resources.environ["LATER"] == "yes"
    assert resources.make_unique_suffix() != resources.make_unique_suffix()
