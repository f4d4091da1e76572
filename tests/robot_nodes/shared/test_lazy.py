from __future__ import annotations

from collections.abc import Callable
from queue import Queue
from typing import Any

from pyros1.msgs.std_msgs.msg import Float64
from pyros1.robot_nodes.shared.lazy import LazyInputs

PATIENCE = 20.0


def test_inputs_are_open_while_the_output_has_subscribers(make_node: Callable[..., Any]) -> None:
    events: Queue[str] = Queue()

    def open_inputs() -> Callable[[], object]:
        events.put("open")
        return lambda: events.put("close")

    node, user = make_node("converter"), make_node("user")
    output = node.advertise("out", Float64)
    lazy = LazyInputs(output, open_inputs)
    for _ in range(2):
        first = user.subscribe("/out", Float64, lambda message: None)
        assert events.get(timeout=PATIENCE) == "open"
        other = make_node("other").subscribe("/out", Float64, lambda message: None)
        assert output.wait_for_subscribers(2, PATIENCE)
        first.unregister()
        other.unregister()
        assert events.get(timeout=PATIENCE) == "close"
    assert events.empty()
    del lazy
