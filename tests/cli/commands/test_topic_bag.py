"""``topic echo -b`` and ``topic list -b``: the names of a bag's topics."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import pyros1.bag
from pyros1.cli.main import entry
from pyros1.ground.timing import Time
from pyros1.msgs import load_message

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def bag(tmp_path: Path) -> str:
    """A bag with topics with and without a slash in front."""
    text = load_message("std_msgs/String")
    path = tmp_path / "names.bag"
    with pyros1.bag.open(path, "w") as bag:
        for number, topic in enumerate(["chatter", "/chatter", "ns/x", "/robot/chatter"]):
            bag.write(topic, text(topic), Time(1000 + number))
    return str(path)


@pytest.fixture
def run(call_main: Any, environ: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> Run:
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    return lambda *words: call_main(entry, "pyros1", "topic", *words)


@pytest.mark.parametrize(
    ("namespace", "name", "found"),
    [
        ("", "chatter", ["chatter", "/chatter"]),
        ("", "/chatter", ["chatter", "/chatter"]),
        ("", "/ns/x/data", ["ns/x"]),
        ("", "ns/x", ["ns/x"]),
        ("/robot", "chatter", ["chatter", "/robot/chatter"]),
        ("/robot", "/chatter", ["/chatter"]),
    ],
)
def test_echo(run: Run, bag: str, monkeypatch: pytest.MonkeyPatch, namespace: str, name: str, found: list[str]) -> None:
    monkeypatch.setenv("ROS_NAMESPACE", namespace)
    code, out, err = run("echo", "-b", bag, "-p", name)
    printed = [line.partition(",")[2] for line in out.splitlines() if not line.startswith("%")]
    assert (code, printed, err) == (0, found, "")


def test_a_filter_sees_the_full_name(run: Run, bag: str) -> None:
    assert run("echo", "-b", bag, "-a", "-p", "--filter", "topic == '/ns/x'")[1].endswith(",ns/x\n")


def test_list(run: Run, bag: str) -> None:
    assert run("list", "-b", bag)[1].split() == ["chatter", "/chatter", "ns/x", "/robot/chatter"]
    for name in ("chatter", "/chatter"):
        below = json.loads(run("list", "-b", bag, "--json", name)[1])
        assert (below["topics"], below["messages"]) == (["/chatter", "chatter"], 2)


def test_a_topic_that_is_not_there(run: Run, bag: str) -> None:
    assert "did you mean '/ns/x'?" in run("echo", "-b", bag, "/ns/xx")[2]
    assert "did you mean '/ns/x'?" in run("list", "-b", bag, "/ns/xx")[2]


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("--offset", "-b", "BAG", "chatter"), "offset time option is not valid with bag files"),
        (("-a",), "Display all option is only valid when echoing from bag files"),
        (("-b", "BAG"), "topic must be specified"),
        (("-b", "BAG", "chatter", "ns/x"), "you may only specify one input topic"),
        (("-b", "BAG", "chatter", "-n", "few"), "COUNT must be an integer"),
        (("-b", "BAG", "chatter", "-w", "-1"), "Fixed width for numeric values must be at least 2"),
    ],
)
def test_options_of_echo_that_do_not_go_together(run: Run, bag: str, words: tuple[str, ...], reason: str) -> None:
    code, out, err = run("echo", *(bag if word == "BAG" else word for word in words))
    assert (code, out) == (2, "") and reason in err
