"""log: levels and messages of running nodes (L176)."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from functools import partial
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1 import Time
from pyros1.cli.commands.log import echo
from pyros1.cli.running import run_command
from pyros1.msgs.rosgraph_msgs.msg import Log

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, call_main: Any) -> Run:
    for key, value in environ.items():
        monkeypatch.setenv(key, value)
    monkeypatch.delenv("ROS_NAMESPACE", raising=False)
    return partial(call_main, partial(run_command, "log"))


def test_levels_are_listed_read_and_set_l176(run: Run, make_node: Callable[..., Any]) -> None:
    make_node("talker")
    assert "rosout" in run("list", "talker")[1].split()
    assert run("set", "/talker", "rosout", "WARN") == (0, "", "")
    assert run("get", "/talker", "rosout")[1].strip().lower() == "warn"
    assert {"logger": "rosout", "level": run("get", "/talker", "rosout")[1].strip()} in json.loads(
        run("list", "--json", "/talker")[1]
    )


def test_what_is_misspelt_is_named(run: Run, make_node: Callable[..., Any]) -> None:
    make_node("talker")
    assert run("set", "/talker", "rosuot", "warn") == (
        2,
        "",
        "pyros1 log: error: node /talker does not contain logger rosuot (did you mean 'rosout'?)\n",
    )
    code, _, err = run("set", "/talker", "rosout", "wran")
    assert code == 2 and "invalid level (did you mean 'warn'?)" in err
    code, _, err = run("list", "/talkr")
    assert code == 1 and "node '/talkr' doesn't exist" in err and "did you mean '/talker'?" in err
    assert run("get", "/talker")[0] == 2 and run("list")[0] == 2 and run("list", "a", "b")[0] == 2
    assert run()[0] == 64 and "pyros1 log echo" in run("nonsense")[1]


@pytest.mark.parametrize("topic", ["/rosout", "/rosout_agg"])
def test_echo_prints_what_comes_from_the_aggregator_if_there_is_one(
    run: Run, make_node: Callable[..., Any], topic: str
) -> None:
    node = make_node("talker", rosout=False)
    message = Log(level=8, name="/talker", msg="bad", file="a.py", line=3, function="f")
    message.header.stamp = Time(1, 500_000_000)
    node.advertise(topic, Log, latch=True).publish(message)
    assert run("echo", "-1") == (0, "[ ERROR ] [/talker]: bad\n", "")
    assert run("echo", "-1", "-v", "talk", "-l", "error") == (
        0,
        "[ ERROR ] [/talker]: bad\n          [1970-01-01 00:00:01.500000+00:00 (1.500000)] [f]: a.py:3\n",
        "",
    )
    assert json.loads(run("echo", "-1", "--json", "--topic", topic)[1])["text"] == "bad"


@pytest.mark.parametrize("words", [[], ["-l", "warn"]])
def test_echo_says_once_that_it_hides_something(run: Run, make_node: Callable[..., Any], words: list[str]) -> None:
    publisher = make_node("talker", rosout=False).advertise("/rosout", Log)

    def publish() -> None:
        publisher.wait_for_subscribers(timeout=10)
        for level in (2, 1, 2, 8):
            publisher.publish(Log(level=level, name="/talker", msg="text"))

    thread = threading.Thread(target=publish)
    thread.start()
    code, out, err = run("echo", "-1", *words)
    thread.join()
    assert (code, out) == (0, "[ ERROR ] [/talker]: text\n")
    assert err == ("" if words else "pyros1 log echo: messages below warn are hidden: use -l info to see them\n")


def test_echo_refuses_what_it_does_not_understand(run: Run) -> None:
    code, _, err = run("echo", "[")
    assert code == 2 and "'[' is not a regular expression" in err
    assert run("echo", "-l", "loud")[0] == 2
    assert run("echo", "a", "b")[0] == 2


def test_colours_only_on_request() -> None:
    message: Any = SimpleNamespace(level=16, name="/n", msg="m")
    assert echo.format_message(message) == "[ FATAL ] [/n]: m"
    assert echo.format_message(message, coloured=True) == "[ \x1b[95mFATAL\x1b[0m ] [\x1b[1m/n\x1b[0m]: m"
    assert echo.format_message(SimpleNamespace(level=3, name="/n", msg="m")) == "[ 3     ] [/n]: m"


def test_without_a_master(run: Run, monkeypatch: pytest.MonkeyPatch, closed_port: int) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", f"http://localhost:{closed_port}")
    for words in (["echo"], ["list", "x"]):
        code, out, err = run(*words)
        assert (code, out) == (1, "") and err.startswith("ERROR: Unable to communicate with master!\n")
