"""`pyros1 console`: the log in the terminal."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from functools import partial
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1 import Time
from pyros1.cli.commands.console import format_row
from pyros1.cli.running import run_command
from pyros1.msgs.rosgraph_msgs.msg import Log

Run = Callable[..., tuple[int, str, str]]
SAID = [(1, "/driver", "tick"), (2, "/driver", "begins"), (4, "/driver", "Timeout of port 3"), (8, "/arm", "timeout")]


@pytest.fixture
def run(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, call_main: Any) -> Run:
    for key, value in environ.items():
        monkeypatch.setenv(key, value)
    monkeypatch.delenv("ROS_NAMESPACE", raising=False)
    return partial(call_main, partial(run_command, "console"))


@pytest.fixture
def speaker(make_node: Callable[..., Any]) -> Iterator[None]:
    """Says the same again and again, as soon as somebody listens."""
    publisher = make_node("speaker", rosout=False).advertise("/rosout", Log)
    ended = threading.Event()

    def speak() -> None:
        while not ended.is_set():
            for level, name, text in SAID:
                publisher.publish(Log(level=level, name=name, msg=text))
            ended.wait(0.05)

    thread = threading.Thread(target=speak)
    thread.start()
    yield
    ended.set()
    thread.join()


@pytest.mark.usefixtures("speaker")
@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), {1, 2, 3}),
        (("-l", "DEBUG"), {0, 1, 2, 3}),
        (("-l", "warn", "-n", "driver"), {2}),
        (("-n", "arm", "-n", "nobody"), {3}),
        (("-g", "timeout", "-g", r"port \d"), {2}),
        (("-x", "timeout"), {1}),
        (("-x", "/arm", "-l", "warn"), {2}),
    ],
)
def test_what_is_shown(run: Run, words: tuple[str, ...], said: set[int]) -> None:
    code, out, err = run("--json", "-c", 8, *words)
    assert (code, err) == (0, "")
    assert {json.loads(line)["text"] for line in out.splitlines()} == {SAID[number][2] for number in said}


def test_a_line() -> None:
    stamp = Time(12, 250_000_000)
    message: Any = SimpleNamespace(
        level=4,
        name="/n",
        msg="one\ntwo\n",
        file="/a/b/c.py",
        line=7,
        function="f",
        header=SimpleNamespace(stamp=stamp),
    )
    assert format_row(message) == "      12.250 WARN  /n: one\n    two  [c.py:7 f]"
    assert "\x1b[93mWARN \x1b[0m" in format_row(message, coloured=True)
    message.header.stamp = Time(1_700_000_000, 999_999_999)
    message.file, message.function, message.msg = "", "", "\x1b[2Jevil"
    assert format_row(message)[2:6:3] == "::" and format_row(message).partition(" ")[0].endswith(".999")
    assert "\x1b" not in format_row(message) and "[" not in format_row(message).partition("/n: ")[0]


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("-l", "wran"), "there is no level 'wran' (did you mean 'warn'?)"),
        (("-g", "["), "--grep needs a regular expression, not '['"),
        (("/driver",), "--node /driver"),
        (("-c", "0"), "--count"),
    ],
)
def test_mistakes(run: Run, words: tuple[str, ...], why: str) -> None:
    code, out, err = run(*words)
    assert (code, out) == (2, "") and why in err
