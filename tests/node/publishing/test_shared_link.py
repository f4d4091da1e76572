"""SharedLink and SharedSource at two ends of a socket: what is given back, and what a signal handler may interrupt."""

from __future__ import annotations

import contextlib
import os
import select
import socket
import threading
import time
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.ground.errors import ProtocolError
from pyros1.net.loop import Loop
from pyros1.node.same_host import host_key
from pyros1.node.strand import Strand

if not host_key():
    pytest.skip("no shared memory on this system", allow_module_level=True)

from pyros1.node.publishing.block_pool import BlockPool, Placement
from pyros1.node.publishing.shared_link import MAX_REFERENCES, SharedLink, WaitingSharedLink
from pyros1.node.publishing.tcp_link import TcpLink
from pyros1.node.subscribing.shared_source import SharedSource
from pyros1.wire.header import HeaderReader

TOKEN = bytes(range(16))
SIZE = 100_000
PATIENCE = 20.0


class Desk:
    """A desk that keeps what is sent, and calls a function before."""

    def __init__(self, desk: socket.socket) -> None:
        self._control_socket = desk
        self.sent: list[bytes] = []
        self.bytes_before: Callable[[], object] = list

    def send(self, record: bytes) -> int:
        self.sent.append(record)
        self.bytes_before()
        return self._control_socket.send(record)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._control_socket, name)


class Ends:
    """A publisher's link, and the source at its other end."""

    def __init__(self, loop: Loop, link_class: type[SharedLink] = SharedLink) -> None:
        near, far = socket.socketpair()
        far.settimeout(PATIENCE)
        self.loop = loop
        self.pool = BlockPool()
        self.ended = threading.Event()
        self.strand = Strand(loop.call_soon, lambda: None)
        args = {"callerid": "/talker", "topic": "/t"}
        self.link = link_class(loop, self.strand, near, args, args, 3, lambda _: self.ended.set(), self.pool, TOKEN)
        self.strand.do(self.link.start)
        data, (desk,), _, _ = socket.recv_fds(far, 65536, 1)
        reader = HeaderReader()
        header = reader.feed(data)
        assert header is not None
        self.desk = Desk(socket.socket(fileno=desk))
        self.source = SharedSource(far, "http://talker", header, reader.bytes_after_header, self.desk)  # type: ignore[arg-type]

    def place(self) -> Placement:
        head = b"head" + SIZE.to_bytes(4, "little")
        frame: list[Any] = [(len(head) + SIZE).to_bytes(4, "little") + head, os.urandom(SIZE)]
        place = self.pool.place(frame, set(self.link.outstanding.values()))
        assert place is not None
        return place

    def send(self) -> None:
        self.do(self.link.send_reference, self.place())

    def receive(self, count: int) -> list[Any]:
        items: list[Any] = []
        until = time.monotonic() + PATIENCE
        while len(items) < count and time.monotonic() < until:
            with contextlib.suppress(BlockingIOError):
                batch = self.source.receive(wait=True)
                assert batch is not None, "the stream ended"
                items += batch.newest(len(batch))
                del batch
        return items

    def outstanding(self) -> set[int]:
        self.do(self.link.receive_releases)
        return set(self.link.outstanding)

    def do(self, function: Callable[..., object], *args: Any) -> None:
        """Run a function in the strand, and wait for it: the loop may work there."""
        done = threading.Event()
        self.strand.do(function, *args)
        self.strand.do(done.set)
        assert done.wait(PATIENCE)


@pytest.fixture
def ends(request: pytest.FixtureRequest) -> Iterator[Ends]:
    loop = Loop("test")
    loop.start()
    made = Ends(loop, getattr(request, "param", SharedLink))
    yield made
    made.source.close()
    made.link.close()
    assert made.ended.wait(PATIENCE)
    made.pool.close()
    loop.stop()


def test_no_more_than_the_credit_is_out(ends: Ends) -> None:
    for _ in range(MAX_REFERENCES + 10):
        ends.send()
    assert len(ends.outstanding()) == MAX_REFERENCES + 3 and ends.link.waiting == 3 and ends.link.dropped == 7
    kept = ends.receive(MAX_REFERENCES)
    assert len(kept) == MAX_REFERENCES
    del kept[:]
    more = ends.receive(3)  # the link has waited for this
    assert len(more) == 3
    del more
    assert not ends.outstanding()


def test_references_are_given_back_within_each_other(ends: Ends) -> None:
    """As when the end of one message, within the sending, ends another one; each goes back once."""
    for _ in range(MAX_REFERENCES):
        ends.send()
    items = ends.receive(MAX_REFERENCES)
    ends.desk.bytes_before = lambda: items and items.pop()
    items.pop()
    sent = ends.desk.sent
    assert len(sent) == len(set(sent)) == MAX_REFERENCES and not ends.outstanding()


@pytest.mark.parametrize("moment", ["bytes_before", "after"])
def test_a_signal_handler_raises(ends: Ends, monkeypatch: pytest.MonkeyPatch, moment: str) -> None:
    """A reference that has not left is not waited for; one that has left is."""
    send = TcpLink.send

    def interrupted(link: TcpLink, frame: Any) -> None:
        if moment == "after":
            send(link, frame)
        raise KeyboardInterrupt

    monkeypatch.setattr(TcpLink, "send", interrupted)
    with pytest.raises(KeyboardInterrupt):
        ends.link.send_reference(ends.place())
    ends.do(ends.link.recover)
    assert len(ends.outstanding()) == (moment == "after")


def test_a_slow_subscriber_costs_no_processor_time(ends: Ends, monkeypatch: pytest.MonkeyPatch) -> None:
    """While references wait for it, the loop sleeps."""
    for _ in range(MAX_REFERENCES + 2):
        ends.send()
    ends.loop.run(lambda: None)
    looks: list[int] = []
    receive_releases = SharedLink.receive_releases
    monkeypatch.setattr(SharedLink, "receive_releases", lambda link: (looks.append(1), receive_releases(link)))
    for _ in range(20):
        ends.loop.run(lambda: None)
    assert len(looks) <= 1
    del ends.receive(MAX_REFERENCES)[:]
    assert len(ends.receive(2)) == 2


def test_what_waits_goes_on_whoever_notes_that_others_came_back(ends: Ends) -> None:
    """Also if a publisher has taken the last record before the loop saw it, and publishes nothing more."""
    for _ in range(MAX_REFERENCES + 2):
        ends.send()
    kept = ends.receive(MAX_REFERENCES)
    busy, leave = threading.Event(), threading.Event()
    ends.loop.call_soon(lambda: busy.set() or leave.wait(PATIENCE))
    assert busy.wait(PATIENCE)
    del kept[:]
    ends.do(ends.link.receive_releases)
    leave.set()
    assert len(ends.receive(2)) == 2


def test_a_subscriber_that_closes_its_desk_has_left(ends: Ends) -> None:
    for _ in range(MAX_REFERENCES + 2):
        ends.send()
    kept = ends.receive(MAX_REFERENCES)
    ends.desk.close()
    assert ends.ended.wait(PATIENCE)
    del kept[:]
    assert ends.link.send_reference(ends.place()), "nothing more is to be sent"


def test_a_publisher_that_takes_nothing_back_costs_no_memory(ends: Ends, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is to be given back would wait without end."""

    def fail() -> None:
        raise BlockingIOError

    monkeypatch.setattr("pyros1.node.subscribing.shared_source.MAX_UNSENT_RELEASES", 2)
    ends.desk.bytes_before = fail
    with pytest.raises(ProtocolError, match="does not read the releases"):
        for _ in range(4):
            ends.send()
            ends.receive(1)
            ends.link.outstanding.clear()


def test_a_message_that_is_too_large_is_not_copied(ends: Ends, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.node.subscribing.shared_source.MAX_MESSAGE_SIZE", SIZE - 1)
    ends.send()
    with pytest.raises(ProtocolError, match="exceeds the limit"):
        ends.receive(1)


def test_a_block_that_was_closed_meanwhile_is_not_referred_to(ends: Ends) -> None:
    """Another subscriber that uses the block leaves between two links: this one gets the message itself."""
    placement = ends.place()
    ends.pool.retire({placement.block.number})
    results: list[bool] = []
    ends.do(lambda: results.append(ends.link.send_reference(placement)))
    assert results == [False] and not ends.outstanding()


@pytest.mark.parametrize("ends", [WaitingSharedLink], indirect=True)
def test_a_publisher_without_a_queue_sleeps_until_references_come_back(
    ends: Ends, monkeypatch: pytest.MonkeyPatch
) -> None:
    for _ in range(MAX_REFERENCES + 1):
        ends.send()
    kept = ends.receive(MAX_REFERENCES)
    sleeps: list[int] = []

    class Poll:
        """Sleeps until the subscriber has released its messages, which it does when the publisher sleeps."""

        def __init__(self) -> None:
            self._poll = real_poll()
            self.register = self._poll.register

        def poll(self, timeout: int) -> object:
            sleeps.append(timeout)
            del kept[:]
            return self._poll.poll(timeout)

    real_poll = select.poll
    monkeypatch.setattr("pyros1.node.publishing.shared_link.select", SimpleNamespace(poll=Poll, POLLIN=select.POLLIN))
    ends.link.finish(time.perf_counter() + 5.0)
    assert sleeps and len(ends.receive(1)) == 1
