"""context: finding the nodes of this process, and waits that end with the node."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.ground.errors import NodeError, NodeShutdownError
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.node.context import find_local_context

from ..parts import context_of, publication_of, subscription_of


def test_nodes_of_the_process_are_found_by_their_address(make_node: Any) -> None:
    a, b = make_node("a"), make_node("b")
    for node in (a, b):
        found = find_local_context(node.uri)
        assert found is not None and found.name == node.name
    assert find_local_context("http://localhost:1/") is None
    a.shutdown()
    assert find_local_context(a.uri) is None


def test_pauses_end_with_the_node(make_node: Any, in_thread: Any) -> None:
    node = make_node("a")
    context = context_of(node)
    context.pause(0.001)
    context.check_running()
    pausing = in_thread(context.pause, 30.0)
    node.shutdown()
    with pytest.raises(NodeShutdownError, match="/a is shutting down"):
        pausing.join()
    with pytest.raises(NodeShutdownError):
        context.check_running()


def test_a_forked_process_is_told_that_it_is_one(make_node: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    context = context_of(make_node("a"))
    context.check_process()
    with monkeypatch.context() as patch:
        patch.setattr("pyros1.node.context.os", SimpleNamespace(getpid=lambda: -1))
        with pytest.raises(NodeError, match="forked from that of /a"):
            context.check_process()


def test_waits_for_links_end_with_the_node(make_node: Any, in_thread: Any) -> None:
    node = make_node("a")
    publisher = node.advertise("t", Float64)
    subscriber = node.subscribe("u", Float64, print)
    publication, subscription = publication_of(node), subscription_of(node, "/u")
    waits = [in_thread(publisher.wait_for_subscribers), in_thread(subscriber.wait_for_publishers)]
    node.shutdown()
    assert [wait.join() for wait in waits] == [False, False]
    assert not publication.change_listeners and not subscription.change_listeners
