"""A signal handler that raises while a node waits for its master: nothing remains half registered."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from pyros1.msgs.std_msgs.msg import Float64
from pyros1.msgs.std_srvs.srv import Trigger
from pyros1.net.master_client import MasterClient
from pyros1.node.registrar import Registrar

from ..parts import context_of


class Interruption(BaseException):
    """As KeyboardInterrupt."""


def advertise(node: Any) -> Any:
    return node.advertise("t", Float64)


def subscribe(node: Any) -> Any:
    return node.subscribe("t", Float64, print)


def advertise_service(node: Any) -> Any:
    return node.advertise_service("t", Trigger, lambda _: (True, ""))


def interrupt(name: str, after: bool) -> None:
    """Let the next call of a registrar's method raise at once, or when its result is waited for."""
    original: Callable[..., Callable[[], Any]] = getattr(Registrar, name)

    def begin(registrar: Registrar, *args: str) -> Callable[[], Any]:
        patch.undo()
        if not after:
            raise Interruption
        wait = original(registrar, *args)

        def wait_and_raise() -> Any:
            wait()
            raise Interruption

        return wait_and_raise

    patch = pytest.MonkeyPatch()
    patch.setattr(Registrar, name, begin)


def registered(node: Any) -> set[str]:
    """Return the kinds of what the master has of the name /t."""
    kinds = zip(("pub", "sub", "srv"), node.master.get_system_state(), strict=True)
    return {kind for kind, entries in kinds if "/t" in [name for name, _ in entries]}


def held(node: Any) -> list[str]:
    """Return the names of the topics and services that a node has."""
    context = context_of(node)
    return [name for kind in (context.publications, context.subscriptions, context.services) for name in kind]


@pytest.mark.parametrize("register", [advertise, subscribe, advertise_service])
@pytest.mark.parametrize("after", [False, True])
def test_what_was_interrupted_can_be_registered_again(make_node: Any, register: Any, after: bool) -> None:
    node = make_node("node", rosout=False)
    interrupt("begin_register", after)
    with pytest.raises(Interruption):
        register(node)
    assert "/t" not in held(node)
    with register(node):
        assert len(registered(node)) == 1 and held(node).count("/t") == 1
    assert not registered(node) and "/t" not in held(node)


@pytest.mark.parametrize("register", [advertise, subscribe])
def test_a_topic_whose_registration_was_interrupted_is_not_left_with_the_master(
    make_node: Any, until: Any, register: Any
) -> None:
    node = make_node("node")
    interrupt("begin_register", True)
    with pytest.raises(Interruption):
        register(node)
    until(lambda: not registered(node))


@pytest.mark.parametrize("register", [advertise, subscribe])
@pytest.mark.parametrize("after", [False, True])
def test_links_end_although_unregistering_was_interrupted(
    make_node: Any, transport: str, until: Any, register: Any, after: bool
) -> None:
    node, other = make_node("node"), make_node("other")
    handle = register(node)
    peer = (subscribe if register is advertise else advertise)(other)
    until(lambda: handle.num_connections and peer.num_connections)
    interrupt("begin_unregister", after)
    with pytest.raises(Interruption):
        handle.unregister()
    assert "/t" not in held(node)
    until(lambda: not peer.num_connections)


def test_a_second_subscriber_that_cannot_be_added_leaves_the_first_one(make_node: Any, collect: Any) -> None:
    node, got = make_node("node"), collect()
    subscriber = node.subscribe("t", Float64, got)
    with pytest.raises(Exception, match="already subscribes to /t as std_msgs/Float64"):
        node.subscribe("t", "std_msgs/String", print)
    publisher = node.advertise("t", Float64)
    assert subscriber.wait_for_publishers(timeout=20)
    publisher.publish(1)
    got.wait(1)
    assert registered(node) == {"pub", "sub"}


@pytest.mark.parametrize("answer", [5, ["http://localhost:1/", 7]], ids=str)
def test_a_list_of_publishers_that_is_none_is_told(
    make_node: Any, watch_log: Any, monkeypatch: pytest.MonkeyPatch, answer: Any
) -> None:
    node = make_node("node")
    log = watch_log(node)
    multicall = MasterClient.multicall

    def answer_oddly(client: MasterClient, calls: Any) -> list[Any]:
        values = multicall(client, calls)
        return [answer if call[0] == "registerSubscriber" else value for call, value in zip(calls, values, strict=True)]

    with monkeypatch.context() as patch:
        patch.setattr(MasterClient, "multicall", answer_oddly)
        node.subscribe("t", Float64, print)
    log.saw(f"the master returned an invalid list of publishers of /t: {answer!r}")
