"""The topics that a bridge publishes: what is kept of other sites' latched messages."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.bridge import bridge_publishers as module
from pyros1.bridge.bridge_publishers import BridgePublishers
from pyros1.bridge.exchange.actions import Advertise, Forget, Publish, Source
from pyros1.bridge.names import SharedName
from pyros1.node import Node

MakeNode = Callable[..., Node]
TOPIC = SharedName("red", "/a")
MD5 = "992ce8a1687cec8c8bd883ec73ca41d1"


def advertise(local: str) -> Advertise:
    return Advertise(local, "std_msgs/String", MD5, "string data\n", True)


def text(local: str, data: str, number: int = 1, site: str = "red") -> Publish:
    return Publish(local, Source(site, TOPIC, number), len(data).to_bytes(4, "little") + data.encode(), True)


def kept(node: Node, local: str, count: int) -> list[str]:
    """Return the latched messages of a topic, of which there must be so many."""
    messages: queue.Queue[Any] = queue.Queue()
    with node.subscribe(local, "std_msgs/String", messages.put):
        found = sorted(messages.get(timeout=20).data[:3] for _ in range(count))
        with pytest.raises(queue.Empty):
            messages.get(timeout=0.2)
    return found


def test_the_latched_messages_of_a_site_are_bounded(make_node: MakeNode, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "LATCHED_BYTES", 40)
    monkeypatch.setattr(module, "MESSAGE_COST", 0)
    publishing, node = BridgePublishers(make_node("bridge"), "base"), make_node("user")
    for local in ("/red/a", "/red/b", "/blue/a"):
        publishing.advertise(advertise(local))
    publishing.publish(text("/blue/a", "old", site="blue"))
    for number in range(100):
        publishing.publish(text("/red/a", f"a{number:02}", number))
    assert publishing.forgotten == 95, "7 bytes each"
    assert kept(node, "/red/a", 5) == ["a95", "a96", "a97", "a98", "a99"]
    assert kept(node, "/blue/a", 1) == ["old"], "another site has room of its own"
    publishing.forget(Forget("/red/a", Source("red", TOPIC, 97)))
    publishing.publish(text("/red/a", "new", 95))
    publishing.publish(text("/red/b", "b00"))
    assert publishing.forgotten == 95 and kept(node, "/red/a", 4) == ["a96", "a98", "a99", "new"]
    publishing.publish(text("/red/b", "b01", 2))
    assert publishing.forgotten == 96 and kept(node, "/red/a", 3) == ["a98", "a99", "new"], "the oldest one went"
    publishing.publish(text("/red/b", "large" * 9, 3))
    assert kept(node, "/red/b", 1) == ["lar"], "at least one is kept"
    publishing.withdraw("/red/b")
    for number in range(5):
        publishing.publish(text("/red/a", f"a{number:02}", number))
    assert kept(node, "/red/a", 5) == ["a00", "a01", "a02", "a03", "a04"], "what was withdrawn does not count"


def test_empty_latched_messages_count_too(make_node: MakeNode, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "LATCHED_BYTES", 3 * module.MESSAGE_COST + 20)
    publishing = BridgePublishers(make_node("bridge"), "base")
    publishing.advertise(advertise("/red/a"))
    for number in range(10):
        publishing.publish(text("/red/a", "", number))
    assert publishing.forgotten == 7


class _Replaced:
    """A publisher whose original publishers change at the worst moment: while it publishes."""

    def __init__(self, change: Callable[[], None]) -> None:
        self.is_registered = True
        self.published: list[bool] = []
        self._thread = threading.Thread(target=change)

    def publish(self, message: object) -> None:
        self._thread.start()
        self._thread.join(0.2)
        self.published.append(self.is_registered)

    def unregister(self) -> None:
        self.is_registered = False

    def join(self) -> None:
        self._thread.join()


def test_a_message_comes_through_while_original_publishers_change() -> None:
    """This replaces the publisher, and an unregistered one refuses messages."""
    made: list[_Replaced] = []

    def make(*_: object, **__: object) -> _Replaced:
        made.append(_Replaced(lambda: publishing.set_origins("/red/a", ("red:/node",))))
        return made[-1]

    node: Any = SimpleNamespace(advertise=make)
    publishing = BridgePublishers(node, "base")
    publishing.advertise(advertise("/red/a")._replace(latched=False))
    assert publishing.publish(text("/red/a", "a")._replace(latched=False))
    made[0].join()
    assert made[0].published == [True] and not made[0].is_registered
