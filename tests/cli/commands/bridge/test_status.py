"""bridge status: the bridges of a master, and programs that only look like one."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from pyros1.cli.running import run_command
from pyros1.node import Node

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, call_main: Any) -> Run:
    for key, value in environ.items():
        monkeypatch.setenv(key, value)
    return partial(call_main, partial(run_command, "bridge"))


def test_without_a_bridge(run: Run, make_node: Callable[..., Node]) -> None:
    make_node("user")
    code, _, err = run("status")
    assert code == 1 and err.startswith("ERROR: no bridge is running on this master; start one with: pyros1 bridge")
    assert "pyros1 bridge ros2" in err
    assert run("status", "red")[0] == 2


@pytest.mark.parametrize("text", ["no JSON", "[" * 100_000, "{}", "[]", '{"site": {}}', '{"site": "a", "sites": 5}'])
def test_a_bridge_that_answers_nonsense(run: Run, make_node: Callable[..., Node], text: str) -> None:
    node = make_node("liar")
    node.advertise_service("~bridge_status", "std_srvs/Trigger", lambda _: (True, text))
    code, out, err = run("status")
    assert code == 1 and out == "" and err.startswith("ERROR: ") and "Traceback" not in err


def test_a_bridge_that_does_not_answer(run: Run, make_node: Callable[..., Node]) -> None:
    def refuse(_: object) -> None:
        raise RuntimeError("out of order")

    make_node("broken").advertise_service("~bridge_status", "std_srvs/Trigger", refuse)
    code, _, err = run("status")
    assert code == 1 and "ERROR: /broken did not return its status" in err and "out of order" in err


def test_a_bridge_that_hangs(run: Run, make_node: Callable[..., Node], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.doctor.bridge_status.TIMEOUT", 0.2)
    end = threading.Event()

    def hang(_: object) -> tuple[bool, str]:
        end.wait(10)
        return True, ""

    make_node("hanging").advertise_service("~bridge_status", "std_srvs/Trigger", hang)
    try:
        code, _, err = run("status")
    finally:
        end.set()
    assert code == 1 and "/hanging did not return its status: no response within" in err


STATUS = """{"site": "red", "link": "", "sites": [], "sent": [], "received": [], "problems": {}, "overflowed": 0,
"ignored": {}, "trouble": {}}"""


def test_json(run: Run, make_node: Callable[..., Node]) -> None:
    make_node("bridge").advertise_service("~bridge_status", "std_srvs/Trigger", lambda _: (True, STATUS))
    code, out, _ = run("status", "--json")
    assert code == 0 and json.loads(out) == [json.loads(STATUS)]


def test_watching_goes_on_until_it_is_interrupted(
    run: Run, make_node: Callable[..., Node], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pauses = []

    def pause(seconds: float) -> None:
        pauses.append(seconds)
        if len(pauses) == 1:
            make_node("bridge").advertise_service("~bridge_status", "std_srvs/Trigger", lambda _: (True, STATUS))
        if len(pauses) == 3:
            raise KeyboardInterrupt

    monkeypatch.setattr("pyros1.cli.commands.bridge.status.pause", pause)
    with pytest.raises(KeyboardInterrupt):
        run("status", "--watch")
    out, err = capsys.readouterr()
    assert err.startswith("ERROR: no bridge is running on this master") and pauses == [1.0] * 3
    assert out == 2 * "site red\n  no other site found yet\n"
