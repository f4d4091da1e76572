"""A process forked from a node's: it may end what it has a copy of, and the node goes on."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.ground.errors import NodeError
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.msgs.std_srvs.srv import Trigger

if not hasattr(os, "fork"):
    pytest.skip("this system has no fork", allow_module_level=True)


def in_child(action: Callable[[], object]) -> None:
    """Do something in a forked process, and wait for its end."""
    child = os.fork()
    if child == 0:
        signal.alarm(20)  # it has no threads that could end a wait
        code = 1
        try:
            action()
            code = 0
        finally:
            os._exit(code)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def test_what_a_child_unregisters_stays_registered(make_node: Any, collect: Any) -> None:
    node, got = make_node("a"), collect()
    publisher, subscriber = node.advertise("t", Float64), node.subscribe("t", Float64, got)
    service = node.advertise_service("s", Trigger, lambda _: (True, "here"))

    def end_all() -> None:
        publisher.unregister()
        subscriber.unregister()
        service.shutdown()

    in_child(end_all)
    publishers, subscribers, services = (dict(part) for part in node.master.get_system_state())
    assert publishers["/t"] == subscribers["/t"] == services["/s"] == ["/a"]
    publisher.publish(1)
    assert got.wait(1) and node.service("s", Trigger)().message == "here"


@pytest.mark.parametrize(
    "create",
    [
        lambda node: node.advertise("t", Float64),
        lambda node: node.subscribe("t", Float64, print),
        lambda node: node.advertise_service("s", Trigger, print),
    ],
    ids=["advertise", "subscribe", "advertise_service"],
)
def test_a_child_cannot_add_topics_and_services(make_node: Any, create: Any) -> None:
    node = make_node("a")

    def attempt() -> None:
        with pytest.raises(NodeError, match="this process was forked from that of /a"):
            create(node)

    in_child(attempt)
