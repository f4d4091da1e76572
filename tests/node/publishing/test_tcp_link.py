"""tcp_link: a slow or stuck subscriber harms nobody; nothing is reordered, torn or left unsent.

Feature: a slow subscriber does not delay others -- its oldest messages are dropped and counted
"""

from __future__ import annotations

import itertools
import socket
import threading
from typing import Any

import pytest

from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.msgs.std_msgs.msg import Float64, Float64MultiArray
from pyros1.net.loop import WRITE, Loop, TimerHandle
from pyros1.node.publishing import tcp_link
from pyros1.node.publishing.tcp_link import TcpLink, WaitingLink, wait_writable
from pyros1.node.strand import Strand

from ...bodies import decode
from ...parts import publication_of

IMAGE_SIZE = 1 << 19


@pytest.fixture(autouse=True)
def tcp(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.node.subscribing.connector.find_local_context", lambda uri: None)


def greet(peer: Any, type: Any = Float64, topic: str = "/t", **fields: str) -> Any:
    peer.greet(topic=topic, md5sum=type._md5sum, type=type._type, callerid="/raw", **fields)
    assert "error" not in peer.answer()
    return peer


# A subscriber that never reads ----------------------------------------------------------------------------------------


def test_a_stuck_subscriber_delays_nobody_and_loses_the_oldest(make_node: Any, raw_peer: Any, collect: Any) -> None:
    talker, got = make_node("talker"), collect()
    publisher = talker.advertise("t", Image, queue_size=3)
    make_node("listener").subscribe("t", Image, lambda message: got(message.height))
    stuck = greet(raw_peer(talker, receive_buffer=4096), Image)
    assert publisher.wait_for_subscribers(2, timeout=20)
    body = bytes(IMAGE_SIZE)
    for number in range(1, 31):
        publisher.publish(Image(height=number, data=body))
        got.wait(number)  # the other subscriber gets each message although this one reads nothing
    assert got.items == list(range(1, 31))
    link = next(link for link in publication_of(talker).links if link.peer == "/raw")
    assert link.connected
    assert publisher.dropped == link.dropped > 0
    assert link.waiting <= 3 + 1, "the waiting ones and the begun one"
    # what it reads at last is whole messages in order, the newest among them
    heights = [decode(Image, body).height for body in read_until(stuck, lambda h: h == 30)]
    assert heights == sorted(heights) and heights[-3:] == [28, 29, 30]
    assert len(heights) + link.dropped == 30


@pytest.mark.parametrize("queue_size", [10, None])
def test_a_subscriber_whose_machine_is_gone(
    make_node: Any, raw_peer: Any, in_thread: Any, until: Any, monkeypatch: pytest.MonkeyPatch, queue_size: int | None
) -> None:
    """Its link ends, and whoever waits for it goes on; see `is_gone`."""
    gone = threading.Event()
    monkeypatch.setattr(tcp_link, "PEER_CHECK_INTERVAL", 0.01)
    monkeypatch.setattr(tcp_link, "is_peer_dead", lambda sock: gone.is_set())
    talker = make_node("talker")
    publisher = talker.advertise("t", Image, queue_size=queue_size)
    greet(raw_peer(talker, receive_buffer=4096), Image)
    assert publisher.wait_for_subscribers(timeout=20)
    (link,) = publication_of(talker).links
    publishing = in_thread(publisher.publish, Image(data=bytes(20 * IMAGE_SIZE)))
    until(lambda: link.waiting)
    gone.set()
    publishing.join()
    until(lambda: not publisher.num_connections)


def read_until(peer: Any, done: Any) -> Any:
    while True:
        body = peer.frame()
        yield body
        if done(decode(Image, body).height):
            return


def test_queue_size_one_keeps_the_newest_message(make_node: Any, raw_peer: Any) -> None:
    talker = make_node("talker")
    publisher = talker.advertise("t", Image, queue_size=1)
    peer = greet(raw_peer(talker, receive_buffer=4096), Image)
    assert publisher.wait_for_subscribers(timeout=20)
    for number in range(1, 41):
        publisher.publish(Image(height=number, data=bytes(IMAGE_SIZE)))
    heights = [decode(Image, body).height for body in read_until(peer, lambda h: h == 40)]
    assert heights[-1] == 40
    assert len(heights) < 40


def test_queue_size_zero_keeps_everything(make_node: Any, raw_peer: Any) -> None:
    talker = make_node("talker")
    publisher = talker.advertise("t", Image, queue_size=0)
    peer = greet(raw_peer(talker, receive_buffer=4096), Image)
    assert publisher.wait_for_subscribers(timeout=20)
    for number in range(1, 21):
        publisher.publish(Image(height=number, data=bytes(IMAGE_SIZE)))
    heights = [decode(Image, body).height for body in read_until(peer, lambda h: h == 20)]
    assert heights == list(range(1, 21))
    assert publisher.dropped == 0


def test_an_array_that_is_changed_while_it_waits_is_sent_as_it_was(make_node: Any, raw_peer: Any) -> None:
    talker = make_node("talker")
    publisher = talker.advertise("t", Image, queue_size=0)
    peer = greet(raw_peer(talker, receive_buffer=4096), Image)
    assert publisher.wait_for_subscribers(timeout=20)
    data = bytearray(IMAGE_SIZE)
    for number in range(1, 9):
        data[:] = bytes([number]) * IMAGE_SIZE
        publisher.publish(Image(height=number, data=data))
    data[:] = b"\xff" * IMAGE_SIZE
    for body in read_until(peer, lambda h: h == 8):
        message = decode(Image, body)
        assert message.data == bytes([message.height]) * IMAGE_SIZE


def test_many_subscribers_stuck_at_once_bound_the_memory(make_node: Any, raw_peer: Any) -> None:
    talker = make_node("talker")
    publisher = talker.advertise("t", Float64MultiArray, queue_size=5)
    for _ in range(5):
        greet(raw_peer(talker, receive_buffer=4096), Float64MultiArray)
    assert publisher.wait_for_subscribers(5, timeout=20)
    message = Float64MultiArray(data=[0.0] * 20_000)
    for _ in range(100):
        publisher.publish(message)
    assert all(link.waiting <= 5 + 1 for link in publication_of(talker).links)


# queue_size=None ------------------------------------------------------------------------------------------------------


@pytest.fixture
def blocked(make_node: Any, raw_peer: Any, in_thread: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A publisher that waits, in a thread, for a subscriber that does not read."""
    talker = make_node("talker")
    publisher = talker.advertise("t", Image, queue_size=None)
    peer = greet(raw_peer(talker, receive_buffer=4096), Image)
    assert publisher.wait_for_subscribers(timeout=20)
    sent: list[int] = []
    full = threading.Event()

    def flood() -> None:
        for number in range(1, 41):
            publisher.publish(Image(height=number, data=bytes(IMAGE_SIZE)))
            sent.append(number)

    def watch(sock: socket.socket) -> None:
        full.set()
        wait_writable(sock)

    monkeypatch.setattr(tcp_link, "wait_writable", watch)
    thread = in_thread(flood)
    assert full.wait(10)
    yield talker, peer, thread, sent
    peer.close()


@pytest.mark.slow
def test_without_queue_the_publisher_waits_and_nothing_is_lost_t38(blocked: Any) -> None:
    _, peer, thread, sent = blocked
    assert len(sent) < 40
    heights = [decode(Image, body).height for body in read_until(peer, lambda h: h == 40)]
    assert heights == list(range(1, 41))
    thread.join()


def test_the_death_of_the_peer_ends_the_wait(blocked: Any) -> None:
    _, peer, thread, _ = blocked
    peer.close()
    thread.join()


def test_shutdown_ends_the_wait(blocked: Any, in_thread: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.node.topics.CLOSE_TIMEOUT", 0.1)
    talker, _, thread, _ = blocked
    in_thread(talker.shutdown).join()
    thread.join()


# Coalescing -----------------------------------------------------------------------------------------------------------


@pytest.fixture
def loop() -> Any:
    loop = Loop("test")
    loop.start()
    yield loop
    loop.stop()


class InLane:
    """A link to which messages are given as its topic does it."""

    def __init__(self, link: Any, strand: Strand) -> None:
        self.link = link
        self.strand = strand

    def send(self, frame: Any) -> None:
        self.strand.do(self.link.send, frame)
        if isinstance(self.link, WaitingLink):
            self.link.wait()

    def __getattr__(self, name: str) -> Any:
        return getattr(self.link, name)


@pytest.fixture
def ends() -> Any:
    """The two ends of a connection; the first one is the link's."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        far = socket.create_connection(server.getsockname())
        near, _ = server.accept()
    far.settimeout(10)
    yield near, far
    near.close()
    far.close()


@pytest.fixture
def linked(loop: Any, ends: Any) -> Any:
    """A link and the socket at its other end."""
    near, far = ends
    closed = threading.Event()
    links: list[Any] = []

    def make(queue_size: int | None) -> Any:
        link_class = WaitingLink if queue_size is None else TcpLink
        strand = Strand(loop.call_soon)
        link = link_class(loop, strand, near, {"callerid": "/far"}, b"", queue_size, lambda _: closed.set())
        links.append(link)
        return InLane(link, strand), far, closed

    yield make
    for link in links:
        link.close()
        assert closed.wait(20)


def frame(number: int, size: int = 8) -> bytes:
    return size.to_bytes(4, "little") + number.to_bytes(size, "little")


def receive(sock: Any, count: int) -> bytes:
    data = b""
    while len(data) < count:
        part = sock.recv(1 << 16)
        assert part
        data += part
    return data


@pytest.mark.parametrize("queue_size", [0, 1, 2, 1000, None])
def test_nothing_stays_unsent_whatever_the_pace(linked: Any, queue_size: int | None) -> None:
    link, far, _ = linked(queue_size)
    number = itertools.count()
    for burst in (1, 2, 9, 10, 50, 137, 500, 3):  # each burst ends, and all of it must come without another push
        sent = [frame(next(number)) for _ in range(burst)]
        for item in sent:
            link.send(item)
        if queue_size == 0 or queue_size is None:
            assert receive(far, 12 * burst) == b"".join(sent)
        else:
            data = b""
            while not data.endswith(sent[-1]):
                data += receive(far, 1)
            frames = [data[i : i + 12] for i in range(0, len(data), 12)]
            assert frames == sorted(frames, key=lambda f: f[4:][::-1]), "in order"
            assert len(frames) + link.dropped >= burst
    assert link.messages == 1 + 2 + 9 + 10 + 50 + 137 + 500 + 3


def test_a_tight_loop_loses_nothing_that_the_subscriber_can_take(linked: Any, in_thread: Any) -> None:
    link, far, _ = linked(1000)
    count = 20_000
    reading = in_thread(receive, far, 12)
    link.send(frame(0))
    first = reading.join()
    assert first == frame(0)
    got = bytearray()
    last = frame(count)
    done = threading.Event()

    def read() -> None:
        while not got.endswith(last):
            got.extend(far.recv(1 << 16))
        done.set()

    reader = in_thread(read)
    for index in range(1, count + 1):
        link.send(frame(index))
    assert done.wait(10)
    reader.join()
    numbers = [int.from_bytes(got[i + 4 : i + 12], "little") for i in range(0, len(got), 12)]
    assert numbers == sorted(set(numbers))
    assert len(numbers) + link.dropped == count


def test_small_and_large_frames_keep_their_order(linked: Any, in_thread: Any) -> None:
    link, far, _ = linked(0)
    frames: list[Any] = []
    for index in range(300):
        frames.append(frame(index))
        if index % 50 == 49:
            body = bytes([index % 256]) * 100_000
            frames.append([len(body).to_bytes(4, "little"), body])
    whole = b"".join(b"".join(item) if isinstance(item, list) else item for item in frames)
    reading = in_thread(receive, far, len(whole))
    for item in frames:
        link.send(item)
    assert reading.join() == whole
    counted = threading.Event()
    link.strand.do(counted.set)  # the last bytes may arrive before they are counted
    assert counted.wait(20) and link.bytes_sent == len(whole)


class ByHand:
    """Stands for a loop; the test says when it does what it was given."""

    running = True

    def __init__(self) -> None:
        self.events = 0
        self.timers: list[TimerHandle] = []
        self._soon: list[Any] = []

    def call_soon(self, function: Any, *args: Any) -> None:
        self._soon.append((function, args))

    def call_later(self, _seconds: float, function: Any, *args: Any) -> Any:
        """Later than any test."""
        self.timers.append(TimerHandle(0.0, function, args))
        return self.timers[-1]

    def register(self, _sock: Any, events: int, callback: Any) -> None:
        self.events, self.event = events, callback

    modify = register

    def unregister(self, _sock: Any) -> None:
        self.events = 0

    def in_loop(self) -> bool:
        return True

    def turn(self) -> None:
        """Do what was given by now."""
        for function, args in [self._soon.pop(0) for _ in self._soon[:]]:
            function(*args)


class Greedy:
    """A socket that takes everything at once, or nothing while it is full."""

    def __init__(self, sock: socket.socket) -> None:
        self.full = True
        self._sock = sock

    def sendmsg(self, parts: Any) -> int:
        if self.full:
            raise BlockingIOError
        return sum(map(len, parts))

    def send(self, data: bytes) -> int:
        return self.sendmsg([data])

    def __getattr__(self, name: str) -> Any:
        return getattr(self._sock, name)


@pytest.fixture
def by_hand(ends: Any) -> Any:
    """A link that has waited for its full socket, which takes everything now; with its loop and its strand."""
    loop, sock = ByHand(), Greedy(ends[0])
    strand = Strand(loop.call_soon)
    link = TcpLink(loop, strand, sock, {}, b"", 0, lambda _: None)  # type: ignore[arg-type]  # stand-ins
    for number in range(600):
        strand.do(link.send, frame(number, 10_000))
    loop.turn()
    assert link.waiting == 600 and loop.events & WRITE
    sock.full = False
    yield link, loop, strand
    link.close()
    loop.turn()


def test_a_long_queue_is_sent_in_turns(by_hand: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.node.publishing.tcp_link.MAX_BYTES_PER_TURN", 10_000)
    link, loop, _ = by_hand
    loop.event(WRITE)
    assert 0 < link.bytes_sent <= 256 * 10_004, "one system call"
    assert link.waiting > 300 and loop.events & WRITE, "the loop goes on in its next round"
    while link.waiting:
        loop.event(WRITE)
    assert link.bytes_sent == 600 * 10_004 and not loop.events & WRITE


def test_what_the_loop_has_left_in_the_lane_and_does_itself_is_watched_again(
    by_hand: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.publishing.tcp_link.MAX_BYTES_PER_TURN", 10_000)
    link, loop, strand = by_hand
    del strand.free[0]  # somebody works there
    loop.event(WRITE)
    assert not link.bytes_sent and not loop.events & WRITE
    strand.free.append(True)
    strand.work()
    loop.turn()
    assert link.bytes_sent and link.waiting and loop.events & WRITE


@pytest.mark.parametrize(("gap", "waits"), [(1e-5, True), (1e-3, False)])
def test_small_messages_wait_for_others_only_in_a_tight_loop(
    by_hand: Any, monkeypatch: pytest.MonkeyPatch, gap: float, waits: bool
) -> None:
    link, loop, strand = by_hand
    while link.waiting:
        loop.event(WRITE)
    now = itertools.count()
    monkeypatch.setattr(tcp_link, "perf_counter", lambda: 1e5 + gap * next(now))
    waiting = set()
    for number in range(tcp_link.MIN_STREAK + 20):
        strand.do(link.send, frame(number, 10))
        waiting.add(link.waiting)
    assert (waiting != {0}) is waits


def test_a_closed_link_leaves_no_timer(by_hand: Any) -> None:
    """It would keep the link, its queue and its socket until the next check."""
    link, loop, _ = by_hand
    assert loop.timers and not all(timer.cancelled for timer in loop.timers)
    link.close()
    loop.turn()
    assert all(timer.cancelled for timer in loop.timers)


def test_an_interrupted_publisher_without_a_queue_leaves_the_rest_to_the_loop(linked: Any) -> None:
    link, far, _ = linked(None)
    one = frame(1, 16 << 20)
    link.strand.do(link.link.send, one)
    assert link.waiting
    link.strand.do(link.recover)  # a signal handler has raised before the publisher waited
    assert receive(far, len(one)) == one


def test_finish_sends_what_waits(linked: Any, in_thread: Any) -> None:
    import time

    link, far, closed = linked(0)
    frames = [frame(index, 1000) for index in range(3000)]
    for item in frames:
        link.send(item)

    def read_all() -> bytes:
        data = b""
        while part := far.recv(1 << 16):
            data += part
        return data

    reading = in_thread(read_all)
    link.finish(time.perf_counter() + 5.0)
    assert reading.join() == b"".join(frames)
    assert closed.wait(20) and not link.connected
    link.send(frame(1))  # nothing happens


def test_the_end_of_a_peer_is_noticed_without_publishing(linked: Any) -> None:
    link, far, closed = linked(10)
    far.close()
    assert closed.wait(20)
    assert not link.connected


def test_what_a_subscriber_says_is_ignored(linked: Any) -> None:
    link, far, closed = linked(10)
    far.sendall(b"noise" * 1000)
    link.send(frame(5))
    assert receive(far, 12) == frame(5)
    assert link.connected and not closed.is_set()


def test_address_has_the_shape_that_rosnode_reads_s03(linked: Any) -> None:
    link, far, _ = linked(1)
    host, port = far.getsockname()[:2]
    own = far.getpeername()[1]
    assert link.address.startswith(f"TCPROS connection on port {own} to [{host}:{port} on socket ")


def test_waiting_for_a_socket_on_a_system_without_poll(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr("select.poll", raising=False)
    near, far = socket.socketpair()
    with near, far:
        wait_writable(near)
    wait_writable(near)  # it has been closed meanwhile


def test_the_address_of_a_subscriber_that_is_gone_already() -> None:
    loop = Loop("test")
    with socket.socket() as sock:
        link = TcpLink(loop, Strand(loop.call_soon), sock, {"callerid": "/x"}, b"", 1, lambda _: None)
        assert link.address == "TCPROS connection on port 0 to [unknown]"
    loop.start()
    loop.stop()
