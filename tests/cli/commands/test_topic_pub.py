"""``topic pub``: how often messages of a file are published."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from pyros1.cli.main import entry
from pyros1.graph import Graph
from pyros1.msgs.std_msgs.msg import Empty, String

ONE, TWO = "data: a\n", "data: a\n---\ndata: b\n"


@pytest.fixture
def run(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, call_main: Any) -> Any:
    for key, value in environ.items():
        monkeypatch.setenv(key, value)
    monkeypatch.delenv("ROS_NAMESPACE", raising=False)
    monkeypatch.setattr("pyros1.cli.commands.topic.pub.HOLD_SECONDS", 1.5)
    return partial(call_main, entry, "pyros1", "topic", "pub")


@pytest.fixture
def publish(run: Any, make_node: Callable[..., Any], tmp_path: Path) -> Callable[..., tuple[list[Any], str]]:
    """Return a function that runs `topic pub` with a file, and returns messages and output.

    The command's node is told to end when as many messages have come as are asked for."""

    def publish(text: str, options: str, most: int, kind: Any = String) -> tuple[list[Any], str]:
        file = tmp_path / "messages.yaml"
        file.write_text(text)
        heard: list[Any] = []
        node = make_node("listener", rosout=False)
        graph = Graph(node.master)

        def hear(message: Any) -> None:
            heard.append(getattr(message, "data", None))
            if len(heard) == most:
                with closing(graph.node_api(graph.node_uri(message._connection_header["callerid"]))) as publisher:
                    publisher.shutdown("that is enough")

        node.subscribe("said", kind, hear)
        _, out, _ = run(*options.split(), "-f", str(file), "/said", kind._type)
        return heard, out

    return publish


@pytest.mark.parametrize("text", [ONE, "---\n" + ONE, ONE + "---\n", "a\n", '{"data": "a"}\n'])
@pytest.mark.parametrize("options", ["", "-r 100", "-l -r 100", "-s -r 100"])
def test_the_only_message_of_a_file_is_repeated(publish: Any, text: str, options: str) -> None:
    heard, out = publish(text, options, most=4)
    assert heard[:4] == ["a"] * 4
    assert out == "Got one message and a rate, publishing repeatedly\n"


@pytest.mark.parametrize(
    ("text", "options", "most", "expected"),
    [
        (ONE, "-1", 9, ["a"]),
        (ONE, "-l -1", 9, ["a"]),
        (ONE, "-l", 1, ["a"]),
        (TWO, "", 9, ["a", "b"]),
        (TWO, "-r 100", 9, ["a", "b"]),
        (TWO, "-l -r 100", 9, ["a", "b"]),
        (TWO, "-l", 1, ["a"]),
        (TWO, "-1", 9, ["a"]),
        ("", "", 9, []),
    ],
)
def test_other_files_are_published_once(publish: Any, text: str, options: str, most: int, expected: list[str]) -> None:
    assert publish(text, options, most)[0] == expected


def test_a_file_for_a_type_without_fields_is_not_read(publish: Any) -> None:
    assert publish("data: a\n", "-r 100", most=3, kind=Empty)[0][:3] == [None] * 3


def test_a_wrong_message_is_not_repeated(run: Any, tmp_path: Path) -> None:
    (tmp_path / "wrong.yaml").write_text("date: a\n")
    code, _, error = run("-f", str(tmp_path / "wrong.yaml"), "/said", "std_msgs/String")
    assert code == 1 and "No field name [date]" in error
