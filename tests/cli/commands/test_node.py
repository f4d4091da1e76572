"""node list --check: which nodes are alive.

Feature: which nodes are alive, hanging or dead -- `pyros1 node list --check`, `pyros1 wtf`
"""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.cli.main import entry
from pyros1.net.master_client import MasterClient

from ...parts import context_of


@pytest.fixture
def listed(
    environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., tuple[int, str]]:
    """Return a function that runs ``node list`` and returns its exit code and what it printed."""
    for name, value in environ.items():
        monkeypatch.setenv(name, value)

    def run(*words: str) -> tuple[int, str]:
        return entry(["pyros1", "node", "list", *words]), capsys.readouterr().out

    return run


def test_the_living_the_dead_and_the_unreachable(
    listed: Callable[..., tuple[int, str]], make_node: Any, environ: dict[str, str], closed_port: int
) -> None:
    node = make_node("alive")
    assert listed("--check") == (0, "/alive  alive\n")
    client = MasterClient("/long_dead", environ["ROS_MASTER_URI"])
    client.register_publisher("/t", "std_msgs/String", f"http://localhost:{closed_port}/")
    client.caller_id = "/nowhere"
    client.register_publisher("/t", "std_msgs/String", "http://host.invalid:1/")
    client.close()
    code, out = listed("--check")
    alive, dead, nowhere = out.splitlines()
    assert code == 1 and alive.split() == ["/alive", "alive"]
    assert dead == "/long_dead  dead: its port is closed"
    assert nowhere.startswith("/nowhere    unreachable: ") and "host.invalid" in nowhere
    code, out = listed("--check", "--json", "/alive")
    assert (code, json.loads(out)) == (0, [{"node": "/alive", "uri": node.uri, "state": "alive", "reason": ""}])
    code, out = listed("--check", "--json")
    assert code == 1 and [each["state"] for each in json.loads(out)] == ["alive", "dead", "unreachable"]
    assert listed() == (0, "/alive\n/long_dead\n/nowhere\n"), "stock's output stays"


@pytest.mark.parametrize("command", ["node ping -a", "node machine", "topic list --host", "node kill -a"])
def test_a_node_with_a_wrong_address_hides_no_other(
    make_node: Any,
    environ: dict[str, str],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    command: str,
) -> None:
    """Anybody can register one, as with a stock master."""
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    client = MasterClient("/bad", environ["ROS_MASTER_URI"])
    client.register_publisher("/t", "std_msgs/String", "http://a b:1/")
    client.close()
    node = make_node("good")
    node.advertise("t", "std_msgs/String")
    context = context_of(node)
    entry(["pyros1", *command.split()])
    out, err = capsys.readouterr()
    if command == "node kill -a":
        assert context.stopping.wait(10)
    else:
        assert {"node ping -a": f"reply from {node.uri}", "node machine": "localhost"}.get(command, "/t") in out
    assert "/bad" in out + err and "'http://a b:1/'" in err
