from __future__ import annotations

from collections.abc import Callable
from queue import Queue
from types import SimpleNamespace
from typing import Any, cast

from pyros1.msgs.std_msgs.msg import Float64
from pyros1.robot_nodes.shared.lazy import LazyInputs

PATIENCE = 20.0


def test_inputs_are_open_while_the_output_has_subscribers(make_node: Callable[..., Any]) -> None:
    events: Queue[str] = Queue()

    def open_inputs() -> list[Callable[[], object]]:
        events.put("open")
        return [lambda: events.put("close")]

    node, user, another = make_node("converter"), make_node("user"), make_node("another")
    output = node.advertise("out", Float64)
    lazy = LazyInputs([output], open_inputs)
    for _ in range(2):
        first = user.subscribe("/out", Float64, lambda message: None)
        assert events.get(timeout=PATIENCE) == "open"
        other = another.subscribe("/out", Float64, lambda message: None)
        assert output.wait_for_subscribers(2, PATIENCE)
        first.unregister()
        other.unregister()
        assert events.get(timeout=PATIENCE) == "close"
    assert events.empty()
    del lazy


def test_a_subscriber_that_is_not_announced_any_more_keeps_no_inputs_open() -> None:
    """Who has come and gone before the publisher's listeners are called is announced to nobody."""
    events: list[str] = []

    def open_inputs() -> list[Callable[[], object]]:
        events.append("open")
        return [lambda: events.append("close")]

    output: Any = FakePublisher()
    lazy = LazyInputs([output], open_inputs)
    output.joined(SimpleNamespace(others=0))
    output.num_connections = 1  # another one, which is about to go
    output.left(SimpleNamespace(others=0))
    assert events == ["open", "close"]
    output.joined(SimpleNamespace(others=0))
    output.joined(SimpleNamespace(others=1))
    output.left(SimpleNamespace(others=1))
    output.left(SimpleNamespace(others=0))
    assert events == ["open", "close"] * 2
    del lazy


def test_several_outputs() -> None:
    events: list[str] = []

    def open_inputs() -> list[Callable[[], object]]:
        events.append("open")
        return [lambda: events.append("close"), lambda: events.append("close the other one")]

    first, second = outputs = [FakePublisher(), FakePublisher()]
    lazy = LazyInputs(cast("Any", outputs), open_inputs)
    first.joined(SimpleNamespace(others=0))
    second.joined(SimpleNamespace(others=0))
    first.left(SimpleNamespace(others=0))
    assert events == ["open"]
    second.left(SimpleNamespace(others=0))
    assert events == ["open", "close", "close the other one"]
    del lazy


class FakePublisher:
    """A publisher whose subscribers the test lets come and go."""

    num_connections = 0

    def watch(self, joined: Any, left: Any) -> None:
        self.joined, self.left = joined, left
