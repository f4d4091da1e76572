"""The network in memory does to packets what its conditions say."""

from __future__ import annotations

from random import Random

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.protocol.key_expressions import Key
from pyros1.bridge.transport.memory_link import MemoryLink, MemoryNetwork, NetworkConditions


class Heard:
    """Three sites on a network, and what they hear."""

    def __init__(self, conditions: NetworkConditions = NetworkConditions(0.1)) -> None:  # noqa: B008 - immutable
        self.network = MemoryNetwork(Random(1), conditions)
        self.packets: list[tuple[str, float, bytes]] = []
        self.links = {name: self.connect(name) for name in ("red", "blue", "base")}

    def connect(self, name: str) -> MemoryLink:
        def receive(key: Key, head: bytes, body: bytes) -> None:
            self.packets.append((name, round(self.network.now, 3), body))

        return self.network.connect(name, receive)

    def send(self, *bodies: bytes, key: str = "hello") -> list[tuple[str, float, bytes]]:
        self.packets.clear()
        for body in bodies:
            self.links["red"].send(Send(key, b"", body))
        self.network.run_until(self.network.now + 10.0)
        return self.packets


def test_who_hears_what() -> None:
    heard = Heard()
    assert heard.send(b"x") == [("blue", 0.1, b"x"), ("base", 0.1, b"x")]
    assert heard.send(b"x", key="to/base") == [("base", 10.1, b"x")]
    assert heard.send(b"x", key="t/red/odom") == []
    heard.links["blue"].listen("red", "t/red/odom", True)
    assert [name for name, _, _ in heard.send(b"x", key="t/red/odom")] == ["blue"]
    heard.links["blue"].listen("red", "t/red/odom", False)
    assert heard.send(b"x", key="t/red/odom") == []


def test_parted_sites() -> None:
    heard = Heard()
    heard.network.part("red", "base")
    assert [name for name, _, _ in heard.send(b"x")] == ["blue"]
    heard.network.part("base", "red", False)
    assert len(heard.send(b"x")) == 2
    heard.links["red"].send(Send("hello", b"", b"x"))
    heard.packets.clear()
    heard.network.part("red", "base")  # while the packet is on its way
    heard.network.run_until(heard.network.now + 1)
    assert [name for name, _, _ in heard.packets] == ["blue"]


def test_loss_repetition_and_order() -> None:
    bodies = [b"%d" % number for number in range(1000)]
    heard = Heard(NetworkConditions(0.1, loss=0.25))
    assert 1400 < len(heard.send(*bodies)) < 1600
    heard = Heard(NetworkConditions(0.1, repetition=0.25))
    assert 2400 < len(heard.send(*bodies)) < 2600
    heard = Heard(NetworkConditions(0.1, jitter=1.0))
    arrived = [body for name, _, body in heard.send(*bodies) if name == "blue"]
    assert arrived != bodies and sorted(arrived) == sorted(bodies)
    assert all(0.1 <= time <= 1.1 for _, time, _ in heard.packets)


def test_a_site_that_starts_again() -> None:
    heard = Heard()
    old = heard.links["blue"]
    heard.links["red"].send(Send("hello", b"", b"x"))
    heard.connect("blue")
    heard.network.run_until(1.0)
    assert len(heard.packets) == 1  # what was on its way to the earlier run is lost
    old.close()
