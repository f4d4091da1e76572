"""The threads that send: a bulky packet that waits for the network does not delay urgent ones."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator

import pytest

from pyros1.bridge.exchange.actions import Probe, Send
from pyros1.bridge.exchange.outgoing import Drop
from pyros1.bridge.rules.rules import Priority
from pyros1.bridge.transport.pacing import FIRST_WINDOW, SLOW_COUNT
from pyros1.bridge.transport.sender import Sender

PATIENCE = 10.0


class SlowLink:
    """A link that sends bulky packets only when it is told to."""

    def __init__(self) -> None:
        self.problem = ""
        self.sent: queue.Queue[bytes] = queue.Queue()
        self.may_send = threading.Event()
        self.is_waiting = threading.Event()

    def send(self, packet: Send) -> None:
        """Send a packet."""
        if packet.body == b"error":
            raise RuntimeError("the network is gone")
        if packet.priority is Priority.LOW:
            self.is_waiting.set()
            assert self.may_send.wait(PATIENCE)
        self.sent.put(packet.body)

    def listen(self, site: str, key: str, on: bool) -> None:
        """Note it among what is sent."""
        self.sent.put(f"listen {site} {key} {on}".encode())

    def close(self) -> None:
        """Do nothing."""


@pytest.fixture
def link() -> SlowLink:
    return SlowLink()


@pytest.fixture
def errors() -> list[str]:
    return []


@pytest.fixture
def sender(link: SlowLink, errors: list[str]) -> Iterator[Sender]:
    sender = Sender(link, lambda: 0.0, lambda error: errors.append(str(error)))
    yield sender
    link.may_send.set()
    sender.close()


def test_urgent_packets_do_not_wait_for_bulky_ones(link: SlowLink, sender: Sender) -> None:
    sender.put(Send("image", b"", b"first", Priority.LOW, 1))
    assert link.is_waiting.wait(PATIENCE)
    sender.put(Send("image", b"", b"second", Priority.LOW, 1))
    sender.put(Send("image", b"", b"third", Priority.LOW, 1))
    sender.put(Send("cmd_vel", b"", b"stop", Priority.URGENT))
    assert link.sent.get(timeout=PATIENCE) == b"stop"
    assert sender.waiting_bytes == 5
    link.may_send.set()
    assert [link.sent.get(timeout=PATIENCE) for _ in range(2)] == [b"first", b"third"]
    assert sender.drops("image") == {Drop.OVERTAKEN: 1} and sender.drops("cmd_vel") == {}


def test_errors_of_the_link_are_told(link: SlowLink, sender: Sender, errors: list[str]) -> None:
    sender.put(Send("a", b"", b"error"))
    sender.put(Send("a", b"", b"next"))
    assert link.sent.get(timeout=PATIENCE) == b"next" and errors == ["the network is gone"]


def test_what_waits_is_sent_at_the_end(link: SlowLink) -> None:
    link.may_send.set()
    sender = Sender(link, lambda: 0.0, lambda error: None)
    for number in range(100):
        sender.put(Send("a", b"", b"%d" % number, Priority.LOW))
    sender.close()
    assert link.sent.qsize() == 100
    sender.put(Send("a", b"", b"late"))
    assert link.sent.qsize() == 100


def test_listening_begins_before_the_request_is_sent(link: SlowLink, sender: Sender) -> None:
    for number in range(3):
        sender.listen("red", f"t{number}", True)
        sender.put(Send("to/red", b"", b"request %d" % number))
    sent = [link.sent.get(timeout=PATIENCE) for _ in range(6)]
    for number in range(3):
        assert sent.index(b"listen red t%d True" % number) < sent.index(b"request %d" % number)


def test_bulky_packets_wait_for_answers_to_probes(link: SlowLink) -> None:
    link.may_send.set()
    asked: queue.Queue[int] = queue.Queue()

    def make_probes(receiver: str, number: int, priority: Priority) -> list[Probe]:
        assert receiver == ""
        asked.put(number)
        return [Probe("base", 0.02, Send("to/base", b"", b"probe", priority))]

    sender = Sender(link, lambda: 0.0, lambda error: None, make_probes)
    try:
        for number in range(2):
            sender.put(Send("image", b"", bytes([number]) * FIRST_WINDOW, Priority.LOW))
        assert link.sent.get(timeout=PATIENCE)[0] == 0 and link.sent.get(timeout=PATIENCE) == b"probe"
        assert link.sent.empty() and sender.waiting_bytes == FIRST_WINDOW
        sender.put(Send("cmd_vel", b"", b"stop", Priority.URGENT))
        assert link.sent.get(timeout=PATIENCE) == b"stop"
        sender.on_probe_reply("base", asked.get(timeout=PATIENCE))
        assert link.sent.get(timeout=PATIENCE)[0] == 1
    finally:
        sender.close()


def test_a_slow_site_is_reported(link: SlowLink) -> None:
    link.may_send.set()
    now = [0.0]
    slow: queue.Queue[str] = queue.Queue()
    asked: queue.Queue[int] = queue.Queue()

    def make_probes(receiver: str, number: int, priority: Priority) -> list[Probe]:
        asked.put(number)
        return [Probe(site, 0.02, Send(f"to/{site}", b"", b"probe", priority)) for site in ("base", "blue")]

    sender = Sender(link, lambda: now[0], lambda error: None, make_probes, slow.put)
    try:
        for _ in range(SLOW_COUNT + 1):
            sender.put(Send("t/red/image", b"", bytes(FIRST_WINDOW), Priority.LOW))
            sent = [link.sent.get(timeout=PATIENCE) for _ in range(3)]
            assert sent[1:] == [b"probe"] * 2
            sender.on_probe_reply("base", asked.get(timeout=PATIENCE))
            now[0] += 2.5  # blue has not answered
        assert slow.get(timeout=PATIENCE) == "blue" and slow.empty()
    finally:
        sender.close()
