"""version: of packages, of the distribution, of pyros1 (L180)."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from pyros1 import __version__
from pyros1.cli.commands import version
from pyros1.cli.running import run_command

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call_main: Any) -> Run:
    for name, text in {"one": "<version>1.2.3</version>", "two": "<!-- <version>9</version> -->"}.items():
        (tmp_path / name).mkdir()
        (tmp_path / name / "package.xml").write_text(f"<package><name>{name}</name>{text}</package>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    monkeypatch.setenv("ROS_DISTRO", "noetic")
    return partial(call_main, partial(run_command, "version"))


def test_versions_l180(run: Run) -> None:
    assert run("one") == (0, "1.2.3\n", "")
    assert run("-s", "one") == (0, "1.2.3", "")
    assert run("two") == (0, "<unversioned>\n", "")
    assert run("-d") == (0, "noetic\n", "") and run("-sd") == (0, "noetic", "")
    assert run() == (0, f"pyros1 {__version__}\n", "")
    assert run("onee") == (
        1,
        "Cannot locate [onee]\n",
        "pyros1 version: unknown package onee (did you mean 'one'?)\n",
    )


def test_all_packages_and_json(run: Run) -> None:
    lines = run("-a")[1].splitlines()
    assert "one: 1.2.3" in lines and "two: <unversioned>" in lines
    names = [line.partition(":")[0] for line in lines]
    assert names == sorted(names)
    assert json.loads(run("-a", "--json")[1])["one"] == "1.2.3"
    assert json.loads(run("one", "--json")[1]) == "1.2.3"


@pytest.mark.parametrize("words", [("-a", "-d"), ("one", "-d"), ("one", "two"), ("-x",)])
def test_what_does_not_fit_together_is_refused(run: Run, words: tuple[str, ...]) -> None:
    code, out, err = run(*words)
    assert code == 2 and out == "" and "usage: pyros1 version" in err


def test_under_the_stock_name_something_must_be_asked(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", ["/usr/bin/rosversion"])
    code, _, err = run()
    assert code == 2 and "one of the arguments package -d/--distro -a/--all is required" in err


def test_the_distribution_is_that_of_the_installation(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Path, "glob", lambda self, pattern: [Path("/opt/ros/melodic/share/roslib")])
    assert version.distribution({}) == "melodic"
    assert version.distribution({"ROS_DISTRO": "noetic"}) == "noetic"
