"""graph: nodes and connections as they are (L177)."""

from __future__ import annotations

import json
import shutil
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pyros1.cli.running import run_command
from pyros1.msgs.std_msgs.msg import String
from pyros1.msgs.std_srvs.srv import Empty

LOG_SERVICES = ("get_loggers", "set_logger_level")
Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, capsys: Any) -> Run:
    for key, value in environ.items():
        monkeypatch.setenv(key, value)
    return lambda *words: (run_command("graph", list(words)), *capsys.readouterr())


@pytest.fixture
def pair(make_node: Callable[..., Any]) -> None:
    """A publisher and a subscriber that are connected."""
    listener, talker = make_node("listener", rosout=False), make_node("talker", rosout=False)
    heard = threading.Event()
    listener.subscribe("chat", String, lambda message: heard.set())
    talker.advertise("chat", String, latch=True).publish("x")
    listener.advertise_service("empty", Empty, lambda request: {})
    assert heard.wait(10)


@pytest.mark.usefixtures("pair")
def test_text_json_and_dot_l177(run: Run) -> None:
    assert run("--once") == (
        0,
        "\n\nNodes:\n  /listener :\n    Inbound:\n      /talker\n    Outbound:\n"
        "  /talker :\n    Inbound:\n    Outbound:\n      /listener\nServices:\n  /empty\n"
        "  /listener/get_loggers\n  /listener/set_logger_level\n"
        "  /talker/get_loggers\n  /talker/set_logger_level\n",
        "",
    )
    assert json.loads(run("--json")[1]) == {
        "nodes": ["/listener", "/talker"],
        "edges": [{"topic": "/chat", "publisher": "/talker", "subscriber": "/listener"}],
        "services": ["/empty", *(f"/{node}/{name}" for node in ("listener", "talker") for name in LOG_SERVICES)],
        "silent": [],
    }
    assert run("--dot")[1].splitlines() == [
        "digraph system {",
        "  rankdir=LR;",
        '  "/listener";',
        '  "/talker";',
        '  "/talker" -> "/listener" [label="/chat"];',
        "}",
    ]


def test_dot_shows_what_is_missing_and_what_nobody_knows(
    run: Run, make_node: Callable[..., Any], master: Any, closed_port: int
) -> None:
    from pyros1.net.master_client import MasterClient

    talker, listener = make_node("talker", rosout=False), make_node("listener", rosout=False, log_level="fatal")
    talker.advertise("chat", String)
    listener.subscribe("chat", "std_msgs/Float64", lambda message: None)
    client = MasterClient("/gone", master.uri)
    client.register_subscriber("/chat", "std_msgs/String", f"http://localhost:{closed_port}/")
    client.close()
    lines = run("--dot")[1].splitlines()
    assert '  "/gone" [style=dashed];' in lines
    assert '  "/talker" -> "/gone" [label="/chat", style=dashed];' in lines
    assert '  "/talker" -> "/listener" [label="/chat", color=red, style=dashed];' in lines


@pytest.mark.usefixtures("pair")
def test_dot_in_a_file(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "graph.dot"
    assert run("--dot", str(file)) == (0, "", "")
    assert file.read_text() == run("--dot")[1]
    file.unlink()
    assert run_command("web", ["rxgraph", "-o", str(file)]) == 0
    assert '"/talker" -> "/listener"' in file.read_text()
    code, _, err = run("--dot", str(tmp_path / "no" / "graph.dot"))
    assert code == 1 and err.startswith("ERROR: cannot write ") and err.endswith("No such file or directory\n")


@pytest.mark.usefixtures("pair")
@pytest.mark.skipif(shutil.which("dot") is None, reason="needs Graphviz")
def test_a_drawing(run: Run, tmp_path: Path) -> None:
    assert run("--svg", str(tmp_path / "graph.svg"))[0] == 0
    assert "/talker" in (tmp_path / "graph.svg").read_text()
    code, _, err = run("--svg", str(tmp_path / "no" / "graph.svg"))
    assert code == 1 and "dot cannot draw" in err


def test_drawing_without_graphviz_says_what_is_missing(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shutil.which", lambda name: None)
    code, _, err = run("--svg", "x.svg")
    assert code == 1 and "Graphviz" in err


def test_a_dead_node_is_named(run: Run, master: Any, closed_port: int) -> None:
    from pyros1.net.master_client import MasterClient

    client = MasterClient("/gone", master.uri)
    client.register_publisher("/t", "std_msgs/String", f"http://localhost:{closed_port}/")
    client.close()
    code, out, err = run("--once")
    assert code == 0 and "  /gone :\n" in out and "WARNING: /gone does not answer" in err


def test_each_second_until_it_is_interrupted(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    pauses = []

    def pause(seconds: float) -> None:
        pauses.append(seconds)
        if len(pauses) == 3:
            raise KeyboardInterrupt

    monkeypatch.setattr("time.sleep", pause)
    code, out, _ = run()
    assert code == 0 and out == "\n\nNodes:\nServices:\n" * 3 and pauses == [1.0] * 3


def test_wrong_words_help_and_no_master(run: Run, monkeypatch: pytest.MonkeyPatch, closed_port: int) -> None:
    assert run("-h")[0] == 0 and "--dot" in run("--help")[1]
    assert run("x")[0] == 255 and run("--svg")[0] == 255
    monkeypatch.setenv("ROS_MASTER_URI", f"http://localhost:{closed_port}")
    assert run("--once")[0] == 1
    monkeypatch.setattr("sys.argv", ["rosgraph"])
    code, out, err = run()
    assert (code, out) == (0, "") and err.startswith("ERROR: Unable to communicate with master!\n")
    assert "--dot" not in run("-h")[1]
