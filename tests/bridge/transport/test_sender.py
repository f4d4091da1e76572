"""The threads that send: a bulky packet that waits for the network does not delay urgent ones."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator
from itertools import count

import pytest

from pyros1.bridge.exchange.actions import Probe, Send
from pyros1.bridge.exchange.outgoing import DropReason
from pyros1.bridge.rules.rules import Priority
from pyros1.bridge.transport.lanes import DIRECT_BYTES
from pyros1.bridge.transport.pacer import FIRST_WINDOW, SLOW_COUNT
from pyros1.bridge.transport.sender import Sender

PATIENCE = 10.0


class SlowLink:
    """A link that sends bulky packets only when it is told to.

    Attributes:
        sends_directly: whether it sends packets in the thread that puts them.
        threads: which threads have sent, in order.
    """

    def __init__(self) -> None:
        self.problem = ""
        self.sends_directly = False
        self.threads: list[str] = []
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
        self.threads.append(threading.current_thread().name)
        self.sent.put(packet.body)

    def try_send(self, packet: Send) -> bool:
        """Send a packet, if it does so."""
        if self.sends_directly:
            self.send(packet)
        return self.sends_directly

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
    assert sender.drops("image") == {DropReason.OVERTAKEN: 1} and sender.drops("cmd_vel") == {}


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


@pytest.mark.parametrize("priority", [Priority.URGENT, Priority.NORMAL])
def test_a_last_packet_that_the_link_does_not_send_at_once_is_sent(link: SlowLink, priority: Priority) -> None:
    for number in range(30):
        sender = Sender(link, lambda: 0.0, lambda error: None)
        sender.put(Send("a", b"", b"%d" % number, priority))
        sender.close()
        assert link.sent.get_nowait() == b"%d" % number


def test_listening_begins_before_the_request_is_sent(link: SlowLink, sender: Sender) -> None:
    for number in range(3):
        sender.listen("red", f"t{number}", True)
        sender.put(Send("to/red", b"", b"request %d" % number))
    sent = [link.sent.get(timeout=PATIENCE) for _ in range(6)]
    for number in range(3):
        assert sent.index(b"listen red t%d True" % number) < sent.index(b"request %d" % number)


class SlowlyListeningLink(SlowLink):
    """A link that cannot listen to another key until it is told that it may."""

    def listen(self, site: str, key: str, on: bool) -> None:
        """Wait until the link may listen, and note it among what is sent."""
        self.is_waiting.set()
        assert self.may_send.wait(PATIENCE)
        super().listen(site, key, on)


def test_many_changes_of_what_to_listen_to_delay_no_urgent_packet() -> None:
    link = SlowlyListeningLink()
    ticks = count()
    sender = Sender(link, lambda: float(next(ticks)), lambda error: None)
    sender.listen("red", "t0", True)
    assert link.is_waiting.wait(PATIENCE)
    sender.put(Send("to/blue", b"", b"before"))
    for _ in range(1000):
        for on in (True, False):
            sender.listen("red", "t1", on)
            sender.listen("red", "t2", not on)
    sender.put(Send("to/red", b"", b"request"))
    sender.put(Send("to/blue", b"", b"heartbeat", Priority.URGENT))
    link.may_send.set()
    assert [link.sent.get(timeout=PATIENCE) for _ in range(6)] == [
        b"listen red t0 True",
        b"heartbeat",
        b"before",
        b"listen red t1 False",
        b"listen red t2 True",
        b"request",
    ]
    sender.close()
    assert link.sent.empty()


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


BULK, URGENT = "bridge: other packets", "bridge: urgent packets"


def test_what_need_not_wait_is_sent_by_the_thread_that_puts_it(link: SlowLink, sender: Sender) -> None:
    link.sends_directly = True
    own = threading.current_thread().name
    sender.put(Send("a", b"", b"1", Priority.NORMAL))
    sender.put(Send("a", b"", b"2", Priority.URGENT))
    sender.put(Send("a", b"", bytes(DIRECT_BYTES), Priority.NORMAL))
    sender.put(Send("a", b"", b"expired", Priority.NORMAL, expires=-1.0))
    assert [link.sent.get_nowait() for _ in range(3)] == [b"1", b"2", bytes(DIRECT_BYTES)]
    sender.put(Send("a", b"", bytes(DIRECT_BYTES + 1), Priority.NORMAL))
    assert len(link.sent.get(timeout=PATIENCE)) == DIRECT_BYTES + 1
    assert link.threads == [own, own, own, BULK] and link.sent.empty()


def test_what_the_link_cannot_send_at_once_waits_with_all_that_follows(link: SlowLink, sender: Sender) -> None:
    sent = [b"%d" % number for number in range(200)]
    for number, body in enumerate(sent):
        link.sends_directly = number % 3 == 0
        sender.put(Send("a", b"", body))
    assert [link.sent.get(timeout=PATIENCE) for _ in sent] == sent
    assert {*link.threads} <= {threading.current_thread().name, URGENT}


def test_others_wait_while_a_packet_is_sent_at_once(link: SlowLink, sender: Sender) -> None:
    link.sends_directly = True
    first = threading.Thread(target=sender.put, args=(Send("image", b"", b"first", Priority.LOW),), name="first")
    first.start()
    assert link.is_waiting.wait(PATIENCE)
    for number in range(3):
        sender.put(Send("a", b"", b"%d" % number, Priority.NORMAL))
    sender.put(Send("a", b"", b"urgent"))
    assert link.sent.get(timeout=PATIENCE) == b"urgent" and sender.waiting_bytes == 3
    link.may_send.set()
    assert [link.sent.get(timeout=PATIENCE) for _ in range(4)] == [b"first", b"0", b"1", b"2"]
    first.join()
    assert link.threads == [threading.current_thread().name, "first", BULK, BULK, BULK]


def test_close_waits_for_what_is_sent_at_once(link: SlowLink, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.bridge.transport.sender.FLUSH_TIME", PATIENCE)
    link.sends_directly = True
    sender = Sender(link, lambda: 0.0, lambda error: None)
    first = threading.Thread(target=sender.put, args=(Send("image", b"", b"first", Priority.LOW),))
    first.start()
    assert link.is_waiting.wait(PATIENCE)
    closer = threading.Thread(target=sender.close)
    closer.start()
    link.may_send.set()
    for thread in (first, closer):
        thread.join(PATIENCE)
        assert not thread.is_alive()
    assert link.sent.get_nowait() == b"first"


@pytest.mark.parametrize(
    ("took", "laters"),
    [
        ([0.0006, 0.0006, 0.0006], (0.0, 0.0, 0.05, 0.04, 0.02)),
        ([0.0006, 0.0004, 0.0006, 0.0006, 0.0], (0.0, 0.0, 0.0, 0.0, 0.05, 0.04, 0.02)),
        ([2.0, 0.0], (0.0, 0.2, 199.0, 1.0)),
        ([50.0, 0.0], (0.0, 0.2, 299.0, 1.0)),
    ],
)
def test_after_long_waits_the_thread_sends(link: SlowLink, took: list[float], laters: tuple[float, ...]) -> None:
    """The longer the thread that put packets had to wait, the longer it is before that may happen again."""
    now = [0.0]
    sender = Sender(link, lambda: now[0], lambda error: None)
    link.sends_directly = True
    direct = len(took) - 1

    def send_slowly(packet: Send) -> bool:
        now[0] += took.pop(0)
        link.send(packet)
        return True

    link.try_send = send_slowly  # type: ignore[method-assign]
    try:
        for later in laters:
            now[0] += later
            sender.put(Send("a", b"", b"x"))
            link.sent.get(timeout=PATIENCE)
        own = threading.current_thread().name
        assert link.threads == [*[own] * direct, URGENT, URGENT, own]
    finally:
        sender.close()


def test_errors_at_once_are_reported(link: SlowLink, sender: Sender, errors: list[str]) -> None:
    link.sends_directly = True
    sender.put(Send("a", b"", b"error"))
    assert errors == ["the network is gone"]
    sender.put(Send("a", b"", b"next"))
    assert link.sent.get_nowait() == b"next"


def test_a_mistake_while_an_error_is_reported_does_not_stop_the_thread(link: SlowLink) -> None:
    def fail(error: Exception) -> None:
        raise ValueError("a mistake")

    sender = Sender(link, lambda: 0.0, fail)
    link.sends_directly = True
    try:
        with pytest.raises(ValueError, match="a mistake"):
            sender.put(Send("a", b"", b"error"))
        sender.put(Send("a", b"", b"next"))
        assert link.sent.get(timeout=PATIENCE) == b"next"
    finally:
        sender.close()


def test_a_probe_does_not_overtake_a_packet_that_cannot_go_at_once(link: SlowLink) -> None:
    link.may_send.set()

    def send_probes_only(packet: Send) -> bool:
        if packet.body == b"probe":
            link.send(packet)
        return packet.body == b"probe"

    link.try_send = send_probes_only  # type: ignore[method-assign]
    sender = Sender(link, lambda: 0.0, lambda _: None, lambda *_: [Probe("base", 0.02, Send("to/base", b"", b"probe"))])
    try:
        sender.put(Send("image", b"", b"x", Priority.LOW))
        assert [link.sent.get(timeout=PATIENCE) for _ in range(2)] == [b"x", b"probe"]
    finally:
        sender.close()


def test_the_thread_does_nothing_while_a_packet_is_sent_at_once(link: SlowLink, sender: Sender) -> None:
    begun, end = threading.Event(), threading.Event()

    def send_slowly(packet: Send) -> bool:
        begun.set()
        assert end.wait(PATIENCE)
        link.send(packet)
        return True

    link.try_send = send_slowly  # type: ignore[method-assign]
    first = threading.Thread(target=sender.put, args=(Send("a", b"", b"first"),))
    first.start()
    assert begun.wait(PATIENCE)
    sender.listen("red", "x", True)
    with pytest.raises(queue.Empty):
        link.sent.get(timeout=0.2)
    end.set()
    assert [link.sent.get(timeout=PATIENCE) for _ in range(2)] == [b"first", b"listen red x True"]
    first.join(PATIENCE)


@pytest.mark.parametrize("sends_directly", [True, False])
def test_probes_follow_what_is_sent_at_once(link: SlowLink, sends_directly: bool) -> None:
    link.sends_directly = sends_directly
    link.may_send.set()
    asked: queue.Queue[int] = queue.Queue()

    def make_probes(receiver: str, number: int, priority: Priority) -> list[Probe]:
        asked.put(number)
        return [Probe("base", 0.02, Send("to/base", b"", b"probe", priority))]

    sender = Sender(link, lambda: 0.0, lambda error: None, make_probes)
    try:
        sender.put(Send("image", b"", b"x", Priority.LOW))
        assert [link.sent.get(timeout=PATIENCE) for _ in range(2)] == [b"x", b"probe"]
        assert {*link.threads} == {threading.current_thread().name if sends_directly else BULK}
        size = FIRST_WINDOW // 2
        for _ in range(FIRST_WINDOW // size):
            sender.put(Send("image", b"", bytes(size), Priority.LOW))
        sender.put(Send("image", b"", b"waits", Priority.LOW))
        sizes = [len(link.sent.get(timeout=PATIENCE)) for _ in range(2 * (FIRST_WINDOW // size))]
        assert sizes == [size, 5] * (FIRST_WINDOW // size) and sender.waiting_bytes == 5
        while not asked.empty():
            sender.on_probe_reply("base", asked.get())
        assert link.sent.get(timeout=PATIENCE) == b"waits"
    finally:
        sender.close()


def test_a_site_that_never_answers_is_not_waited_for_for_ever(link: SlowLink) -> None:
    """The thread notices it by itself: nothing else happens."""
    link.may_send.set()
    now = [0.0]

    def make_probes(receiver: str, number: int, priority: Priority) -> list[Probe]:
        return [Probe("base", 0.02, Send("to/base", b"", b"probe", priority))]

    sender = Sender(link, lambda: now[0], lambda error: None, make_probes)
    try:
        for number in range(2):
            sender.put(Send("image", b"", bytes([number]) * FIRST_WINDOW, Priority.LOW))
        assert link.sent.get(timeout=PATIENCE)[0] == 0 and link.sent.get(timeout=PATIENCE) == b"probe"
        now[0] = 10.0
        assert link.sent.get(timeout=PATIENCE)[0] == 1
    finally:
        sender.close()
