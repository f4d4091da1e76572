"""Services of clients while the master is slow."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.msgs.std_srvs.srv import SetBool, Trigger
from pyros1.web.client_services import ClientServices

PATIENCE = 20.0


class SlowNode:
    """A node whose master answers about ``/slow`` only when it may: stands for `Node`.

    Attributes:
        called: set when the master has been called about it.
        may_answer: set when the master may answer.
        handlers: the function that answers each service.
    """

    def __init__(self) -> None:
        self.called, self.may_answer = threading.Event(), threading.Event()
        self.handlers: dict[str, Callable[[Any], Any]] = {}
        self.master = SimpleNamespace(lookup_service=self._look_up)

    def _call(self, name: str) -> None:
        if name == "/slow":
            self.called.set()
            assert self.may_answer.wait(PATIENCE)

    def _look_up(self, name: str) -> str:
        self._call(name)
        return "rosrpc://here:1"

    def advertise_service(self, name: str, cls: Any, handler: Callable[[Any], Any]) -> Any:
        assert name not in self.handlers
        self.handlers[name] = handler
        self._call(name)

        def shutdown() -> None:
            self._call(name)
            del self.handlers[name]

        return SimpleNamespace(uri="rosrpc://here:1", shutdown=shutdown)


@pytest.mark.parametrize("change", ["new", "again", "other type", "end"])
def test_a_slow_master_delays_no_other_service(change: str) -> None:
    node: Any = SlowNode()
    services = ClientServices(lambda: node)
    end = services.provide("/quick", Trigger, lambda request: "first")
    node.may_answer.set()
    if change != "new":
        end_slow = services.provide("/slow", Trigger, lambda request: "first")
        node.called.clear()
    node.may_answer.clear()
    with ThreadPoolExecutor(3) as threads:
        try:
            slow = threads.submit(
                end_slow
                if change == "end"
                else lambda: services.provide(
                    "/slow", SetBool if change == "other type" else Trigger, lambda request: "second"
                )
            )
            assert node.called.wait(PATIENCE)
            threads.submit(services.provide, "/quick", Trigger, lambda request: "second").result(PATIENCE)
            threads.submit(end).result(PATIENCE)  # of the first, which has it no more
            assert node.handlers["/quick"](None) == "second"
            threads.submit(services.provide, "/third", Trigger, lambda request: "third").result(PATIENCE)()
            assert not slow.done()
        finally:
            node.may_answer.set()
        slow.result(PATIENCE)
    if change == "end":
        assert "/slow" not in node.handlers
    else:
        assert node.handlers["/slow"](None) == "second"
    assert "/third" not in node.handlers


def test_clients_that_provide_one_service_at_the_same_time_take_turns() -> None:
    node: Any = SlowNode()
    services = ClientServices(lambda: node)
    with ThreadPoolExecutor(2) as threads:
        try:
            first = threads.submit(services.provide, "/slow", Trigger, lambda request: "first")
            assert node.called.wait(PATIENCE)
            second = threads.submit(services.provide, "/slow", Trigger, lambda request: "second")
        finally:
            node.may_answer.set()
        end, end_second = first.result(PATIENCE), second.result(PATIENCE)
    end()
    assert node.handlers["/slow"](None) == "second"
    end_second()
    assert not node.handlers
