"""tcp_source: large frames arrive in pieces, everything else through the buffer, whatever the order and the cuts."""

from __future__ import annotations

import random
import socket
import threading
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.msgs import AnyMsg, load_message
from pyros1.msgs.large_arrays import SplitBody, decode_split, find_layout
from pyros1.net import spin_wait
from pyros1.net.spin_wait import CHECKED_PAUSE, DONTWAIT, MAX_PAUSE, MIN_PAUSE, PREEMPTION_GAP
from pyros1.node.subscribing import tcp_source
from pyros1.node.subscribing.queues import Backlog, Frames
from pyros1.node.subscribing.tcp_source import (
    BUSY_POLL_TIME,
    DRAIN_TIME,
    MIN_FLOOD_STREAK,
    MIN_LARGE_FRAME,
    FloodDetector,
    TcpLinks,
    TcpSource,
)

from ...bodies import decode, encode

IMAGE: Any = load_message("sensor_msgs/Image")


@pytest.fixture
def pair() -> Iterator[tuple[socket.socket, TcpSource]]:
    with socket.create_server(("127.0.0.1", 0)) as server:
        sender = socket.create_connection(server.getsockname())
        receiver, _ = server.accept()
    with sender, receiver:
        yield sender, TcpSource(receiver, "http://127.0.0.1:1/", {}, b"")


def image(number: int, size: int, frame_id: str = "camera") -> Any:
    message = IMAGE(width=number, data=bytes([number % 256]) * size)
    message.header.frame_id = frame_id
    return message


def frame(message: Any) -> bytes:
    body = encode(message)
    return len(body).to_bytes(4, "little") + body


def receive(link: TcpSource, count: int, cls: Any = IMAGE) -> tuple[list[Any], int]:
    """Return so many messages, and how many of them came in pieces. Learns as a subscription does."""
    where = find_layout(cls)
    assert where is not None
    messages: list[Any] = []
    split = 0
    while len(messages) < count:
        try:
            batch = link.receive(wait=True)
        except BlockingIOError:
            continue
        assert batch is not None, "the stream ended"
        for body in batch.newest(len(batch)):
            if isinstance(body, SplitBody):
                split += 1
                messages.append(decode_split(cls, where, body))
                continue
            messages.append(decode(cls, body))
            array = len(getattr(messages[-1], where.field))
            if array >= MIN_LARGE_FRAME:
                link.set_expected_layout(len(body), array, where.tail_size, where.has_length_field)
    return messages, split


def send(sender: socket.socket, data: bytes) -> threading.Thread:
    thread = threading.Thread(target=sender.sendall, args=(data,))
    thread.start()
    return thread


def test_a_large_frame_like_the_last_one_is_received_in_pieces(pair: tuple[socket.socket, TcpSource]) -> None:
    sender, link = pair
    sent = [image(i, MIN_LARGE_FRAME + 1000 * i) for i in range(5)]
    thread = send(sender, b"".join(map(frame, sent)))
    received, split = receive(link, 5)
    thread.join()
    assert received == sent
    assert split >= 1 or not link.can_wait  # how many depends on how fast the pieces come
    assert link.messages == 5 and link.bytes_received == sum(len(frame(message)) for message in sent)


@pytest.mark.parametrize("seed", range(8))
def test_any_mixture_of_sizes_and_shapes_arrives_whole_and_in_order(
    pair: tuple[socket.socket, TcpSource], seed: int
) -> None:
    sender, link = pair
    chance = random.Random(seed)
    sizes = (0, 10, MIN_LARGE_FRAME - 1, MIN_LARGE_FRAME, MIN_LARGE_FRAME + 7, 3 * MIN_LARGE_FRAME)
    sent = [image(i, chance.choice(sizes), chance.choice(("camera", "camera", "tool"))) for i in range(40)]
    thread = send(sender, b"".join(map(frame, sent)))
    received, _ = receive(link, 40)
    thread.join()
    assert received == sent


def test_undecoded_messages_arrive_in_one_piece(pair: tuple[socket.socket, TcpSource]) -> None:
    sender, link = pair
    sent = [image(i, MIN_LARGE_FRAME * (1 + i % 3)) for i in range(20)] + [image(20, 3), image(21, MIN_LARGE_FRAME)]
    thread = send(sender, b"".join(map(frame, sent)))
    received, _ = receive(link, 22, AnyMsg)
    thread.join()
    assert [message._buff for message in received] == [encode(message) for message in sent]


def test_a_frame_that_stops_in_the_middle_holds_nobody_up(pair: tuple[socket.socket, TcpSource]) -> None:
    sender, link = pair
    whole = frame(image(1, MIN_LARGE_FRAME))
    link.set_expected_layout(len(whole) - 4, MIN_LARGE_FRAME, 0, True)
    sender.sendall(whole[:1000])
    batch = link.receive(wait=True)  # the wait is bounded
    assert batch is not None and not len(batch) and link.bytes_received == 1000 and link.expected_layout is None
    thread = send(sender, whole[1000:])
    received, _ = receive(link, 1)
    thread.join()
    assert received == [image(1, MIN_LARGE_FRAME)]


def test_a_claimed_size_is_not_believed_beforehand(pair: tuple[socket.socket, TcpSource]) -> None:
    sender, link = pair
    head = frame(image(1, MIN_LARGE_FRAME))[:-MIN_LARGE_FRAME]
    link.set_expected_layout(len(head) - 4 + MIN_LARGE_FRAME, MIN_LARGE_FRAME, 0, True)
    claim = 900_000_000
    sender.sendall((len(head) - 4 + claim).to_bytes(4, "little") + head[4:-4] + claim.to_bytes(4, "little"))
    assert link.receive(wait=True) is not None and link.bytes_received == len(head)
    assert len(link.buffer.data) <= 32 << 20


def test_the_end_of_the_stream(pair: tuple[socket.socket, TcpSource]) -> None:
    sender, link = pair
    link.set_expected_layout(MIN_LARGE_FRAME + 100, MIN_LARGE_FRAME, 0, True)
    sender.close()
    assert link.receive(wait=True) is None


def test_the_address_of_a_connection_that_is_gone_already() -> None:
    with socket.socket() as sock:
        assert TcpSource(sock, "http://x:1/", {}, b"").address == "TCPROS connection on port 0 to [unknown]"


def test_where_a_receive_cannot_wait_it_never_does(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.node.subscribing.tcp_source.set_socket_timeouts", lambda sock, seconds: False)
    sender, receiver = socket.socketpair()
    with sender, receiver:
        link = TcpSource(receiver, "http://x:1/", {}, b"")
        assert not link.can_wait
        with pytest.raises(BlockingIOError):
            link.receive()
        sender.sendall(frame(image(1, 10)))
        assert receive(link, 1)[0] == [image(1, 10)]


def test_a_flood_of_single_messages_is_let_accumulate_until_it_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    now, slept = [100.0], []
    monkeypatch.setattr(tcp_source, "perf_counter", lambda: now[0])
    monkeypatch.setattr(tcp_source.time, "sleep", slept.append)
    link: Any = SimpleNamespace(messages=1000, bytes_received=1 << 20)
    detector = FloodDetector(link)

    def receive_once(messages: int = 1, size: int = 100, gap: float = 10e-6) -> int:
        link.messages, link.bytes_received, now[0] = link.messages + messages, link.bytes_received + size, now[0] + gap
        detector.pause()
        return len(slept)

    assert [receive_once() for _ in range(MIN_FLOOD_STREAK)] == [0] * MIN_FLOOD_STREAK
    assert [receive_once() for _ in range(3)] == [1, 2, 3]
    assert receive_once(messages=100) == 3, "many have accumulated"
    assert receive_once() == 4
    assert receive_once(gap=0.1) == 4, "the flood is over"
    assert [receive_once() for _ in range(MIN_FLOOD_STREAK)][-1] == 4
    assert receive_once() == 5
    assert receive_once(size=1 << 20) == 5, "these are large"


def test_links_that_move_are_waited_for_where_they_go() -> None:
    calls: list[tuple[str, str, int]] = []

    def driver(name: str) -> Any:
        return SimpleNamespace(
            cooperative=False,
            register=lambda fd, _: calls.append((name, "register", fd)),
            unregister=lambda fd: calls.append((name, "unregister", fd)),
        )

    old, new = driver("old"), driver("new")
    delivery: Any = SimpleNamespace(driver=old)
    links, link = TcpLinks(delivery, lambda link, reason: None), SimpleNamespace(fd=7, take_received=lambda _: None)
    links.open(link)  # type: ignore[arg-type]
    links.move(new)
    assert calls == [("old", "register", 7), ("old", "unregister", 7), ("new", "register", 7)]
    assert delivery.driver is new


def test_floods_on_all_links_hold_callbacks_up_no_longer_than_on_one(monkeypatch: pytest.MonkeyPatch) -> None:
    now, step, count = [100.0], DRAIN_TIME / 20, 5
    monkeypatch.setattr(tcp_source, "perf_counter", lambda: now[0])

    class Flooded:
        """Always has more to receive."""

        def __init__(self, fd: int) -> None:
            self.fd = fd
            self.received = 0

        def take_received(self, _: int) -> None: ...

        def receive(self, _: bool) -> Frames:
            self.received += 1
            now[0] += step
            link: Any = self
            return Frames(link, b"", [])

    delivery: Any = SimpleNamespace(driver=SimpleNamespace(cooperative=False, register=lambda *_: None))
    links, flooded = TcpLinks(delivery, lambda link, reason: None), [Flooded(fd) for fd in range(count)]
    for link in flooded:
        links.open(link)  # type: ignore[arg-type]
    links.drain(Backlog(1))
    assert all(link.received for link in flooded)
    assert now[0] - 100.0 < DRAIN_TIME + (count + 0.5) * step


class Clock:
    """Time that passes with each poll, and how many polls there were."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now, self.step, self.polls = 100.0, 1e-6, 0
        monkeypatch.setattr(tcp_source, "perf_counter", lambda: self.now)
        monkeypatch.setattr(tcp_source, "yield_processor", self._pass)
        self.is_machine_idle = True
        monkeypatch.setattr(spin_wait, "could_poll", lambda before, now: self.is_machine_idle)

    def _pass(self) -> None:
        self.now += self.step
        self.polls += 1

    def polls_of(self, link: TcpSource) -> int:
        """Return how often a link polls in vain before it sleeps."""
        self.polls = 0
        with pytest.raises(BlockingIOError):
            link.receive(wait=True)
        return self.polls


@pytest.mark.skipif(not DONTWAIT, reason="this system cannot receive without waiting")
def test_polling_ends_while_others_need_the_processor(
    pair: tuple[socket.socket, TcpSource], monkeypatch: pytest.MonkeyPatch
) -> None:
    sender, link = pair
    clock = Clock(monkeypatch)
    assert clock.polls_of(link) == 0, "it was not asked to poll"
    link.low_latency = True
    address = link.address
    assert clock.polls_of(link) == 0, "whether a processor is idle is not known yet"
    clock.now += CHECKED_PAUSE
    assert clock.polls_of(link) == pytest.approx(BUSY_POLL_TIME / clock.step, rel=0.01)
    assert link.address == address
    clock.step = 2 * PREEMPTION_GAP
    assert clock.polls_of(link) == 1
    clock.step = 1e-6
    assert clock.polls_of(link) == 0
    sender.sendall(frame(image(1, 10)))
    assert receive(link, 1)[0] == [image(1, 10)], "messages come all the same"
    clock.now += MIN_PAUSE
    assert link.address == address
    assert clock.polls_of(link) == pytest.approx(BUSY_POLL_TIME / clock.step, rel=0.01)


@pytest.mark.skipif(not DONTWAIT, reason="this system cannot receive without waiting")
def test_links_tell_that_the_machine_is_too_busy(
    pair: tuple[socket.socket, TcpSource], monkeypatch: pytest.MonkeyPatch
) -> None:
    _, link = pair
    clock, address = Clock(monkeypatch), link.address
    clock.is_machine_idle = False
    link.low_latency = True
    assert clock.polls_of(link) == 0 and link.address == address, "it is not known yet"
    clock.now += CHECKED_PAUSE
    assert clock.polls_of(link) == 0 and link.address == f"{address}, polling paused"
    clock.now += MAX_PAUSE
    clock.is_machine_idle = True
    assert clock.polls_of(link) > 0 and link.address == address


def test_a_link_that_cannot_wait_expects_no_pieces(pair: tuple[socket.socket, TcpSource]) -> None:
    _, link = pair
    link.can_wait = False
    link.set_expected_layout(100, 50, 0, True)
    assert link.expected_layout is None
