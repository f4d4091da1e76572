"""master.recovery: which nodes of a master that was killed are still there."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from pyros1.ground.errors import Error, ProtocolError, TransportError
from pyros1.master import recovery
from pyros1.master.recovery import Recovery
from pyros1.master.registry import RegisteredNode

OnResponse = Callable[[Any, Error | None], None]


class Desk:
    """Stands for the loop and the caller: the test answers, and lets time pass."""

    def __init__(self, *nodes: RegisteredNode) -> None:
        self.asked: list[tuple[str, str, OnResponse]] = []
        self.later: list[Callable[[], None]] = []
        self.gone: list[tuple[str, str]] = []
        self.done: list[int] = []
        self.recovery = Recovery(
            self,  # type: ignore[arg-type]
            self,  # type: ignore[arg-type]
            nodes,
            lambda node, reason: self.gone.append((node.name, reason)),
            self.done.append,
        )
        self.recovery.start()

    def call(self, api: str, method: str, params: Any, on_response: OnResponse) -> None:
        if not api.startswith("http://"):
            raise ProtocolError(f"{api} is no address")
        self.asked.append((api, method, on_response))

    def call_later(self, delay: float, function: Callable[..., None], *args: Any) -> None:
        self.later.append(lambda: function(*args))

    def answer(self, value: Any = None, error: Error | None = None) -> None:
        self.asked.pop(0)[2](value, error)


def node(name: str, api: str = "http://host:1/", topics: tuple[str, ...] = ()) -> RegisteredNode:
    return RegisteredNode(name, api, frozenset(topics), frozenset())


def test_without_nodes_it_is_done_at_once() -> None:
    assert Desk().done == [0]


def test_it_is_done_when_the_last_node_has_answered() -> None:
    desk = Desk(node("/a"), node("/b"))
    desk.answer(5)
    assert not desk.done
    desk.answer(5)
    assert (desk.done, desk.gone) == ([2], [])


def test_a_node_with_an_address_that_is_none_is_gone() -> None:
    desk = Desk(node("/a", "nowhere"))
    assert desk.gone == [("/a", "nowhere is no address")] and desk.done == [0]


def test_a_program_that_does_not_speak_xml_rpc_is_no_node() -> None:
    desk = Desk(node("/a"))
    desk.answer(error=ProtocolError("this is SSH"))
    assert desk.gone == [("/a", "another program is using its port: this is SSH")] and desk.done == [0]


def test_a_silent_node_is_asked_again_until_the_deadline(monkeypatch: pytest.MonkeyPatch) -> None:
    desk = Desk(node("/a"))
    desk.answer(error=TransportError("no route"))
    assert not desk.gone and not desk.asked
    desk.later.pop()()
    assert [method for _, method, _ in desk.asked] == ["getPid"]
    now = recovery.time.monotonic()
    monkeypatch.setattr(recovery.time, "monotonic", lambda: now + recovery.ANSWER_TIMEOUT_S + 1)
    desk.answer(error=TransportError("no route"))
    assert desk.gone == [("/a", f"no answer within {recovery.ANSWER_TIMEOUT_S:.0f} s: no route")]
    assert desk.done == [0] and not desk.later


def test_after_the_end_nobody_is_asked_and_no_answer_counts() -> None:
    desk = Desk(node("/a"), node("/b"))
    desk.answer(error=TransportError("no route"))
    desk.recovery.close()
    desk.later.pop()()
    assert len(desk.asked) == 1, "the second node, that was asked before"
    desk.answer(error=ProtocolError("this is SSH"))
    assert not desk.done and not desk.gone
